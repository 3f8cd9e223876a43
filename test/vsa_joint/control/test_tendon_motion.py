"""The way of both rods while their springs are wound up: one torque, unequal dampers, the stiffness that is planned."""

import math

import pytest
from vsa_joint.control.springs import Spring, stiffness_at
from vsa_joint.control.tendon_motion import Rods
from vsa_joint.impedance.reflection import Joint, TendonPath

DT = 0.01
SPRINGS = (
    Spring(0.0, math.log(267.2 * 0.776), 267.2, 16.39, damping=4000.0, peak_speed=3.5e-3),
    Spring(0.0, math.log(165.6 * 7.031), 165.6, 8.269, damping=2500.0, peak_speed=4.1e-3),
)
JOINTS = [
    Joint((TendonPath(0.0215, 1e5), TendonPath(0.0215, 1e5))),
    Joint((TendonPath(0.0215, 1e5), TendonPath(0.018, 4e4))),
]


def way(joint, forces):
    rods = Rods(joint)
    rods.start(forces[0])
    return [rods.step(force, SPRINGS, DT) for force in forces]


def ramp(start, end, seconds, rest=0.0):
    count = round(seconds / DT)
    return [start + (end - start) * k / count for k in range(count + 1)] + [end] * round(rest / DT)


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("forces", [ramp(25.0, 80.0, 0.8), ramp(80.0, 25.0, 0.8), ramp(25.0, 30.0, 3.0)])
def test_both_rods_always_balance_and_the_stiffness_is_the_planned_one(joint, forces):
    first, second = joint.routes
    for force, (deflections, borne) in zip(forces, way(joint, forces), strict=True):
        assert first.radius * borne[0] == pytest.approx(second.radius * borne[1], rel=1e-6)
        sigmas = [spring.stiffness_at(x) for spring, x in zip(SPRINGS, deflections, strict=True)]
        now = sum(
            r.radius**2 * s * r.tendon_stiffness / (s + 4.0 * r.tendon_stiffness)
            for r, s in zip(joint.routes, sigmas, strict=True)
        )
        assert now == pytest.approx(stiffness_at(force, 0.0, SPRINGS, joint), rel=0.1)


@pytest.mark.parametrize("joint", JOINTS)
def test_a_slow_way_is_the_one_of_the_springs_alone_and_a_fast_one_ends_there(joint):
    for forces in (ramp(30.0, 32.0, 60.0), ramp(25.0, 60.0, 0.5, rest=20.0)):
        deflections, borne = way(joint, forces)[-1]
        assert deflections[0] == pytest.approx(SPRINGS[0].deflection(forces[-1]), abs=1e-4)
        assert borne[0] == pytest.approx(forces[-1], rel=0.02)


def test_rods_alike_go_together():
    joint, springs = JOINTS[0], (SPRINGS[0], SPRINGS[0])
    rods = Rods(joint)
    rods.start(25.0)
    for force in ramp(25.0, 80.0, 0.5):
        deflections, borne = rods.step(force, springs, DT)
        assert deflections[0] == pytest.approx(deflections[1], abs=1e-9)
        assert borne[0] == pytest.approx(borne[1])
