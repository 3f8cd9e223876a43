# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The whole joint with other laws than the paper's: balance of forces, equilibrium, truth."""

import numpy as np
import pytest
from vsa_simulator.laws.dampers import DamperConfig
from vsa_simulator.laws.friction import FrictionConfig
from vsa_simulator.laws.internal import HysteresisConfig, ViscoelasticConfig
from vsa_simulator.laws.springs import SPRINGS, SpringConfig
from vsa_simulator.rig.config import RigConfig, SensorConfig, TorqueConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.motion import ProfileConfig
from vsa_simulator.rig.rig import Rig

QUIET = TorqueConfig(constant=0.05, amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
SIDES = {1: (16.39, 0.776, 267.2, 1.089e8, 0.3755), 2: (8.269, 7.031, 165.6, 1.17e8, 0.2295)}
HOLD = ProfileConfig(kind="hold", centre=0.009)


def column(truth, name):
    return truth[:, TRUTH.index(name)]


def test_both_rods_obey_the_balance_of_forces_with_a_quadratic_spring_a_soft_knee_and_stribeck_friction():
    laws = {
        "spring": SpringConfig("quadratic", drift=30.0),
        "damper": DamperConfig("soft_knee"),
        "friction": FrictionConfig("stribeck"),
    }
    truth = Rig(RigConfig(**laws, torque=QUIET)).advance(8000).truth
    scale = 1.0 + 0.005 * column(truth, "time")
    for side, (offset, k1, k2, d2, mass) in SIDES.items():
        x, v, a = (column(truth, f"{name}_{side}") for name in ("deflection", "velocity", "acceleration"))
        rise, peak, u = k1 * np.expm1(k2 * 0.02), np.sqrt(4000.0 / (3.0 * d2)), x / 0.02
        spring = offset + scale * (k1 + rise * (0.08 * u + 0.92 * u**2))
        damper = 4000.0 * peak / 1.5 * np.tanh(1.5 * v / peak)
        friction = 0.3 * (1.0 + np.exp(-((v / 3e-4) ** 2))) * np.tanh(v / 5e-5)
        np.testing.assert_allclose(column(truth, f"force_{side}"), mass * a + spring + damper + friction, rtol=1e-8)
        stiffness = scale * rise / 0.02 * (0.08 + 1.84 * u)
        np.testing.assert_allclose(column(truth, f"stiffness_{side}"), stiffness, rtol=1e-8)
        damping = 4000.0 / np.cosh(1.5 * v / peak) ** 2
        np.testing.assert_allclose(column(truth, f"damping_{side}"), damping, rtol=1e-5)
        assert np.ptp(x) > 1e-3


@pytest.mark.parametrize("kind", SPRINGS)
def test_with_every_spring_the_joint_starts_and_stays_in_equilibrium(kind):
    truth = Rig(RigConfig(spring=SpringConfig(kind), torque=QUIET, profile=HOLD)).advance(1000).truth
    for name in ("angle", "velocity_1", "velocity_2"):
        assert np.abs(column(truth, name)).max() < 1e-8
    np.testing.assert_allclose(column(truth, "deflection_1"), 0.009, atol=1e-9)
    difference = 0.0215 * (column(truth, "tension_2") - column(truth, "tension_1"))
    np.testing.assert_allclose(difference, 0.05, rtol=1e-6)


@pytest.mark.parametrize("kind", SPRINGS)
def test_with_every_spring_the_motion_stays_within_stroke_and_range_of_the_sensors(kind):
    quick = ProfileConfig(frequencies=(0.2, 0.7, 1.7))
    truth = Rig(RigConfig(spring=SpringConfig(kind), profile=quick)).advance(5_500).truth
    for side in (1, 2):
        x, force = column(truth, f"deflection_{side}"), column(truth, f"force_{side}")
        assert x.min() > 0.0
        assert x.max() < 0.020
        assert force.min() > 0.0
        assert force.max() < SensorConfig().force_range


def test_the_force_at_a_held_position_relaxes_after_a_command():
    """After a move the Maxwell branch loses its force; the static truth of stiffness does not see it."""
    laws = {"viscoelastic": ViscoelasticConfig(0.3, 1.0), "hysteresis": HysteresisConfig(0.2)}
    rig = Rig(RigConfig(**laws, profile=HOLD, torque=QUIET))
    start = rig.motors
    for _ in range(600):
        rig.command(start[0] + 0.3, start[1] + 0.3)
        rig.advance(1)
    moved = rig.advance(1).truth[0]
    for _ in range(3000):
        rig.command(start[0] + 0.3, start[1] + 0.3)
        rig.advance(1)
    settled = rig.advance(1).truth[0]
    for side, (_, k1, k2, _, _) in SIDES.items():
        force, x = TRUTH.index(f"force_{side}"), TRUTH.index(f"deflection_{side}")
        assert moved[force] - settled[force] > 0.3
        true = k1 * k2 * np.exp(k2 * np.array([moved[x], settled[x]]))
        stiffness = TRUTH.index(f"stiffness_{side}")
        np.testing.assert_allclose([moved[stiffness], settled[stiffness]], true, rtol=1e-9)
