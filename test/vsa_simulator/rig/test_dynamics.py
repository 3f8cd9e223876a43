# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The rig against an independent integration: separate equations, scipy's implicit solver, tight tolerances."""

from dataclasses import replace
from math import copysign, exp, log, pi, sin, sqrt, tanh

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.friction import FrictionConfig
from vsa_simulator.rig.config import (
    JointConfig,
    MotorConfig,
    RigConfig,
    SecondTransmissionConfig,
    TorqueConfig,
    TransmissionConfig,
)
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.motion import ProfileConfig, Tone, tones
from vsa_simulator.rig.rig import Rig
from vsa_simulator.rig.single_transmission import COLUMNS, MOTIONS, simulate

T1 = {"F0": 16.39, "k1": 0.776, "k2": 267.2, "d1": 4000.0, "d2": -1.089e8, "d0": 0.3, "m": 0.3755}
T2 = {"F0": 8.269, "k1": 7.031, "k2": 165.6, "d1": 4000.0, "d2": -1.17e8, "d0": 0.3, "m": 0.2295}
KT, R, JOINT_INERTIA, JOINT_DAMPING = 1e5, 0.0215, 1e-3, 0.01


def friction_tanh(p, v, z):
    return p["d0"] * tanh(v / 5e-5), 0.0


def friction_lugre(p, v, z):
    rate = v - 1e6 * abs(v) * z / (p["d0"] + 0.5 * p["d0"] * exp(-((v / 1e-4) ** 2)))
    return 1e6 * z, rate


def rod(p, x, v, z, tension, friction):
    """x'', z' of one rod."""
    peak = sqrt(p["d1"] / (3.0 * abs(p["d2"])))
    c = v if abs(v) < peak else copysign(peak, v)
    dry, rate = friction(p, v, z)
    force = 2.0 * tension - p["F0"] - p["k1"] * exp(p["k2"] * x) - p["d1"] * c - p["d2"] * c**3 - dry
    return force / p["m"], rate


def envelope(t, duration):
    r = min(max(t / duration, 0.0), 1.0)
    return r * r * (3.0 - 2.0 * r)


def reference(rhs, start, times):
    solution = solve_ivp(rhs, (times[0], times[-1]), start, "LSODA", times, rtol=1e-11, atol=1e-14, max_step=2e-3)
    assert solution.success
    return solution.y


def columns(truth, names, *selected):
    return [truth[:, names.index(name)] for name in selected]


def assert_close(actual, expected, relative=1e-6):
    assert np.max(np.abs(actual - expected)) <= relative * np.max(np.abs(expected))


MOVING = ProfileConfig(
    centre=0.009, amplitudes=(0.0011, 0.0001), frequencies=(1.1, 5.0), phases=(0.3, 1.0), fade_in=0.3
)
LOADED = TorqueConfig(0.02, (0.05, 0.03), (1.5, 6.0), (0.0, 1.0), 0.2)


def joint_reference(times, friction):
    """The whole joint of the paper's rig under MOVING and LOADED, from rest in equilibrium."""
    w = 2.0 * pi * 10.0

    def torque(t):
        wave = 0.05 * sin(2 * pi * 1.5 * t) + 0.03 * sin(2 * pi * 6.0 * t + 1.0)
        return 0.02 + envelope(t, 0.2) * wave

    def travels(t):
        wave = 11e-4 * sin(2 * pi * 1.1 * t + 0.3) + 1e-4 * sin(2 * pi * 5.0 * t + 1.0)
        x1 = 0.009 + envelope(t, 0.3) * wave
        f1 = 16.39 + 0.776 * exp(267.2 * x1)
        f2 = f1 + 2.0 * 0.02 / R
        x2 = log((f2 - 8.269) / 7.031) / 165.6
        return ([2 * x1 + f1 / 2e5 + R * 0.05, 2 * x2 + f2 / 2e5 - R * 0.05], x1, x2)

    def rhs(t, y):
        angle, speed, x1, v1, z1, x2, v2, z2, q1, w1, q2, w2 = y
        t1, t2 = KT * (q1 - R * angle - 2.0 * x1), KT * (q2 + R * angle - 2.0 * x2)
        a1, b1 = rod(T1, x1, v1, z1, t1, friction)
        a2, b2 = rod(T2, x2, v2, z2, t2, friction)
        targets, _, _ = travels(t + 2.0 / w)
        motors = [w * w * (targets[0] - q1) - 2 * w * w1, w * w * (targets[1] - q2) - 2 * w * w2]
        turn = (R * (t1 - t2) - JOINT_DAMPING * speed + torque(t)) / JOINT_INERTIA
        return [speed, turn, v1, a1, b1, v2, a2, b2, w1, motors[0], w2, motors[1]]

    q, x1, x2 = travels(0.0)
    return reference(rhs, [0.05, 0.0, x1, 0.0, 0.0, x2, 0.0, 0.0, q[0], 0.0, q[1], 0.0], times)


@pytest.mark.parametrize(("model", "friction"), [("tanh", friction_tanh), ("lugre", friction_lugre)])
def test_the_joint_equals_an_independent_integration(model, friction):
    fast = MotorConfig(speed_limit=1000.0)
    rig = Rig(
        RigConfig(
            friction=FrictionConfig(model=model),
            joint=JointConfig(equilibrium_angle=0.05),
            torque=LOADED,
            motors=fast,
            profile=MOVING,
        )
    )
    truth = rig.advance(701).truth
    times = truth[:, 0]
    expected = joint_reference(times, friction)
    names = ("angle", "deflection_1", "velocity_1", "deflection_2", "velocity_2")
    tolerance = 1e-6 if model == "tanh" else 1e-5  # the bristle rate is not smooth at v = 0
    for name, row in zip(names, expected[[0, 2, 3, 5, 6]], strict=True):
        assert_close(truth[:, TRUTH.index(name)], row, tolerance)
    assert_close(truth[:, TRUTH.index("motor_1")], expected[8] / 0.010, tolerance)
    force = 2.0 * KT * (expected[8] - R * expected[0] - 2.0 * expected[2])
    assert_close(truth[:, TRUTH.index("force_1")], force, tolerance)
    assert np.abs(truth[:, TRUTH.index("velocity_1")]).max() > 3.5e-3  # beyond the maximum of the damper's force


def test_a_single_transmission_equals_an_independent_integration():
    motion = tones(0.010, Tone(0.0008, 1.3), Tone(0.0001, 6.0, 1.0), fade_in=0.4)
    truth = simulate(SecondTransmissionConfig(), motion, 0.9, 1000)

    def rhs(t, y):
        wave = 8e-4 * sin(2 * pi * 1.3 * t) + 1e-4 * sin(2 * pi * 6.0 * t + 1.0)
        travel = 2.0 * (0.010 + envelope(t, 0.4) * wave) + (8.269 + 7.031 * exp(165.6 * 0.010)) / (2.0 * KT)
        acceleration, _ = rod(T2, y[0], y[1], 0.0, KT * (travel - 2.0 * y[0]), friction_tanh)
        return [y[1], acceleration]

    expected = reference(rhs, [0.010, 0.0], truth[:, 0])
    deflection, velocity = columns(truth, COLUMNS, "deflection", "velocity")
    assert_close(deflection, expected[0])
    assert_close(velocity, expected[1])


def test_the_force_is_the_sum_of_inertia_damper_and_spring():
    truth = simulate(TransmissionConfig(), MOTIONS["multisine"], 12.0, 100)
    x, v, a, force = columns(truth, COLUMNS, "deflection", "velocity", "acceleration", "force")
    spring = 16.39 + 0.776 * np.exp(267.2 * x)
    damper = 0.3 * np.tanh(v / 5e-5) + 4000.0 * v - 1.089e8 * v**3
    assert_close(force, 0.3755 * a + damper + spring, 1e-12)


def test_stiffness_and_damping_are_the_slopes_of_spring_and_damper():
    truth = simulate(TransmissionConfig(), MOTIONS["fast"], 20.0, 100)
    x, v, k, d = columns(truth, COLUMNS, "deflection", "velocity", "stiffness", "damping")
    h = 1e-7
    slope = 0.776 * (np.exp(267.2 * (x + h)) - np.exp(267.2 * (x - h))) / (2 * h)
    np.testing.assert_allclose(k, slope, rtol=1e-8)
    below = np.abs(v) < 3.499e-3
    assert 0 < below.sum() < len(v)
    np.testing.assert_allclose(d[below], 4000.0 - 3.0 * 1.089e8 * v[below] ** 2, rtol=1e-10)
    assert np.abs(d[np.abs(v) > 3.5e-3]).max() < 1e-9  # the constant force has no slope


def test_a_heavy_mass_oscillates_on_its_tendon_at_its_natural_frequency():
    heavy = TransmissionConfig(d1=10.0, d2=-1.0e4, coulomb_friction=0.0, inertia=375.5)
    step = tones(0.010, Tone(0.0002, 0.0001, np.pi / 2), fade_in=0.0)  # a step at time 0, then constant
    truth = simulate(heavy, step, 4.0, 1000)
    x = truth[:, 1] - truth[:, 1].mean()
    rising = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    frequency = (len(rising) - 1) / (truth[rising[-1], 0] - truth[rising[0], 0])
    expected = np.sqrt((4.0 * KT + 267.2 * 0.776 * np.exp(267.2 * 0.0102)) / 375.5) / (2 * np.pi)
    assert frequency == pytest.approx(expected, rel=2e-3)


def test_the_tension_of_a_tendon_is_never_negative():
    low = ProfileConfig(kind="hold", centre=0.002)
    rig = Rig(RigConfig(profile=low, torque=TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))))
    rig.set_disturbance(3.0)  # more than the tendons' tension can balance
    truth = rig.advance(300).truth
    tension_1, tension_2, force_2 = columns(truth, TRUTH, "tension_1", "tension_2", "force_2")
    assert tension_1.min() == 0.0
    assert tension_2.min() > 0.0
    np.testing.assert_array_equal(force_2, 2.0 * tension_2)


def test_the_joint_rests_where_torque_and_tensions_balance():
    quiet = TorqueConfig(constant=0.3, amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
    rig = Rig(RigConfig(profile=ProfileConfig(kind="hold", centre=0.012), torque=quiet))
    truth = rig.advance(2000).truth
    angle, t1, t2 = columns(truth, TRUTH, "angle", "tension_1", "tension_2")
    assert np.abs(angle).max() < 1e-9
    np.testing.assert_allclose(R * (t2 - t1), 0.3, rtol=1e-9)


def test_a_small_torque_turns_the_joint_by_torque_over_stiffness():
    still = TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
    config = RigConfig(
        transmission_1=replace(TransmissionConfig(), coulomb_friction=0.0),
        transmission_2=replace(SecondTransmissionConfig(), coulomb_friction=0.0),
        profile=ProfileConfig(kind="hold", centre=0.009),
        torque=still,
    )
    rig = Rig(config)
    before = rig.advance(1).truth[0]
    rig.set_disturbance(1e-4)
    angle = rig.advance(15000).truth[-1, TRUTH.index("angle")]
    sigma = before[[TRUTH.index("stiffness_1"), TRUTH.index("stiffness_2")]]
    stiffness = R**2 * np.sum(sigma * KT / (sigma + 4.0 * KT))
    assert angle == pytest.approx(1e-4 / stiffness, rel=1e-3)


def test_lugre_friction_gives_stick_slip_in_slow_motion():
    creep = tones(0.010, Tone(2e-4, 0.02), fade_in=0.0)
    stick = FrictionConfig(model="lugre", static_ratio=3.0, bristle_stiffness=5e7)
    dry = TransmissionConfig(d1=200.0, d2=-1e6, coulomb_friction=10.0)
    velocity = simulate(dry, creep, 12.0, 1000, ForceLaws(friction=stick))[:, 2]
    assert np.mean(np.abs(velocity) < 1e-6) > 0.3  # it sticks much of the time
    assert np.abs(velocity).max() > 10 * 2 * np.pi * 0.02 * 2e-4  # and then slips
