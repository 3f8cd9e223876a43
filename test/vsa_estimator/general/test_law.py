# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Gradient of the general force by differences, and its splines by quadrature."""

import numpy as np
import pytest
from scipy.integrate import quad
from vsa_estimator.general.basis import add_integrals, damper_integrals, damping_spline, locate
from vsa_estimator.general.law import LAW, general_force, linearize
from vsa_estimator.general.models import MODELS, geometry_at, members_at
from vsa_estimator.general.records import DAMPER_SIZE, MOTION, SIZE, SPRING_SIZE, STEP, A, J, V, X
from vsa_estimator.settings import Initial

GEOMETRY = geometry_at(Initial(), 0.01, Initial().k2)


def force(member, gradient):
    return general_force(member, GEOMETRY, 7e-5, 1e-6, gradient, np.zeros(1, LAW))


@pytest.mark.parametrize("index", range(len(MODELS)), ids=[model.name for model in MODELS])
def test_the_gradient_is_that_of_differences(index):
    member = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[index : index + 1]
    random = np.random.default_rng(index)
    one = member[0]
    active = one["active"][: one["count"]]
    one["relaxation"], one["stop"] = random.normal(0.0, 1.0, 6), random.uniform(-1.0, 1.0, 3)
    one["mean"][active] += 0.1 * random.normal(size=active.size) * np.sqrt(np.diag(one["covariance"])[active])
    one["mean"][[X, V, A, J]] = 0.0123, 1.5e-3, 0.01, 0.0
    one["linear"] = one["mean"]
    gradient, other = np.zeros(SIZE), np.zeros(SIZE)
    force(member, gradient)
    for i in active:
        if i == J:
            continue
        step = 1e-6 if i >= MOTION else (1e-8, 1e-7, 1e-6)[i]
        values = []
        for side in (1.0, -1.0):
            moved = member.copy()
            moved["mean"][0, i] += side * step
            moved["linear"] = moved["mean"]
            values.append(force(moved, other))
        assert gradient[i] == pytest.approx((values[0] - values[1]) / (2.0 * step), rel=2e-3, abs=2e-3)


def test_the_table_is_the_integral_of_the_weighted_splines():
    geometry = GEOMETRY[0]
    origin, spacing, reference = (float(geometry[name]) for name in ("origin", "spacing", "reference"))
    x = 0.0137
    i, _ = locate(x, origin, spacing)
    integrals = geometry["table"][i].copy()
    add_integrals(GEOMETRY, i, origin + i * spacing, x, integrals)
    # The splines sum to one: the integral of all is that of the exponential.
    growth = float(geometry["growth"])
    expected = quad(lambda at: np.exp(growth * (at - reference)), reference, x)[0]
    assert integrals.size == SPRING_SIZE
    assert integrals.sum() == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("v", [-4e-3, -0.7e-3, 0.2e-3, 3.1e-3])
def test_the_damper_is_odd_and_the_integral_of_its_splines(v):
    spacing, weights, slope, out = 0.5e-3, np.empty(3), np.empty(3), np.empty(DAMPER_SIZE)
    coefficients = np.random.default_rng(3).normal(size=DAMPER_SIZE)

    def damping(at):
        i = damping_spline(at, spacing, weights, slope)
        return weights @ coefficients[i : i + 3]

    damper_integrals(v, spacing, out)
    force_at = out @ coefficients
    assert force_at == pytest.approx(quad(damping, 0.0, v, limit=200)[0], rel=1e-6)
    damper_integrals(-v, spacing, out)
    assert out @ coefficients == pytest.approx(-force_at)


def test_every_prior_is_a_covariance():
    for member in members_at(Initial(), GEOMETRY, 30.0, 1e-10):
        active = np.flatnonzero(np.diag(member["covariance"]) > 0.0)
        covariance = member["covariance"][np.ix_(active, active)]
        std = np.sqrt(np.diag(covariance))
        assert np.array_equal(covariance, covariance.T)
        assert np.linalg.eigvalsh(covariance / np.outer(std, std))[0] > -1e-9


@pytest.mark.parametrize(
    ("relinearizing", "ratio", "smoothed"), [(True, 0.5, True), (True, 2.0, False), (False, 0.5, False)]
)
def test_a_repetition_linearises_at_the_motion_of_the_more_certain_velocity(relinearizing, ratio, smoothed):
    member, step = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[2:3], np.zeros(1, STEP)
    one, now = member[0], step[0]
    one["linear"] = coefficients = np.arange(1.0, SIZE + 1.0)
    now["relinearizing"], now["smoothed"] = relinearizing, (0.011, 1e-3, 0.02, 0.3)
    now["smoothed_covariance"] = ratio * one["covariance"][:MOTION, :MOTION]
    assert linearize(member, step) is smoothed
    assert np.array_equal(one["linear"][:MOTION], now["smoothed"] if smoothed else one["mean"][:MOTION])
    assert np.array_equal(one["linear"][MOTION:], (coefficients if relinearizing else one["mean"])[MOTION:])
    variance = (ratio if smoothed else 1.0) * one["covariance"][:MOTION, :MOTION]
    assert np.array_equal(one["linear_covariance"], variance)


def test_the_force_is_linear_in_the_motion_about_the_point_of_linearisation():
    member = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[2:3]
    one, gradient = member[0], np.zeros(SIZE)
    one["mean"][[X, V, A]] = 0.0123, 1.5e-3, 0.01
    one["linear"] = one["mean"]
    at_point = force(member, gradient)
    one["mean"][[X, V, A]] += 1e-3, 1e-3, 0.1
    assert force(member, np.zeros(SIZE)) == pytest.approx(at_point + gradient[[X, V, A]] @ [1e-3, 1e-3, 0.1])
