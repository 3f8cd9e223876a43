# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Spline bases against scipy's B-splines and quadrature."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline
from vsa_estimator.general.basis import add_integrals, cubic, cubic_slope, damper_integrals, damping_spline, locate
from vsa_estimator.general.models import geometry_at
from vsa_estimator.general.records import DAMPER_SIZE, INTERVALS, SPRING_SIZE
from vsa_estimator.settings import Initial

GEOMETRY = geometry_at(Initial(), 0.010, 240.0)
ORIGIN, SPACING, REFERENCE = (float(GEOMETRY[name][0]) for name in ("origin", "spacing", "reference"))
END = ORIGIN + INTERVALS * SPACING
SPEED_SPACING = 5e-4
LAST_KNOT = (DAMPER_SIZE - 2) * SPEED_SPACING


def spring_spline(x):
    """All cubic B-splines at x, constant beyond the ends."""
    knots = ORIGIN + SPACING * np.arange(-3, INTERVALS + 4)
    inside = min(max(x, ORIGIN), END - 1e-12)
    return np.array([BSpline(knots, unit, 3)(inside) for unit in np.eye(SPRING_SIZE)])


def damper_spline(v):
    """All quadratic B-splines at |v|, constant beyond the last knot."""
    knots = SPEED_SPACING * np.arange(-2, DAMPER_SIZE + 1)
    inside = min(abs(v), LAST_KNOT - 1e-13)
    return np.array([BSpline(knots, unit, 2)(inside) for unit in np.eye(DAMPER_SIZE)])


def integrals_to(x):
    i, _ = locate(x, ORIGIN, SPACING)
    out = GEOMETRY["table"][0][i].copy()
    add_integrals(GEOMETRY, i, ORIGIN + i * SPACING, x, out)
    return out


@pytest.mark.parametrize("u", [0.0, 0.2, 0.7, 1.0])
def test_cubic_splines_sum_to_one_and_their_slopes_to_zero(u):
    w, slope, above, below = (np.empty(4) for _ in range(4))
    cubic(u, w)
    cubic_slope(u, slope)
    cubic(u + 1e-6, above)
    cubic(u - 1e-6, below)
    assert w.sum() == pytest.approx(1.0, abs=1e-14)
    assert slope.sum() == pytest.approx(0.0, abs=1e-14)
    assert slope == pytest.approx((above - below) / 2e-6, abs=1e-8)


@pytest.mark.parametrize("x", [ORIGIN - 1e-3, ORIGIN, 0.0042, REFERENCE, 0.01231, END - 1e-9, END + 2e-3])
def test_located_splines_are_those_of_scipy(x):
    w, expected = np.empty(4), spring_spline(x)
    i, u = locate(x, ORIGIN, SPACING)
    cubic(u, w)
    assert 0 <= i < INTERVALS
    assert w == pytest.approx(expected[i : i + 4], abs=1e-6)
    assert expected.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("x", [ORIGIN - 5e-4, 0.0051, REFERENCE, 0.0137, END - 2e-4])
def test_each_integral_is_that_of_the_growth_times_its_spline(x):
    knots = [k for k in ORIGIN + SPACING * np.arange(INTERVALS + 1) if min(x, REFERENCE) < k < max(x, REFERENCE)]
    edges = sorted([REFERENCE, x, *knots], reverse=x < REFERENCE)
    growth = float(GEOMETRY["growth"][0])
    expected = np.zeros(SPRING_SIZE)
    for left, right in pairwise(edges):
        for j in range(SPRING_SIZE):
            expected[j] += quad(lambda at, j=j: np.exp(growth * (at - REFERENCE)) * spring_spline(at)[j], left, right)[
                0
            ]
    assert integrals_to(x) == pytest.approx(expected, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("x", [0.0042, 0.0098, 0.0153])
def test_the_derivative_of_the_integrals_is_the_spline(x):
    slope = (integrals_to(x + 1e-7) - integrals_to(x - 1e-7)) / 2e-7
    growth = np.exp(float(GEOMETRY["growth"][0]) * (x - REFERENCE))
    assert slope == pytest.approx(growth * spring_spline(x), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("v", [0.0, 1.3e-4, -2.2e-3, 5.9e-3, -8e-3])
def test_damping_splines_are_those_of_scipy(v):
    w, slope, expected = np.empty(3), np.empty(3), damper_spline(v)
    i = damping_spline(v, SPEED_SPACING, w, slope)
    assert w == pytest.approx(expected[i : i + 3], abs=1e-6)
    assert w.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("v", [1.3e-4, -2.2e-3, 5.8e-3])
def test_slopes_of_damping_splines_are_those_of_differences(v):
    w, slope, above, below, unused = (np.empty(3) for _ in range(5))
    i = damping_spline(v, SPEED_SPACING, w, slope)
    assert damping_spline(v + 1e-8, SPEED_SPACING, above, unused) == i
    assert damping_spline(v - 1e-8, SPEED_SPACING, below, unused) == i
    assert slope == pytest.approx((above - below) / 2e-8, rel=1e-4, abs=1e-2)


@pytest.mark.parametrize("v", [0.0, 1.3e-4, 2.2e-3, 5.9e-3, 8e-3])
def test_each_damper_integral_is_odd_and_that_of_its_spline(v):
    out, opposite = np.empty(DAMPER_SIZE), np.empty(DAMPER_SIZE)
    damper_integrals(v, SPEED_SPACING, out)
    damper_integrals(-v, SPEED_SPACING, opposite)
    knots = SPEED_SPACING * np.arange(1, DAMPER_SIZE - 1)
    edges = [0.0, *knots[knots < v], v]
    expected = [
        sum(quad(lambda at, j=j: damper_spline(at)[j], a, b)[0] for a, b in pairwise(edges)) for j in range(DAMPER_SIZE)
    ]
    assert out == pytest.approx(np.array(expected), rel=1e-6, abs=1e-12)
    assert opposite == pytest.approx(-out, abs=1e-18)


@pytest.mark.parametrize("v", [math.nan, math.inf, -math.inf])
def test_a_speed_of_a_diverged_member_is_within_the_damping_splines(v):
    assert 0 <= damping_spline(v, 5e-4, np.empty(3), np.empty(3)) <= DAMPER_SIZE - 3
