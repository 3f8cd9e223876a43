# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The law of one transmission: inverse functions, variances by Monte Carlo, limits of the damper."""

import math

import numpy as np
import pytest
from vsa_joint.control.springs import ExponentialSpring

SPRING = ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39)


def test_force_and_deflection_are_inverse():
    for force in (18.0, 60.0, 170.0):
        assert SPRING.force(SPRING.deflection(force)) == pytest.approx(force)
        assert SPRING.stiffness_at(SPRING.deflection(force)) == pytest.approx(SPRING.stiffness(force))


def test_the_variance_predicted_from_the_force_agrees_with_monte_carlo():
    generator = np.random.default_rng(6)
    covariance = np.array([[7.0, 0.2], [0.2, 0.04]])
    spring = ExponentialSpring(
        0.0, 5.0, 267.2, 16.39, k2_variance=7.0, force_offset_variance=0.04, force_offset_covariance=0.2
    )
    k2, offset = generator.multivariate_normal([267.2, 16.39], covariance, 50_000).T
    assert math.sqrt(spring.force_variance(22.0)) == pytest.approx(np.log(k2 * (22.0 - offset)).std(), rel=0.05)


def test_the_damper_force_is_constant_beyond_its_maximum():
    spring = ExponentialSpring(0.0, 5.0, 267.2, 16.39, damping=4000.0, peak_speed=3.5e-3)
    d2 = -4000.0 / (3.0 * 3.5e-3**2)
    assert spring.damper(2e-3) == pytest.approx(4000.0 * 2e-3 + d2 * 2e-3**3)
    assert spring.damper(-1.0) == pytest.approx(-spring.damper_max) == pytest.approx(-4000.0 * 3.5e-3 * 2.0 / 3.0)
    assert SPRING.damper_max == 0.0
