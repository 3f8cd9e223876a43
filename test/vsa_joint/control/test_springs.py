"""The inverse map: round trips, literal ranges of the paper's rig, and what a load takes away."""

import math

import numpy as np
import pytest
from vsa_joint.control.springs import Spring, force_for, partner_force, reachable, relative_std, stiffness_at
from vsa_joint.impedance.reflection import Joint, TendonPath
from vsa_joint.settings import Limits

R = 0.0215
JOINT = Joint((TendonPath(R, 1e5), TendonPath(R, 1e5)))
FIRST = Spring(0.0, math.log(267.2 * 0.776), 267.2, 16.39)
SECOND = Spring(0.0, math.log(165.6 * 7.031), 165.6, 8.269)
SPRINGS = (FIRST, SECOND)


def test_force_and_deflection_are_inverse():
    for force in (18.0, 60.0, 170.0):
        assert FIRST.force(FIRST.deflection(force)) == pytest.approx(force)
        assert FIRST.stiffness_at(FIRST.deflection(force)) == pytest.approx(FIRST.stiffness(force))


def test_the_paper_rig_reaches_a_third_to_seven_and_a_half():
    found = reachable(0.0, SPRINGS, JOINT, Limits())
    assert found.stiffness_min == pytest.approx(0.30, abs=0.01)
    assert found.stiffness_max == pytest.approx(7.6, abs=0.2)


def test_an_external_torque_narrows_the_range():
    found = reachable(0.5, SPRINGS, JOINT, Limits(force_max=250.0))
    assert found.stiffness_min == pytest.approx(1.17, abs=0.03)
    assert found.stiffness_max == pytest.approx(7.3, abs=0.1)
    tighter = reachable(0.5, SPRINGS, JOINT, Limits(force_max=150.0))
    assert tighter.stiffness_max < found.stiffness_max
    assert reachable(4.0, SPRINGS, JOINT, Limits()) is None


@pytest.mark.parametrize("torque", [-0.3, 0.0, 0.4])
def test_the_force_for_a_stiffness_gives_that_stiffness_and_bears_the_torque(torque):
    within = reachable(torque, SPRINGS, JOINT, Limits())
    force = force_for(2.0, torque, SPRINGS, JOINT, within)
    assert stiffness_at(force, torque, SPRINGS, JOINT) == pytest.approx(2.0, rel=1e-6)
    assert 0.5 * R * (partner_force(force, torque, JOINT) - force) == pytest.approx(torque)


def test_the_predicted_error_agrees_with_monte_carlo():
    generator = np.random.default_rng(5)
    covariance = np.array([[1e-4, 2e-3], [2e-3, 16.0]])
    uncertain = [
        Spring(0.008, math.log(2000.0), k2, f0, 1e-4, 16.0, 2e-3) for k2, f0 in ((267.2, 16.39), (165.6, 8.269))
    ]
    force = 60.0
    nominal = stiffness_at(force, 0.0, tuple(uncertain), JOINT)
    samples = np.zeros(20_000)
    for spring, route in zip(uncertain, JOINT.routes, strict=True):
        x = spring.deflection(force)
        ln, k2 = generator.multivariate_normal([spring.ln_stiffness, spring.k2], covariance, 20_000).T
        sigma = np.exp(ln + k2 * (x - spring.deflection_reference))
        samples += R**2 * sigma * route.tendon_stiffness / (sigma + 4 * route.tendon_stiffness)
    assert relative_std(force, 0.0, tuple(uncertain), JOINT) == pytest.approx(samples.std() / nominal, rel=0.05)


def test_what_is_known_by_the_force_agrees_with_monte_carlo():
    generator = np.random.default_rng(6)
    covariance = np.array([[7.0, 0.2], [0.2, 0.04]])
    spring = Spring(0.0, 5.0, 267.2, 16.39, k2_variance=7.0, force_offset_variance=0.04, force_offset_covariance=0.2)
    k2, offset = generator.multivariate_normal([267.2, 16.39], covariance, 50_000).T
    assert math.sqrt(spring.law_variance(22.0)) == pytest.approx(np.log(k2 * (22.0 - offset)).std(), rel=0.05)


def test_the_damper_is_held_at_its_greatest_force():
    spring = Spring(0.0, 5.0, 267.2, 16.39, damping=4000.0, peak_speed=3.5e-3)
    d2 = -4000.0 / (3.0 * 3.5e-3**2)
    assert spring.damper(2e-3) == pytest.approx(4000.0 * 2e-3 + d2 * 2e-3**3)
    assert spring.damper(-1.0) == pytest.approx(-spring.damper_most) == pytest.approx(-4000.0 * 3.5e-3 * 2.0 / 3.0)
    assert FIRST.damper_most == 0.0
