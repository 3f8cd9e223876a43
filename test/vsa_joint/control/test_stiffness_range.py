# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The inverse of the stiffness: round trips, literal ranges of the paper's rig, effect of an external torque."""

import math

import numpy as np
import pytest
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.control.stiffness_range import (
    force_for,
    force_rate,
    partner_force,
    reachable_range,
    relative_std,
    stiffness_at,
    tendon_travel,
)
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.settings import Limits

R = 0.0215
JOINT = Joint((TendonPath(R, 1e5), TendonPath(R, 1e5)))
SPRINGS = (
    ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    ExponentialSpring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)


def test_the_reachable_stiffness_of_the_paper_rig_is_a_third_to_seven_and_a_half():
    reachable = reachable_range(0.0, SPRINGS, JOINT, Limits())
    assert reachable.stiffness_min == pytest.approx(0.30, abs=0.01)
    assert reachable.stiffness_max == pytest.approx(7.6, abs=0.2)


def test_an_external_torque_narrows_the_range():
    reachable = reachable_range(0.5, SPRINGS, JOINT, Limits(force_max=250.0))
    assert reachable.stiffness_min == pytest.approx(1.17, abs=0.03)
    assert reachable.stiffness_max == pytest.approx(7.3, abs=0.1)
    tighter = reachable_range(0.5, SPRINGS, JOINT, Limits(force_max=150.0))
    assert tighter.stiffness_max < reachable.stiffness_max
    assert reachable_range(4.0, SPRINGS, JOINT, Limits()) is None


@pytest.mark.parametrize("torque", [-0.3, 0.0, 0.4])
def test_the_force_for_a_stiffness_gives_that_stiffness_in_equilibrium_with_the_torque(torque):
    reachable = reachable_range(torque, SPRINGS, JOINT, Limits())
    force = force_for(2.0, torque, SPRINGS, JOINT, reachable)
    assert stiffness_at(force, torque, SPRINGS, JOINT) == pytest.approx(2.0, rel=1e-6)
    assert 0.5 * R * (partner_force(force, torque, JOINT) - force) == pytest.approx(torque)


def test_the_predicted_error_agrees_with_monte_carlo():
    generator = np.random.default_rng(5)
    covariance = np.array([[1e-4, 2e-3], [2e-3, 16.0]])
    uncertain = [
        ExponentialSpring(0.008, math.log(2000.0), k2, f0, 1e-4, 16.0, 2e-3)
        for k2, f0 in ((267.2, 16.39), (165.6, 8.269))
    ]
    force = 60.0
    nominal = stiffness_at(force, 0.0, tuple(uncertain), JOINT)
    samples = np.zeros(20_000)
    for spring, path in zip(uncertain, JOINT.paths, strict=True):
        x = spring.deflection(force)
        ln, k2 = generator.multivariate_normal([spring.ln_stiffness, spring.k2], covariance, 20_000).T
        sigma = np.exp(ln + k2 * (x - spring.deflection_reference))
        samples += R**2 * sigma * path.tendon_stiffness / (sigma + 4 * path.tendon_stiffness)
    assert relative_std(force, 0.0, tuple(uncertain), JOINT) == pytest.approx(samples.std() / nominal, rel=0.05)


@pytest.mark.parametrize("joint", [JOINT, Joint((TendonPath(R, 1e5), TendonPath(0.018, 2e4)))])
def test_the_faster_motor_winds_with_the_given_rate(joint):
    rate, dt = force_rate(60.0, 0.04, SPRINGS, joint), 1e-6

    def travel(force):
        forces = force, partner_force(force, 0.0, joint)
        return np.array(
            [
                tendon_travel(f, spring.deflection(f), path.tendon_stiffness)
                for f, spring, path in zip(forces, SPRINGS, joint.paths, strict=True)
            ]
        )

    speeds = (travel(60.0 + rate * dt) - travel(60.0)) / dt
    assert speeds.max() == pytest.approx(0.04, rel=1e-3)
