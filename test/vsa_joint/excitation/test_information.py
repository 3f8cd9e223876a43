# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Fisher information against closed forms and against a least-squares fit of simulated noise."""

import numpy as np
import pytest
from rig_runs import model
from vsa_joint.excitation.information import information, wanted_covariance, whiten, whitening_filter
from vsa_joint.excitation.model import COEFFICIENTS, Motion

STEP, RATE = 0.002, 500.0
K2, D1, INERTIA = (COEFFICIENTS.index(name) for name in ("k2", "damping", "inertia"))


def sine(amplitude, frequency, seconds, centre=0.0105):
    time = np.arange(0.0, seconds, STEP)
    omega = 2.0 * np.pi * frequency
    x = amplitude * np.sin(omega * time)
    return Motion(centre + x, amplitude * omega * np.cos(omega * time), -(omega**2) * x)


def linear(**changes):
    """A nearly linear law: a spring of 2000 N/m, a damper without cubic part."""
    return model(k2=1e-3, ln_stiffness=np.log(2000.0), d2=0.0, **changes)


def steady_information(law, motion):
    """Information of one pass of a periodic motion: that of two passes less that of the first, which is from rest."""
    twice = Motion(*(np.concatenate([one, one]) for one in motion))
    return information(law, twice, STEP, RATE) - information(law, motion, STEP, RATE)


@pytest.mark.parametrize("frequency", [0.2, 1.0, 4.0])
def test_the_information_of_a_sine_on_a_linear_law_is_its_closed_form(frequency):
    """N A^2 / 2 over the residual's variance S at this frequency; for damping and mass times w^2 and w^4."""
    amplitude, seconds, law = 1e-4, 20.0, linear()
    omega = 2.0 * np.pi * frequency
    gained = steady_information(law, sine(amplitude, frequency, seconds))
    impedance = complex(2000.0 - law.inertia * omega**2, omega * law.d1)
    variance = law.force_noise_std**2 + abs(impedance) ** 2 * law.deflection_noise_std**2
    expected = seconds * RATE * amplitude**2 / 2.0 / variance
    assert gained[D1, D1] == pytest.approx(omega**2 * expected, rel=0.01)
    assert gained[INERTIA, INERTIA] == pytest.approx(omega**4 * expected, rel=0.01)


def test_the_whitening_filter_has_the_spectrum_of_the_residual():
    law, motion = model(), sine(1e-4, 1.0, 1.0)
    b = whitening_filter(law, motion)
    stiffness, damping = law.stiffness(motion.deflection).mean(), law.damping(motion.velocity).mean()
    for omega in (0.0, 1.0, 10.0, 100.0):
        impedance = complex(stiffness - law.inertia * omega**2, omega * damping)
        residual = law.force_noise_std**2 + abs(impedance) ** 2 * law.deflection_noise_std**2
        s = 1j * omega
        assert abs(b[0] + b[1] * s + b[2] * s * s) ** 2 == pytest.approx(residual, rel=1e-9)


def test_constant_gradients_stay_constant():
    b = np.array([2.0, 0.3, 0.01])
    assert whiten(np.full((100, 1), 4.0), b, STEP) == pytest.approx(np.full((100, 1), 2.0), abs=1e-12)


def test_gradients_are_the_derivatives_of_the_force():
    """Complex-step derivatives of eqs. (2) and (5), below the damper's peak speed."""
    law, x, v = model(), 0.0123, 0.0021
    gradient = law.gradients(Motion(np.array(x), np.array(v), np.array(0.7)))

    def force(s, k2, d1, d2, offset):
        return offset + np.exp(s + k2 * (x - law.deflection_reference)) / k2 + d1 * v + d2 * v**3

    values = [law.ln_stiffness, law.k2, law.d1, law.d2, law.force_offset]
    for place, row in enumerate((0, 1, 2, 3, 5)):
        step = 1e-20 * abs(values[place])
        shifted = [complex(value, step if i == place else 0.0) for i, value in enumerate(values)]
        assert gradient[row] == pytest.approx(force(*shifted).imag / step, rel=1e-12)
    assert gradient[4] == 0.7


def test_the_covariance_is_that_of_fits_to_simulated_noise():
    """Maximum likelihood with noise on force and encoder reaches the bound: 400 fits of damper, mass and level."""
    law, rng = linear(), np.random.default_rng(1)
    motion = Motion(*(a + b for a, b in zip(sine(2e-4, 0.2, 20.0, 0.0), sine(1e-4, 1.0, 20.0, 0.0), strict=True)))
    count = len(motion.deflection)
    rows = [D1, INERTIA, COEFFICIENTS.index("force_offset")]
    bound = np.linalg.inv(steady_information(law, motion)[np.ix_(rows, rows)])
    s = 2j * np.pi * np.fft.rfftfreq(count, STEP)
    impedance = 2000.0 + law.d1 * s + law.inertia * s**2
    amplitude = np.sqrt(law.force_noise_std**2 + np.abs(impedance) ** 2 * law.deflection_noise_std**2)
    regressors = np.stack([motion.velocity, motion.acceleration, np.ones(count)], axis=1)
    white = np.fft.irfft(np.fft.rfft(regressors, axis=0) / amplitude[:, None], count, axis=0)
    fits = []
    for force, deflection in rng.standard_normal((400, 2, count)):
        lines = law.force_noise_std * np.fft.rfft(force) - impedance * law.deflection_noise_std * np.fft.rfft(
            deflection
        )
        fits.append(np.linalg.lstsq(white, np.fft.irfft(lines / amplitude, count), rcond=None)[0])
    # 400 draws: the standard deviation of a standard deviation is 3.5 %
    assert np.std(fits, axis=0) == pytest.approx(np.sqrt(np.diag(bound)), rel=0.12)


def test_the_wanted_covariance_includes_what_the_others_share():
    full = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    covariance = wanted_covariance(np.linalg.inv(full), (0, 2))
    assert covariance == pytest.approx(full[np.ix_([0, 2], [0, 2])])
