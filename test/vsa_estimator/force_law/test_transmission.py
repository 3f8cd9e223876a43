# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force law, eqs. (2) to (6), against complex-step derivatives; the damper near its peak speed against quadrature."""

import numpy as np
import pytest
from vsa_estimator.force_law.damper import linearize_near_peak, peak_speed
from vsa_estimator.force_law.state import SIZE
from vsa_estimator.force_law.transmission import force
from vsa_estimator.tuning.force_law import COULOMB_SPEED

TRUTH = np.array([0.010, 1e-3, 1e-2, 8.0, 267.2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3])
REFERENCE = 0.0105
STD = np.array([1e-5, 2e-4, 2e-2, 0.05, 5.0, 200.0, 2e7, 0.2, 0.5, 0.1])


def law(z):
    """Eq. (6) for complex arguments, below v*."""
    x, v, a, s, k2, d1, d2, mass, offset, coulomb = z
    elastic = np.exp(s + k2 * (x - REFERENCE)) / k2 + offset
    return elastic + d1 * v + d2 * v**3 + coulomb * np.tanh(v / COULOMB_SPEED) + mass * a


def law_beyond_peak(z):
    """Eq. (6) beyond v*, with the constant damper force 2/3 d1 v*."""
    x, v, a, s, k2, d1, d2, mass, offset, coulomb = z
    elastic = np.exp(s + k2 * (x - REFERENCE)) / k2 + offset
    peak_force = 2.0 / 3.0 * d1 * np.sqrt(d1 / (-3.0 * d2))
    return elastic + np.sign(v.real) * peak_force + coulomb * np.tanh(v / COULOMB_SPEED) + mass * a


def complex_step_gradient(function, z):
    gradient = np.empty(SIZE)
    for i in range(SIZE):
        shifted = z.astype(complex)
        shifted[i] += 1j * 1e-20 * max(abs(z[i]), 1e-3)
        gradient[i] = function(shifted).imag / (1e-20 * max(abs(z[i]), 1e-3))
    return gradient


CASES = [
    (law, TRUTH),
    (law, TRUTH * np.array([1, -2, 5, 1, 1, 1, 1, 1, 1, 1])),
    (law_beyond_peak, TRUTH + 3e-3 * np.eye(10)[1]),
]


@pytest.mark.parametrize(("function", "z"), CASES)
def test_the_gradient_is_the_complex_step_derivative_of_the_force_law(function, z):
    gradient, hessian = np.empty(SIZE), np.empty((SIZE, SIZE))
    value = force(z, REFERENCE, COULOMB_SPEED, gradient, hessian)
    assert value == pytest.approx(function(z.astype(complex)).real, rel=1e-13)
    expected = complex_step_gradient(function, z)
    assert gradient * STD == pytest.approx(expected * STD, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize(("function", "z"), CASES)
def test_the_hessian_is_the_derivative_of_the_gradient_without_coulomb_friction(function, z):
    hessian = np.empty((SIZE, SIZE))
    smooth = z.copy()
    smooth[9] = 0.0  # the Hessian has no term of the friction: the reversal noise covers it
    force(smooth, REFERENCE, COULOMB_SPEED, np.empty(SIZE), hessian)
    expected = np.empty((SIZE, SIZE))
    for i in range(SIZE):
        h = 1e-4 * STD[i]
        high, low = smooth.copy(), smooth.copy()
        high[i] += h
        low[i] -= h
        expected[i] = (complex_step_gradient(function, high) - complex_step_gradient(function, low)) / (2.0 * h)
    scale = np.outer(STD, STD)
    keep = np.ones((SIZE, SIZE), bool)
    keep[9, :] = keep[:, 9] = False
    assert (hessian * scale)[keep] == pytest.approx((expected * scale)[keep], rel=1e-5, abs=1e-9)


def test_the_slope_of_the_damper_force_vanishes_at_the_peak_speed():
    speed = peak_speed(4000.0, -1.089e8)
    assert 4000.0 + 3.0 * -1.089e8 * speed**2 == pytest.approx(0.0, abs=1e-9)
    assert peak_speed(4000.0, 0.0) == 1.0


@pytest.mark.parametrize("beyond", [-3.0, -1.0, -0.2, 0.2, 1.0, 3.0, -6.0, 6.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def x(beyond, side):
    z = np.array([0.0, 0.0, 0.0, 7.0, 250.0, 5500.0, -1.8e8, 0.3, 20.0, 0.0])
    w = peak_speed(z[5], z[6])
    std = 0.01 * w
    z[1] = side * (w + beyond * std)

    def damper(v):
        c = np.clip(v, -w, w)
        return z[5] * c + z[6] * c**3

    gradient, hessian = np.zeros(SIZE), np.zeros((SIZE, SIZE))
    force(z, 0.0, COULOMB_SPEED, gradient, hessian)
    linearize_near_peak(z, std, gradient, hessian)
    offset_std = np.linspace(-8.0, 8.0, 16001)
    weight = np.exp(-0.5 * offset_std**2) / np.exp(-0.5 * offset_std**2).sum()
    values = damper(z[1] + std * offset_std)
    largest = 6.0 * abs(z[6]) * w * std  # of slopes within one standard deviation
    assert gradient[1] == pytest.approx(
        np.sum(weight * values * offset_std) / std, abs=0.02 * largest * (1.0 + beyond**2)
    )
    mean = np.sum(weight * values) - damper(z[1])
    assert 0.5 * hessian[1, 1] * std**2 == pytest.approx(mean, abs=0.02 * largest * std)
