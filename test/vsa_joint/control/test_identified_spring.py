# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The law of one transmission from the state of its estimator: exponential, and by knots."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from vsa_joint.control.identified_spring import KnotSpring, identified_spring
from vsa_joint.control.springs import ExponentialSpring

KNOTS = np.linspace(0.004, 0.016, 13)
QUADRATIC = 6e5  # N/m^2: force 20 + 6e5 x^2 / 2


def by_knots(ln_stiffness, first_force, covariance=None, **damper):
    covariance = np.zeros((13, 13)) if covariance is None else covariance
    return KnotSpring(
        tuple(KNOTS.tolist()), tuple(ln_stiffness.tolist()), tuple(covariance.ravel().tolist()), first_force, **damper
    )


def quadratic(covariance=None):
    return by_knots(np.log(QUADRATIC * KNOTS), 20.0 + 0.5 * QUADRATIC * KNOTS[0] ** 2, covariance)


def test_knots_on_an_exponential_are_the_exponential_law():
    exponential = ExponentialSpring(0.01, 7.0, 250.0, 12.0)
    spring = by_knots(7.0 + 250.0 * (KNOTS - 0.01), exponential.force(float(KNOTS[0])))
    for x in (0.002, 0.0071, 0.0123, 0.02):  # also beyond the knots
        force = exponential.force(x)
        assert spring.force(x) == pytest.approx(force, rel=1e-12)
        assert spring.deflection(force) == pytest.approx(x, rel=1e-9)
        assert spring.stiffness(force) == pytest.approx(exponential.stiffness(force), rel=1e-9)
        assert spring.slope_at(x) == pytest.approx(250.0, rel=1e-9)


@pytest.mark.parametrize("x", [0.0045, 0.01, 0.0155])
def test_knots_interpolate_a_quadratic_spring(x):
    spring, force = quadratic(), 20.0 + 0.5 * QUADRATIC * x * x
    assert spring.deflection(force) == pytest.approx(x, rel=2e-3)
    assert spring.stiffness(force) == pytest.approx(QUADRATIC * x, rel=6e-3)
    assert spring.force(spring.deflection(force)) == pytest.approx(force, rel=1e-12)


def test_a_linear_spring_has_no_slope():
    spring = by_knots(np.full(13, 8.0), 20.0)
    assert spring.deflection(20.0 + math.exp(8.0) * 0.005) == pytest.approx(0.009)
    assert (spring.stiffness(25.0), spring.slope_at(0.01)) == (pytest.approx(math.exp(8.0)), 0.0)


def test_no_force_is_below_the_range_of_the_logarithm():
    spring = quadratic()
    assert math.isfinite(spring.deflection(-1e3))
    assert spring.stiffness(-1e3) > 0.0
    assert spring.slack_force == -math.inf  # a fast shortening may bear less than the least force at rest
    assert spring.least_force == pytest.approx(20.0 + 0.5 * QUADRATIC * KNOTS[0] ** 2)


def test_the_variance_is_that_of_the_interpolated_logarithm():
    generator = np.random.default_rng(3)
    factor = 0.02 * generator.standard_normal((13, 13))
    spring = quadratic(factor @ factor.T)
    force = spring.force(0.0107)
    samples = generator.multivariate_normal(spring.ln_stiffness, factor @ factor.T, 50_000)
    at = [np.interp(0.0107, KNOTS, one) for one in samples]
    assert math.sqrt(spring.position_variance(force)) == pytest.approx(np.std(at), rel=0.02)
    assert spring.force_variance(force) == spring.position_variance(force)


def state(**changes):
    values = {"deflection_reference": 0.01, "ln_stiffness_reference": 7.0, "k2": 250.0, "d1": 4000.0, "d2": -1e8}
    values |= {"force_offset": 12.0, "coefficient_covariance": [float(i) for i in range(49)]}
    values |= {"elastic_force": 0.0, "elastic_deflection": [0.0, 1.0]}
    return SimpleNamespace(**values | changes)


def test_a_spring_has_the_coefficients_of_the_state():
    expected = ExponentialSpring(
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


def test_more_than_two_knots_are_a_law_by_knots():
    spring = identified_spring(state(**THREE_KNOTS))
    assert isinstance(spring, KnotSpring)
    assert (spring.knots, spring.ln_stiffness, spring.first_force) == ((0.0, 0.01, 0.02), (6.0, 7.0, 7.5), 21.0)
    assert (spring.damping, spring.peak_speed) == (4000.0, pytest.approx(math.sqrt(4000.0 / 3e8)))


@pytest.mark.parametrize(
    "changes",
    [{"elastic_force": math.nan}, {"elastic_deflection": [0.0, 0.02, 0.01]}, {"elastic_ln_stiffness": [6.0, 7.0]},
     {"elastic_ln_stiffness": [6.0, 7.0, 51.0]}, {"elastic_ln_stiffness_covariance": [0.0] * 4}],
)  # fmt: skip
def test_knots_that_are_not_usable_give_no_spring(changes):
    assert identified_spring(state(**THREE_KNOTS | changes)) is None


THREE_KNOTS = {
    "k2": 0.0, "elastic_force": 21.0, "elastic_deflection": [0.0, 0.01, 0.02], "elastic_ln_stiffness": [6.0, 7.0, 7.5],
    "elastic_ln_stiffness_covariance": [0.0] * 9,
}  # fmt: skip
