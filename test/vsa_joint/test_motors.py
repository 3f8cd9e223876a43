"""Motor positions for forces, and how much stiffness the motors' travel leaves within reach."""

import math

import pytest
from vsa_joint.configuration import ControlConfig
from vsa_joint.motors import MotorMap
from vsa_joint.springs import Spring, partner_force, reachable, stiffness_at

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


def test_positions_of_unequal_radii_balance_the_torque():
    motors, joint, _, _ = reach(radius=(0.0215, 0.018))
    first, second = motors.positions(40.0, 0.0, SPRINGS)
    assert first == pytest.approx(MOTORS[0])
    assert second == pytest.approx(MOTORS[1])
    assert partner_force(40.0, 0.0, joint) == pytest.approx(40.0 * 0.0215 / 0.018)
