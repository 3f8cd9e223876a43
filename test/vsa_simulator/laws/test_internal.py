# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces with memory against closed forms: relaxation of the Maxwell branch, loop and dissipation of the hysteresis.

The rod is moved by its tendon's far end; the internal force is the rod force without inertia, damper and spring.
"""

import numpy as np
import pytest
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.internal import HysteresisConfig, ViscoelasticConfig
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig import single_transmission as single
from vsa_simulator.rig.config import TransmissionConfig
from vsa_simulator.rig.motion import Tone, dwells, tones

SMOOTH = TransmissionConfig(coulomb_friction=0.0)
ELASTIC = 0.776 * np.exp(267.2 * 0.020) - 0.776  # of the linear spring at full stroke [N]
SLOPE = ELASTIC / 0.020  # [N/m]


def run(motion, duration, laws, transmission=SMOOTH):
    """Truth by column, and the internal force [N] of a linear or exponential spring."""
    truth = single.simulate(transmission, motion, duration, 1000, laws)
    columns = dict(zip(single.COLUMNS, truth.T, strict=True))
    x, v, a = columns["deflection"], columns["velocity"], columns["acceleration"]
    elastic = 0.776 + SLOPE * x if laws.spring.kind == "linear" else 0.776 * np.exp(267.2 * x)
    elastic *= 1.0 + laws.spring.drift / 6000.0 * columns["time"]
    peak = np.sqrt(4000.0 / (3 * 1.089e8))
    damper = 4000.0 * np.clip(v, -peak, peak) - 1.089e8 * np.clip(v, -peak, peak) ** 3
    friction = transmission.coulomb_friction * np.tanh(v / 5e-5)
    return columns, columns["force"] - 0.3755 * a - damper - friction - 16.39 - elastic


def loop(x, force):
    """Area that force over deflection encloses [J]."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))


def test_after_a_step_the_viscoelastic_force_relaxes_exponentially_from_its_share_of_the_stiffness():
    laws = ForceLaws(spring=SpringConfig("linear"), viscoelastic=ViscoelasticConfig(share=0.2, time_constant=2.0))
    step = dwells((0.008, 0.010), move=0.1, rest=30.0)
    columns, q = run(step, 14.1, laws)
    after = columns["time"] >= 0.2
    first = 0.2 * SLOPE * (columns["deflection"][200] - columns["deflection"][0])
    expected = first * np.exp(-(columns["time"] - 0.05) / 2.0)  # a step within 0.1 s acts at its middle
    assert np.abs(q - expected)[after].max() < 0.01 * first
    slope = np.polyfit(columns["time"][after], np.log(q[after]), 1)[0]
    assert slope == pytest.approx(-1.0 / 2.0, rel=0.02)


def test_the_branch_stores_at_high_and_dissipates_at_its_own_frequency():
    """Complex stiffness share sigma i w T / (1 + i w T); the loop's area is pi a^2 times its imaginary part."""
    laws = ForceLaws(spring=SpringConfig("linear"), viscoelastic=ViscoelasticConfig(share=0.2, time_constant=0.5))
    for frequency in (0.3, 3.0):
        columns, q = run(tones(0.010, Tone(0.0004, frequency), fade_in=1.0), 8.0 + 1.0 / frequency, laws)
        cycle = columns["time"] >= 8.0
        amplitude = np.ptp(columns["deflection"][cycle]) / 2
        w = 2.0 * np.pi * frequency * 0.5
        expected = np.pi * amplitude**2 * 0.2 * SLOPE * w / (1.0 + w**2)
        assert loop(columns["deflection"][cycle], q[cycle]) == pytest.approx(expected, rel=0.03)


def test_the_hysteresis_saturates_at_its_amplitude_and_closes_a_loop_of_known_area():
    """Bouc-Wen with c = 0 is Dahl's model: y = s - (s - y0) exp(-|x - x0| / delta), s the sign of motion."""
    h, delta, amplitude = 0.6, 4e-4, 0.003
    laws = ForceLaws(spring=SpringConfig("linear"), hysteresis=HysteresisConfig(h, delta, 0.0))
    columns, force = run(tones(0.010, Tone(amplitude, 0.1), fade_in=1.0), 20.0, laws)
    x = columns["deflection"]
    cycle = columns["time"] >= 10.0
    assert np.abs(force).max() == pytest.approx(h, rel=1e-2)
    stroke = np.ptp(x[cycle])
    y0 = np.tanh(stroke / (2 * delta))  # of the closed loop at its reversals
    area = 2 * h * (stroke - (1 + y0) * delta * (1 - np.exp(-stroke / delta)))
    assert loop(x[cycle], force[cycle]) == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize("shape", [0.0, 0.25, 0.5])
def test_the_hysteresis_dissipates_in_every_closed_motion_and_is_rate_independent(shape):
    laws = ForceLaws(spring=SpringConfig("linear"), hysteresis=HysteresisConfig(0.6, 4e-4, shape))
    areas = []
    for frequency in (0.1, 0.4):
        cycles = 4.0 / frequency
        columns, force = run(tones(0.010, Tone(2e-4, frequency), fade_in=1e-3), cycles, laws)
        last = columns["time"] >= 3.0 / frequency
        areas.append(loop(columns["deflection"][last], force[last]))
    assert min(areas) > 0.0
    assert areas[0] == pytest.approx(areas[1], rel=0.03)


def test_the_initial_slope_of_the_hysteresis_is_amplitude_over_travel():
    laws = ForceLaws(spring=SpringConfig("linear"), hysteresis=HysteresisConfig(0.6, 4e-4, 0.5))
    columns, force = run(tones(0.010, Tone(2e-5, 0.5), fade_in=1e-3), 0.5, laws)
    moved = columns["deflection"] - columns["deflection"][0]
    slope = np.polyfit(moved[100:], force[100:], 1)[0]
    assert slope == pytest.approx(0.6 / 4e-4, rel=0.05)


def test_truth_of_stiffness_and_damping_leaves_internal_forces_and_friction_out():
    laws = ForceLaws(
        spring=SpringConfig("linear", drift=10.0),
        viscoelastic=ViscoelasticConfig(0.5, 1.0),
        hysteresis=HysteresisConfig(1.0),
    )
    columns, internal = run(tones(0.010, Tone(0.002, 0.2)), 6.0, laws, TransmissionConfig())
    np.testing.assert_allclose(columns["stiffness"], SLOPE * (1.0 + columns["time"] / 600.0), rtol=1e-9)
    np.testing.assert_allclose(columns["damping"], 4000.0 - 3 * 1.089e8 * columns["velocity"] ** 2, rtol=1e-9)
    assert np.abs(internal).max() > 0.5


def test_the_work_of_the_tendon_is_stored_or_dissipated():
    """Energy balance from rest to rest: in a closed motion only damper, friction and branch take energy."""
    laws = ForceLaws(spring=SpringConfig("linear"), viscoelastic=ViscoelasticConfig(0.3, 0.5))
    columns, q = run(dwells((0.008, 0.011), move=2.5, rest=6.0), 17.0, laws, TransmissionConfig())
    v, dt = columns["velocity"], 1e-3
    damper = 4000.0 * v - 1.089e8 * v**3
    branch = q**2 / (0.3 * SLOPE * 0.5)  # power of the branch's dashpot, q^2 over its damping
    work = np.sum(columns["force"] * v) * dt
    dissipated = np.sum((damper + 0.3 * np.tanh(v / 5e-5)) * v + branch) * dt
    assert work == pytest.approx(dissipated, rel=5e-3)
    assert np.sum(branch) * dt > 0.1 * work
