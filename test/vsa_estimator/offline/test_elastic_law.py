# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Law at knots against closed forms, and the test of the exponential law against laws of known deviation."""

import numpy as np
import pytest
from scipy.integrate import quad
from vsa_estimator.offline.elastic_law import KnotLaw, deviation
from vsa_estimator.tuning.offline import MIN_LAW_DEVIATION

KNOTS = np.array([0.004, 0.006, 0.009, 0.012])
VALUES = np.array([6.0, 7.5, 7.5, 8.1])  # the second segment has a constant stiffness


def law(ln_stiffness=VALUES, std=0.01, knots=KNOTS):
    return KnotLaw(knots, ln_stiffness, std**2 * np.eye(len(knots)), 20.0)


@pytest.mark.parametrize("x", [0.003, 0.004, 0.0052, 0.007, 0.0119, 0.013])
def test_force_is_the_integral_of_the_stiffness(x):
    inner = [knot for knot in KNOTS if min(0.004, x) < knot < max(0.004, x)] or None
    work, _ = quad(lambda at: float(law().stiffness(np.array([at]))[0]), 0.004, x, points=inner, epsrel=1e-11)
    assert law().force(np.array([x]))[0] == pytest.approx(20.0 + work, rel=1e-9)


def test_ln_stiffness_and_its_variance_are_interpolated():
    at = np.array([0.005, 0.006, 0.015])
    assert np.log(law().stiffness(at)) == pytest.approx([6.75, 7.5, 8.7], rel=1e-12)
    assert law().ln_std(at) == pytest.approx([0.01 * 0.5**0.5, 0.01, 0.01 * 5.0**0.5], rel=1e-12)
    low, high = law().band(at)
    assert np.log(high / low) == pytest.approx(2.0 * 1.96 * law().ln_std(at), rel=1e-12)


def test_an_exponential_law_has_no_deviation_and_its_own_k2():
    found = deviation(law(6.0 + 267.2 * (KNOTS - 0.004)))
    assert found.line[1] == pytest.approx(267.2, rel=1e-9)
    assert np.abs(found.ln_stiffness).max() < 1e-9
    assert found.probability == pytest.approx(1.0)
    assert not found.is_significant
    assert not found.where.any()
    assert found.exponential(KNOTS) == pytest.approx(np.exp(6.0 + 267.2 * (KNOTS - 0.004)), rel=1e-9)


def test_a_deviation_is_found_where_it_is():
    knots = np.linspace(0.004, 0.012, 33)
    bump = 0.05 * np.exp(-(((knots - 0.006) / 3e-4) ** 2))
    found = deviation(law(6.0 + 200.0 * knots + bump, 1e-3, knots))
    assert found.is_significant
    assert found.where[np.abs(knots - 0.006) < 2e-4].all()
    assert found.ln_stiffness[np.abs(knots - 0.006) > 1e-3].max() < 0.01  # shift of the fitted line
    assert knots[np.argmax(found.ln_stiffness)] == pytest.approx(0.006)


def test_the_probability_is_uniform_for_an_exponential_law_with_noise():
    knots, std = np.linspace(0.004, 0.012, 20), 0.02
    random = np.random.default_rng(1)
    found = [deviation(law(6.0 + 200.0 * knots + std * random.standard_normal(20), std, knots)) for _ in range(400)]
    below = np.mean([one.probability < 0.25 for one in found])
    assert std > 10.0 * MIN_LAW_DEVIATION  # the floor has no share
    assert below == pytest.approx(0.25, abs=0.08)  # 3.7 standard deviations of 400 draws


def test_a_spring_that_does_not_stiffen_is_not_exponential_with_the_least_k2():
    flat = law(np.full(4, 7.0))
    assert not deviation(flat).is_significant
    found = deviation(flat, 20.0)
    assert found.line[1] == 20.0
    assert found.ln_stiffness == pytest.approx(-20.0 * (KNOTS - KNOTS.mean()), rel=1e-6)
    assert found.is_significant
