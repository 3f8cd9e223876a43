# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion of both transmissions during co-contraction: torque balance, unequal dampers, planned stiffness."""

import math

import pytest
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.control.stiffness_range import stiffness_at
from vsa_joint.control.tendon_motion import CoContractionMotion
from vsa_joint.geometry import Joint, TendonPath

DT = 0.01
SPRINGS = (
    ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39, damping=4000.0, peak_speed=3.5e-3),
    ExponentialSpring(0.0, math.log(165.6 * 7.031), 165.6, 8.269, damping=2500.0, peak_speed=4.1e-3),
)
JOINTS = [
    Joint((TendonPath(0.0215, 1e5), TendonPath(0.0215, 1e5))),
    Joint((TendonPath(0.0215, 1e5), TendonPath(0.018, 4e4))),
]


def motion_of(joint, forces):
    motion = CoContractionMotion(joint)
    motion.start(forces[0])
    return [motion.step(force, SPRINGS, DT) for force in forces]


def ramp(start, end, seconds, rest=0.0):
    count = round(seconds / DT)
    return [start + (end - start) * k / count for k in range(count + 1)] + [end] * round(rest / DT)


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("forces", [ramp(25.0, 80.0, 0.8), ramp(80.0, 25.0, 0.8), ramp(25.0, 30.0, 3.0)])
def test_the_torques_balance_and_the_stiffness_is_the_planned_one(joint, forces):
    first, second = joint.paths
    for force, (deflections, moving) in zip(forces, motion_of(joint, forces), strict=True):
        assert first.radius * moving[0] == pytest.approx(second.radius * moving[1], rel=1e-6)
        sigmas = [spring.stiffness_at(x) for spring, x in zip(SPRINGS, deflections, strict=True)]
        now = sum(
            r.radius**2 * s * r.tendon_stiffness / (s + 4.0 * r.tendon_stiffness)
            for r, s in zip(joint.paths, sigmas, strict=True)
        )
        assert now == pytest.approx(stiffness_at(force, 0.0, SPRINGS, joint), rel=0.1)


@pytest.mark.parametrize("joint", JOINTS)
def test_slow_motion_is_that_of_the_springs_alone_and_fast_motion_converges_to_it(joint):
    for forces in (ramp(30.0, 32.0, 60.0), ramp(25.0, 60.0, 0.5, rest=20.0)):
        deflections, moving = motion_of(joint, forces)[-1]
        assert deflections[0] == pytest.approx(SPRINGS[0].deflection(forces[-1]), abs=1e-4)
        assert moving[0] == pytest.approx(forces[-1], rel=0.02)


def test_equal_transmissions_move_together():
    joint, springs = JOINTS[0], (SPRINGS[0], SPRINGS[0])
    motion = CoContractionMotion(joint)
    motion.start(25.0)
    for force in ramp(25.0, 80.0, 0.5):
        deflections, moving = motion.step(force, springs, DT)
        assert deflections[0] == pytest.approx(deflections[1], abs=1e-9)
        assert moving[0] == pytest.approx(moving[1])
