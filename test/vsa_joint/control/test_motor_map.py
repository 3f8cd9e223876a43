# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motor positions for forces, and the part of the stiffness range that the motors reach."""

import math

import pytest
from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.control.stiffness_range import force_for, reachable_range, stiffness_at
from vsa_joint.settings import ControlConfig

SPRINGS = (
    ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    ExponentialSpring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)
MOTORS = (2.6, 2.2)


def ranges(torque=0.0, angle=0.0, **config):
    config = ControlConfig(**config)
    motors = MotorMap(config)
    motors.fit_zero(MOTORS, 40.0, 0.0, SPRINGS)
    reachable = reachable_range(torque, SPRINGS, config.joint, config)
    return motors, config.joint, reachable, motors.clip_to_motors(reachable, torque, angle, SPRINGS)


def test_motors_with_spare_travel_do_not_clip_the_range():
    _, _, reachable, clipped = ranges()
    assert clipped == reachable


@pytest.mark.parametrize("radius", [(0.0215, 0.0215), (0.0215, 0.018)])
@pytest.mark.parametrize(("limit", "of"), [({"motor_max": 3.0}, max), ({"motor_min": 2.0}, min)])
def test_at_the_end_of_the_range_a_motor_is_at_its_limit(limit, of, radius):
    motors, joint, reachable, clipped = ranges(torque=0.1, radius=radius, **limit)
    force = clipped.force_max if of is max else clipped.force_min
    assert of(motors.positions(force, 0.0, SPRINGS)) == pytest.approx(*limit.values(), abs=1e-6)
    assert reachable.stiffness_min <= clipped.stiffness_min < clipped.stiffness_max <= reachable.stiffness_max
    assert clipped != reachable
    stiffness = clipped.stiffness_max if of is max else clipped.stiffness_min
    assert stiffness == pytest.approx(stiffness_at(force, 0.1, SPRINGS, joint))


def test_an_angle_clips_the_range_and_a_large_one_leaves_none():
    *_, straight = ranges(motor_max=3.0)
    *_, turned = ranges(motor_max=3.0, angle=0.1)
    assert turned.stiffness_max < straight.stiffness_max
    assert ranges(angle=3.0)[-1] is None


def torque_on(angle, motors, zero, config):
    """Torque of both tendons at a joint angle [rad]; bisection finds each force from the tendon travel of its motor."""
    total = 0.0
    for index, sign in ((0, 1.0), (1, -1.0)):
        radius, tendon = config.radius[index], config.tendon_stiffness[index]
        travel = config.motor_pulley_radius * (motors[index] - zero[index]) - sign * radius * angle
        low, high = SPRINGS[index].force_offset + 1e-3, 300.0
        for _ in range(60):
            force = 0.5 * (low + high)
            needed = 2.0 * SPRINGS[index].deflection(force) + force / (2.0 * tendon)
            low, high = (force, high) if needed < travel else (low, force)
        total += sign * radius * 0.5 * force
    return total


@pytest.mark.parametrize("angle", [0.0, 0.1])
@pytest.mark.parametrize(
    "geometry", [{}, {"radius": (0.0215, 0.018)}, {"tendon_stiffness": (1e5, 2e4)}, {"radius": (0.025, 0.02)}]
)
def test_the_positions_give_the_commanded_equilibrium_and_stiffness(geometry, angle):
    config = ControlConfig(**geometry)
    motors = MotorMap(config)
    zero = motors.positions(40.0, 0.0, SPRINGS)
    motors.fit_zero((0.0, 0.0), 40.0, 0.0, SPRINGS)
    reachable = reachable_range(0.0, SPRINGS, config.joint, config)
    for stiffness in (0.6, 1.5, 3.0):
        force = force_for(stiffness, 0.0, SPRINGS, config.joint, reachable)
        positions = motors.positions(force, angle, SPRINGS)
        start = [-position for position in zero]
        assert torque_on(angle, positions, start, config) == pytest.approx(0.0, abs=1e-6)
        step = 1e-4
        fall = torque_on(angle - step, positions, start, config) - torque_on(angle + step, positions, start, config)
        assert fall / (2.0 * step) == pytest.approx(stiffness, rel=1e-4)
