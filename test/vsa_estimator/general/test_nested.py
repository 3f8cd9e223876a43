# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A member of any spring, conditioned on an exponential one, against a posterior by numerical integration."""

import numpy as np
import pytest
from vsa_estimator.general.elastic_law import condition_on_exponential
from vsa_estimator.general.models import MODELS, NESTED, geometry_at, members_at
from vsa_estimator.general.records import D1, SPRING, SPRING_SIZE, L
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.general import SLOPE_STD, SPRING_SPACING, STIFFNESS_STD

INITIAL, DEFLECTION = Initial(), 0.010
GEOMETRY = geometry_at(INITIAL, DEFLECTION, INITIAL.k2)
INDEX = next(iter(NESTED.values()))
DATA = slice(6, 12)  # knots with data
KNOTS = np.arange(SPRING_SIZE) - 9.0  # from the one at the reference


def prior():
    return members_at(INITIAL, GEOMETRY, 30.0, 1e-10)[INDEX : INDEX + 1]


def observed(law, std, level=0.0):
    """Posterior after measurements of the coefficients DATA, each with `level` times L in it; the measured values."""
    member = prior()
    rows = np.zeros((DATA.stop - DATA.start, member["mean"].shape[1]))
    rows[:, SPRING:] = np.eye(SPRING_SIZE)[DATA]
    rows[:, L] = level
    noise = np.random.default_rng(1).standard_normal(len(rows))
    measured = law[DATA] + level * member["mean"][0, L] + std * noise
    p = member["covariance"][0]
    gain = p @ rows.T @ np.linalg.inv(rows @ p @ rows.T + std**2 * np.eye(len(rows)))
    member["mean"][0] += gain @ (measured - rows @ member["mean"][0])
    member["covariance"][0] = (np.eye(len(p)) - gain @ rows) @ p
    return member, measured


def stiffness_at_start():
    return float(prior()["mean"][0, SPRING])


def integrated(measured, std, level, rate):
    """Mean (2,) and covariance (2, 2) of ln of the level and the rate of an exponential law, and its log evidence.

    Integrated over a grid about the true law.
    """
    width = 20.0 * std / (level * stiffness_at_start())
    a = np.log(level * stiffness_at_start()) + np.linspace(-width, width, 801)
    b = rate + np.linspace(-width, width, 801)
    grid = np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1)
    law = np.exp(grid[..., :1] + grid[..., 1:] * KNOTS[DATA])
    stds = np.array([STIFFNESS_STD, SLOPE_STD * SPRING_SPACING])
    ln_prior = -0.5 * (((grid - [np.log(stiffness_at_start()), 0.0]) / stds) ** 2).sum(-1) - np.log(stds).sum()
    ln_density = ln_prior - np.log(2.0 * np.pi) - 0.5 * (((measured - law) / std) ** 2).sum(-1)
    ln_density -= len(measured) * np.log(std * np.sqrt(2.0 * np.pi))
    density = np.exp(ln_density - ln_density.max())
    total = density.sum()
    mean = (density[..., None] * grid).sum((0, 1)) / total
    error = grid - mean
    covariance = np.einsum("ij,ijk,ijl->kl", density, error, error) / total
    return mean, covariance, ln_density.max() + np.log(total * (a[1] - a[0]) * (b[1] - b[0]))


def ln_evidence_of_any(measured, std):
    member = prior()[0]
    covariance = member["covariance"][SPRING:, SPRING:][DATA, DATA] + std**2 * np.eye(len(measured))
    error = measured - member["mean"][SPRING:][DATA]
    normal = np.linalg.slogdet(2.0 * np.pi * covariance)[1]
    return -0.5 * float(normal + error @ np.linalg.solve(covariance, error))


def exponential(level, rate):
    return level * stiffness_at_start() * np.exp(rate * KNOTS)


@pytest.mark.parametrize(("level", "rate"), [(1.0, 0.0), (0.6, 0.08), (1.7, -0.1)])
@pytest.mark.parametrize("share", [0.003, 0.03])
def test_law_variance_and_evidence_are_those_of_a_numerical_integration(level, rate, share):
    std = share * stiffness_at_start()
    member, measured = observed(exponential(level, rate), std)
    found = condition_on_exponential(member, prior(), GEOMETRY, DEFLECTION)
    mean, covariance, ln_evidence = integrated(measured, std, level, rate)
    ln_law = np.log(member["mean"][0, SPRING:])
    assert [ln_law[9], np.diff(ln_law).mean()] == pytest.approx(mean, abs=0.1 * np.sqrt(covariance.diagonal()).max())
    variance = member["covariance"][0, SPRING + 9, SPRING + 9] / member["mean"][0, SPRING + 9] ** 2
    assert variance == pytest.approx(covariance[0, 0], rel=0.1)
    assert found == pytest.approx(ln_evidence - ln_evidence_of_any(measured, std), abs=0.1)


def test_the_law_is_exponential_and_its_covariance_has_two_degrees_of_freedom():
    member, _ = observed(exponential(0.8, 0.05), 20.0)
    condition_on_exponential(member, prior(), GEOMETRY, DEFLECTION)
    assert np.ptp(np.diff(np.log(member["mean"][0, SPRING:]))) < 1e-9
    singular = np.linalg.svd(member["covariance"][0, SPRING:, SPRING:], compute_uv=False)
    assert np.sum(singular > 1e-6 * singular[0]) == 2


def test_the_other_states_follow_by_their_regression_on_the_coefficients():
    law, std = exponential(0.8, 0.05), 20.0
    member, _ = observed(law, std, level=100.0)
    before = member.copy()
    condition_on_exponential(member, prior(), GEOMETRY, DEFLECTION)
    assert abs(member["mean"][0, L] - 30.0) < 3.0 * np.sqrt(member["covariance"][0, L, L])
    assert member["covariance"][0, L, L] < before["covariance"][0, L, L]
    assert member["mean"][0, D1] == before["mean"][0, D1]


def test_a_spring_with_a_knee_is_not_exponential():
    member, _ = observed(stiffness_at_start() * (1.5 + 0.5 * np.tanh(KNOTS)), 20.0)
    assert condition_on_exponential(member, prior(), GEOMETRY, DEFLECTION) < -20.0


def test_a_weak_posterior_stays_near_the_prior():
    law = -stiffness_at_start() * np.ones(SPRING_SIZE)
    member, _ = observed(law, 2.0 * stiffness_at_start())
    condition_on_exponential(member, prior(), GEOMETRY, DEFLECTION)
    ratio = np.log(member["mean"][0, SPRING:] / stiffness_at_start())
    assert np.isfinite(ratio).all()
    assert np.abs(ratio).max() < 3.0 * (STIFFNESS_STD + SLOPE_STD * SPRING_SPACING * 9.0)


def test_nested_members_differ_from_their_general_ones_in_the_spring_alone():
    assert sorted(NESTED) == [m for m, model in enumerate(MODELS) if not model.shape] == list(range(len(NESTED)))
    for nested, general in NESTED.items():
        assert MODELS[nested]._replace(name="", prior=0.0, shape=True) == MODELS[general]._replace(name="", prior=0.0)
