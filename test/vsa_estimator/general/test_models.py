# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Prior of the members and the change of the growth about which their elastic law is expanded."""

import numpy as np
import pytest
from vsa_estimator.general.basis import cubic, growth_factor, locate
from vsa_estimator.general.models import (
    MODELS,
    abscissas,
    geometry_at,
    matern,
    members_at,
    set_spring_prior,
    transferred,
)  # fmt: skip
from vsa_estimator.general.records import D0, D1, D2, DELAY, INTERVALS, SPRING, SPRING_SIZE, B, L, M, X
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.general import (
    CUBIC_STD,
    DELAY_STD,
    LEVEL_STD,
    SHAPE_STD,
    SPARE_INTERVALS,
    SPRING_SPACING,
    STIFFNESS_STD,
)  # fmt: skip

INITIAL = Initial()
FORCE, DEFLECTION = 30.0, 0.010
GEOMETRY = geometry_at(INITIAL, DEFLECTION, INITIAL.k2)
MEMBERS = members_at(INITIAL, GEOMETRY, FORCE, 1e-10)
INDEX = {model.name: i for i, model in enumerate(MODELS)}
STIFFNESS = INITIAL.k2 * (FORCE - INITIAL.force_offset)


def stiffness(geometry, coefficients, x):
    w = np.empty(4)
    i, u = locate(x, float(geometry["origin"][0]), float(geometry["spacing"][0]))
    cubic(u, w)
    return growth_factor(geometry, x) * (w @ coefficients[i : i + 4])


def test_prior_probabilities_are_those_of_a_distribution():
    assert sum(model.prior for model in MODELS) == pytest.approx(1.0, abs=0.05)
    assert [np.exp(one["model"]["ln_prior"]) for one in MEMBERS] == pytest.approx([model.prior for model in MODELS])
    assert MODELS[0].name == "exponential"


@pytest.mark.parametrize("index", range(len(MODELS)), ids=list(INDEX))
def test_states_outside_the_model_are_certain(index):
    one = MEMBERS[index]
    active = one["active"][: one["count"]]
    inactive = np.setdiff1d(np.arange(one["mean"].size), active)
    assert not one["covariance"][inactive].any()
    assert not one["covariance"][:, inactive].any()
    assert (B in active) == (MODELS[index].travel_std > 0.0)
    assert (DELAY in active) == MODELS[index].delay
    assert (D1 in active) != MODELS[index].spline_damper
    assert np.all(np.diff(active) > 0)


def test_prior_means_and_standard_deviations_are_those_of_the_configuration():
    one = MEMBERS[INDEX["any spring, delay"]]
    std = np.sqrt(np.diag(one["covariance"]))
    assert one["mean"][[X, L, M, D0, D1, D2]] == pytest.approx(
        [DEFLECTION, FORCE, INITIAL.inertia, INITIAL.coulomb_friction, INITIAL.d1, INITIAL.d2]
    )
    assert one["mean"][SPRING:] == pytest.approx(STIFFNESS)
    assert std[[L, M, D0]] == pytest.approx([LEVEL_STD, INITIAL.inertia_std, INITIAL.coulomb_friction_std])
    assert std[[D1, D2, DELAY]] == pytest.approx([INITIAL.d1_std, CUBIC_STD * INITIAL.d2_std, DELAY_STD])


@pytest.mark.parametrize(("name", "shape"), [("exponential", 0.0), ("any spring", SHAPE_STD)])
def test_the_prior_of_the_stiffness_at_the_reference(name, shape):
    middle = SPRING + SPRING_SIZE // 2
    covariance = MEMBERS[INDEX[name]]["covariance"]
    assert covariance[middle, middle] == pytest.approx(STIFFNESS**2 * (STIFFNESS_STD**2 + shape**2))


def test_the_exponential_law_has_two_degrees_of_freedom():
    singular = np.linalg.svd(MEMBERS[0]["covariance"][SPRING:, SPRING:], compute_uv=False)
    assert np.sum(singular > 1e-9 * singular[0]) == 2


@pytest.mark.parametrize("growth", [180.0, 240.0, 300.0, 350.0])
def test_another_growth_keeps_the_stiffness(growth):
    before, after = (geometry_at(INITIAL, DEFLECTION, kappa) for kappa in (INITIAL.k2, growth))
    coefficients = STIFFNESS * (1.0 + 0.2 * np.sin(np.arange(SPRING_SIZE) / 3.0))
    other = transferred(coefficients[None], before, after)[0]
    for x in np.linspace(0.001, 0.019, 37):
        assert stiffness(after, other, x) == pytest.approx(stiffness(before, coefficients, x), rel=0.02)


def test_the_same_growth_keeps_the_coefficients():
    geometry, coefficients = geometry_at(INITIAL, DEFLECTION, 250.0), np.linspace(1.0, 2.0, SPRING_SIZE)
    assert np.array_equal(transferred(coefficients[None], geometry, geometry.copy())[0], coefficients)


@pytest.mark.parametrize("span", [(0.0, 0.009), (0.008, 0.0085), (0.002, 0.022)])
def test_a_spline_about_other_deflections_has_the_same_stiffness(span):
    after = geometry_at(INITIAL, DEFLECTION, 240.0, span)
    coefficients = STIFFNESS * (1.0 + 0.2 * np.sin(np.arange(SPRING_SIZE) / 3.0))
    other = transferred(coefficients[None], GEOMETRY, after)[0]
    for x in np.linspace(*span, 17):
        assert stiffness(after, other, x) == pytest.approx(stiffness(GEOMETRY, coefficients, x), rel=0.03)


@pytest.mark.parametrize("span", [(0.001, 0.009), (0.0099, 0.0101), (-0.01, 0.02)])
def test_the_spline_has_spare_intervals_on_either_side_of_the_data(span):
    geometry = geometry_at(INITIAL, DEFLECTION, INITIAL.k2, span)
    spacing, first = float(geometry["spacing"][0]), float(geometry["origin"][0])
    assert spacing >= SPRING_SPACING / INITIAL.k2
    assert first <= span[0] - SPARE_INTERVALS * spacing + 1e-12
    assert first + INTERVALS * spacing >= span[1] + SPARE_INTERVALS * spacing - 1e-12


def test_the_prior_of_the_stiffness_does_not_depend_on_the_knots():
    other = geometry_at(INITIAL, DEFLECTION, INITIAL.k2, (0.001, 0.012))
    members = MEMBERS[[0, INDEX["any spring"]]].copy()
    before = members["covariance"][:, SPRING:, SPRING:].copy()
    set_spring_prior(members, other)
    for old, new in zip(before, members["covariance"][:, SPRING:, SPRING:], strict=True):
        expected = np.interp(abscissas(other)[3:12], abscissas(GEOMETRY), np.diag(old))
        assert np.diag(new)[3:12] == pytest.approx(expected, rel=0.03)


def test_the_matern_covariance_has_its_variance_and_decays_with_the_distance():
    covariance = matern(np.arange(8.0), 2.0, 0.5)
    assert np.diag(covariance) == pytest.approx(0.25)
    assert np.all(np.diff(covariance[0]) < 0.0)
    s = np.sqrt(5.0) * 3.0 / 2.0
    assert covariance[0, 3] == pytest.approx(0.25 * (1.0 + s + s * s / 3.0) * np.exp(-s))
