# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The law of one transmission: inverse functions, variances by Monte Carlo, limits of the damper."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from vsa_joint.control.springs import Spring, identified_spring

SPRING = Spring(0.0, math.log(267.2 * 0.776), 267.2, 16.39)


def test_force_and_deflection_are_inverse():
    for force in (18.0, 60.0, 170.0):
        assert SPRING.force(SPRING.deflection(force)) == pytest.approx(force)
        assert SPRING.stiffness_at(SPRING.deflection(force)) == pytest.approx(SPRING.stiffness(force))


def test_the_variance_predicted_from_the_force_agrees_with_monte_carlo():
    generator = np.random.default_rng(6)
    covariance = np.array([[7.0, 0.2], [0.2, 0.04]])
    spring = Spring(0.0, 5.0, 267.2, 16.39, k2_variance=7.0, force_offset_variance=0.04, force_offset_covariance=0.2)
    k2, offset = generator.multivariate_normal([267.2, 16.39], covariance, 50_000).T
    assert math.sqrt(spring.force_variance(22.0)) == pytest.approx(np.log(k2 * (22.0 - offset)).std(), rel=0.05)


def test_the_damper_force_is_constant_beyond_its_maximum():
    spring = Spring(0.0, 5.0, 267.2, 16.39, damping=4000.0, peak_speed=3.5e-3)
    d2 = -4000.0 / (3.0 * 3.5e-3**2)
    assert spring.damper(2e-3) == pytest.approx(4000.0 * 2e-3 + d2 * 2e-3**3)
    assert spring.damper(-1.0) == pytest.approx(-spring.damper_max) == pytest.approx(-4000.0 * 3.5e-3 * 2.0 / 3.0)
    assert SPRING.damper_max == 0.0


def state(**changes):
    values = {"deflection_reference": 0.01, "ln_stiffness_reference": 7.0, "k2": 250.0, "d1": 4000.0, "d2": -1e8}
    values |= {"force_offset": 12.0, "coefficient_covariance": [float(i) for i in range(49)]}
    return SimpleNamespace(**values | changes)


def test_a_spring_has_the_coefficients_of_the_state():
    expected = Spring(
        deflection_reference=0.01,
        ln_stiffness=7.0,
        k2=250.0,
        force_offset=12.0,
        ln_stiffness_variance=0.0,
        k2_variance=8.0,
        covariance=1.0,
        damping=4000.0,
        peak_speed=math.sqrt(4000.0 / 3e8),
        force_offset_variance=40.0,
        force_offset_covariance=12.0,
    )
    assert identified_spring(state()) == expected
    assert identified_spring(state(d2=0.0)).peak_speed == math.inf


@pytest.mark.parametrize(
    "changes",
    [{"k2": 0.0}, {"k2": math.nan}, {"force_offset": math.inf}, {"ln_stiffness_reference": 51.0},
     {"coefficient_covariance": [math.nan] * 49}],
)  # fmt: skip
def test_coefficients_that_are_not_usable_give_no_spring(changes):
    assert identified_spring(state(**changes)) is None
