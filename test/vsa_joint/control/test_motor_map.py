"""Motor positions for forces, and how much stiffness the motors' travel leaves within reach."""

import math

import pytest
from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.springs import Spring, force_for, reachable, stiffness_at
from vsa_joint.settings import ControlConfig

SPRINGS = (
    Spring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    Spring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)
MOTORS = (2.6, 2.2)


def reach(torque=0.0, angle=0.0, **config):
    config = ControlConfig(**config)
    motors = MotorMap(config)
    motors.fit(MOTORS, 40.0, 0.0, SPRINGS)
    found = reachable(torque, SPRINGS, config.joint, config)
    return motors, config.joint, found, motors.narrowed(found, torque, angle, SPRINGS)


def test_motors_with_travel_to_spare_leave_the_range_as_it_is():
    _, _, found, narrowed = reach()
    assert narrowed == found


@pytest.mark.parametrize("radius", [(0.0215, 0.0215), (0.0215, 0.018)])
@pytest.mark.parametrize(("limit", "of"), [({"motor_max": 3.0}, max), ({"motor_min": 2.0}, min)])
def test_at_the_end_of_the_range_a_motor_is_at_its_limit(limit, of, radius):
    motors, joint, found, narrowed = reach(torque=0.1, radius=radius, **limit)
    force = narrowed.force_max if of is max else narrowed.force_min
    assert of(motors.positions(force, 0.0, SPRINGS)) == pytest.approx(*limit.values(), abs=1e-6)
    assert found.stiffness_min <= narrowed.stiffness_min < narrowed.stiffness_max <= found.stiffness_max
    assert narrowed != found
    stiffness = narrowed.stiffness_max if of is max else narrowed.stiffness_min
    assert stiffness == pytest.approx(stiffness_at(force, 0.1, SPRINGS, joint))


def test_an_angle_takes_travel_from_one_motor_and_too_much_of_it_leaves_nothing():
    *_, straight = reach(motor_max=3.0)
    *_, turned = reach(motor_max=3.0, angle=0.1)
    assert turned.stiffness_max < straight.stiffness_max
    assert reach(angle=3.0)[-1] is None


def torque_on(angle, motors, zero, config):
    """Of both tendons at a joint angle, each side's force found from how far its motor has wound it up."""
    total = 0.0
    for side, sign in ((0, 1.0), (1, -1.0)):
        radius, tendon = config.radius[side], config.tendon_stiffness[side]
        wound = config.motor_pulley_radius * (motors[side] - zero[side]) - sign * radius * angle
        low, high = SPRINGS[side].force_offset + 1e-3, 300.0
        for _ in range(60):
            force = 0.5 * (low + high)
            reached = 2.0 * SPRINGS[side].deflection(force) + force / (2.0 * tendon)
            low, high = (force, high) if reached < wound else (low, force)
        total += sign * radius * 0.5 * force
    return total


@pytest.mark.parametrize("angle", [0.0, 0.1])
@pytest.mark.parametrize(
    "sides", [{}, {"radius": (0.0215, 0.018)}, {"tendon_stiffness": (1e5, 2e4)}, {"radius": (0.025, 0.02)}]
)
def test_the_positions_rest_where_they_shall_and_are_as_stiff_as_they_shall(sides, angle):
    config = ControlConfig(**sides)
    motors = MotorMap(config)
    zero = motors.positions(40.0, 0.0, SPRINGS)
    motors.fit((0.0, 0.0), 40.0, 0.0, SPRINGS)
    found = reachable(0.0, SPRINGS, config.joint, config)
    for stiffness in (0.6, 1.5, 3.0):
        force = force_for(stiffness, 0.0, SPRINGS, config.joint, found)
        positions = motors.positions(force, angle, SPRINGS)
        start = [-position for position in zero]
        assert torque_on(angle, positions, start, config) == pytest.approx(0.0, abs=1e-6)
        step = 1e-4
        fall = torque_on(angle - step, positions, start, config) - torque_on(angle + step, positions, start, config)
        assert fall / (2.0 * step) == pytest.approx(stiffness, rel=1e-4)
