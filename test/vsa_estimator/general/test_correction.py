# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Updates of a member against dense formulas and against linear regression."""

import numpy as np
import pytest
from vsa_estimator.general.correction import apply_bounds, correct, correct_deflection, correct_force, reset_motion
from vsa_estimator.general.law import LAW, general_force, linearize
from vsa_estimator.general.models import MODELS, geometry_at, members_at
from vsa_estimator.general.records import (
    D0,
    D1,
    DELAY,
    ENCODER,
    MOTION,
    SIZE,
    SPRING,
    SPRING_SIZE,
    STEP,
    A,
    B,
    J,
    L,
    M,
    V,
    X,
)  # fmt: skip
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.force_law import COULOMB_SPEED, MIN_D1
from vsa_estimator.tuning.general import MAX_DELAY

GEOMETRY = geometry_at(Initial(), 0.010, Initial().k2)
INDEX = {model.name: i for i, model in enumerate(MODELS)}
NOISE = 0.017**2


def member_of(name, seed=1):
    """(1,) MEMBER with a full covariance over its active states."""
    member = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[INDEX[name] : INDEX[name] + 1]
    one, random = member[0], np.random.default_rng(seed)
    active = one["active"][: one["count"]]
    std = np.sqrt(np.diag(one["covariance"]))[active]
    std[std == 0.0] = 0.01
    root = 0.1 * std[:, None] * random.normal(size=(active.size, active.size))
    one["covariance"][np.ix_(active, active)] = root @ root.T
    one["mean"][[X, V, A]] = 0.0105, 1.5e-3, 0.05
    one["linear"] = one["mean"]
    return member


def scaled(covariance, by):
    std = np.sqrt(np.diag(by)) + 1e-30
    return covariance / np.outer(std, std)


def assert_is_covariance(member):
    one = member[0]
    active = one["active"][: one["count"]]
    p = one["covariance"][np.ix_(active, active)]
    assert np.array_equal(p, p.T)
    assert np.linalg.eigvalsh(scaled(p, p))[0] > -1e-9


@pytest.mark.parametrize("optimal", [1.0, 0.3])
def test_the_joseph_form_is_that_of_dense_matrices_for_any_gain(optimal):
    member = member_of("any spring, delay")
    p, z = member[0]["covariance"].copy(), member[0]["mean"].copy()
    active = member[0]["active"][: member[0]["count"]]
    h = np.zeros(SIZE)
    h[active] = np.random.default_rng(2).normal(size=active.size) / np.sqrt(np.diag(p)[active])
    noise = 0.5
    variance = h @ p @ h + noise
    gain = optimal * (p @ h) / variance
    correct(member, p @ h, gain, 1.7, variance)
    left = np.eye(SIZE) - np.outer(gain, h)
    expected = left @ p @ left.T + noise * np.outer(gain, gain)
    assert scaled(member[0]["covariance"], p) == pytest.approx(scaled(expected, p), abs=1e-10)
    assert member[0]["mean"] == pytest.approx(z + 1.7 * gain)
    assert_is_covariance(member)


@pytest.mark.parametrize("name", ["any spring", "cyclic encoder error"])
def test_a_deflection_updates_as_a_dense_filter(name):
    member, noise = member_of(name), 1e-10
    z, p = member[0]["mean"].copy(), member[0]["covariance"].copy()
    h = np.zeros(SIZE)
    h[X], h[B] = 1.0, 1.0 if name == "cyclic encoder error" else 0.0
    variance = h @ p @ h + noise
    innovation = 1.5 * np.sqrt(variance)
    gain = p @ h / variance
    assert correct_deflection(member, h @ z + innovation, noise)
    assert member[0]["mean"] == pytest.approx(z + gain * innovation, rel=1e-9, abs=1e-14)
    expected = p - np.outer(gain, gain) * variance
    assert scaled(member[0]["covariance"], p) == pytest.approx(scaled(expected, p), abs=1e-10)
    assert member[0]["ln_likelihood"] == pytest.approx(-0.5 * (np.log(variance) + 1.5**2))
    assert_is_covariance(member)


def test_a_deflection_beyond_the_gate_asks_for_a_reset_and_leaves_the_state():
    member = member_of("any spring")
    before = member.copy()
    assert not correct_deflection(member, 0.0105 + 7.0 * np.sqrt(member[0]["covariance"][X, X] + 1e-10), 1e-10)
    assert np.array_equal(member["mean"], before["mean"])
    assert np.array_equal(member["covariance"], before["covariance"])


@pytest.mark.parametrize("name", ["any spring", "cyclic encoder error"])
def test_a_reset_sets_the_motion_and_keeps_the_coefficients(name):
    member, encoder = member_of(name), np.zeros(1, ENCODER)
    before = member.copy()
    root = np.random.default_rng(3).normal(size=(MOTION, MOTION)) * 1e-4
    encoder["mean"], encoder["covariance"] = (0.007, -1e-3, 0.02, 0.1), root @ root.T
    reset_motion(member, encoder)
    one, coefficients = member[0], slice(L, SIZE)
    assert np.array_equal(one["mean"][:MOTION], encoder["mean"][0])
    assert np.array_equal(one["mean"][coefficients], before[0]["mean"][coefficients])
    assert np.array_equal(
        one["covariance"][coefficients, coefficients], before[0]["covariance"][coefficients, coefficients]
    )
    assert not one["covariance"][:MOTION, coefficients].any()
    measured = np.zeros(SIZE)
    measured[X], measured[B] = 1.0, float(name == "cyclic encoder error")
    assert measured @ one["covariance"] @ measured == pytest.approx(encoder["covariance"][0, 0, 0], rel=1e-6)
    assert_is_covariance(member)


def force_step(force):
    step = np.zeros(1, STEP)
    step["dt"], step["force"], step["force_variance"] = 0.01, force, NOISE
    step["encoder"]["mean"][0][V] = 1.5e-3
    return step


def gradient_of(member):
    gradient = np.zeros(SIZE)
    linearize(member, np.zeros(1, STEP))
    force = general_force(member, GEOMETRY, COULOMB_SPEED, 0.0, gradient, np.zeros(1, LAW))
    return force, gradient


@pytest.mark.parametrize("name", ["exponential", "any spring", "any damper", "relaxation"])
def test_forces_at_a_certain_motion_are_a_linear_regression(name):
    random = np.random.default_rng(6)
    member = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[INDEX[name] : INDEX[name] + 1]
    one = member[0]
    states = np.setdiff1d(one["active"][: one["count"]], [X, V, A, J, DELAY])
    one["covariance"][[X, V, A, J, DELAY]] = one["covariance"][:, [X, V, A, J, DELAY]] = 0.0
    prior, mean = one["covariance"][np.ix_(states, states)].copy(), one["mean"][states].copy()
    truth, design, forces = mean + 0.05 * np.sqrt(np.diag(prior)), [], []
    for n in range(40):
        one["mean"][[X, V, A]] = random.uniform(0.006, 0.013), random.uniform(1.5e-3, 3e-3) * (-1.0) ** n, 1e-3
        one["relaxation"], one["unexplained"], one["time_since_motion"] = random.normal(size=6), 0.0, 0.0
        _, row = gradient_of(member)
        design.append(row[states])
        forces.append(design[-1] @ truth + np.sqrt(NOISE) * random.standard_normal())
        correct_force(member, GEOMETRY, force_step(forces[-1]))
    h, std = np.array(design), np.sqrt(np.diag(prior))
    gain = prior @ h.T @ np.linalg.inv(h @ prior @ h.T + NOISE * np.eye(len(h)))
    expected = mean + gain @ (np.array(forces) - h @ mean)
    covariance = prior - gain @ h @ prior
    posterior = one["covariance"][np.ix_(states, states)]
    assert (one["mean"][states] - expected) / std == pytest.approx(0.0, abs=0.01)
    assert np.sqrt(np.diag(posterior)) / std == pytest.approx(np.sqrt(np.diag(covariance)) / std, abs=0.01)
    assert_is_covariance(member)


@pytest.mark.parametrize("name", list(INDEX))
def test_a_force_leaves_a_covariance_and_reduces_the_variance_of_the_level(name):
    member = member_of(name)
    before = member[0]["covariance"][L, L]
    correct_force(member, GEOMETRY, force_step(gradient_of(member)[0] + 0.02))
    assert member[0]["innovation_variance"] > NOISE
    assert member[0]["covariance"][L, L] < before
    assert_is_covariance(member)


def test_an_impossible_force_is_rejected_and_counts_with_a_bounded_likelihood():
    member = member_of("any spring")
    before = member.copy()
    correct_force(member, GEOMETRY, force_step(1e6))
    assert np.array_equal(member["mean"], before["mean"])
    assert np.array_equal(member["covariance"], before["covariance"])
    assert -20.0 < member[0]["ln_likelihood"] < 0.0


@pytest.mark.parametrize(("speed", "std", "counts"), [(1e-4, 0.0, False), (3e-4, 0.0, True), (3e-4, 1e-4, False)])
def test_near_a_reversal_a_force_is_no_evidence(speed, std, counts):
    member, step = member_of("any damper and friction"), force_step(30.0)
    encoder = step["encoder"][0]
    encoder["mean"][V], encoder["covariance"][V, V] = -speed, std**2
    correct_force(member, GEOMETRY, step)
    assert (member[0]["ln_likelihood"] != 0.0) == counts
    assert member[0]["gain"].any()


def exponential_member():
    return members_at(Initial(), GEOMETRY, 30.0, 1e-10)[INDEX["exponential"] : INDEX["exponential"] + 1]


def test_an_update_of_the_exponential_law_is_that_of_its_level_and_growth():
    """Against the extended Kalman filter of ln level and growth, to first order in a small update."""
    member, g = exponential_member(), np.arange(SPRING_SIZE) - 0.5 * (SPRING_SIZE - 1)
    before = member[0]["mean"][SPRING:].copy()
    h = np.zeros(SIZE)
    h[SPRING:] = 1e-4 * np.exp(0.1 * g)
    p = member[0]["covariance"].copy()
    tangents = before * np.stack([np.ones(SPRING_SIZE), g])  # by ln level and growth
    variances = np.diag(
        np.linalg.lstsq(tangents.T, np.linalg.lstsq(tangents.T, p[SPRING:, SPRING:], rcond=None)[0].T, rcond=None)[0]
    )
    small = tangents @ h[SPRING:]
    innovation, noise = 1e-3, 0.5
    variance = small**2 @ variances + noise
    correct(member, p @ h, p @ h / variance, innovation, variance)
    level, growth = variances * small / variance * innovation
    assert member[0]["mean"][SPRING:] == pytest.approx(before * np.exp(level + growth * g), rel=1e-7)
    assert_is_covariance(member)


def test_the_exponential_law_stays_exponential():
    member, random = exponential_member(), np.random.default_rng(1)
    for _ in range(200):
        step = force_step(30.0 + random.normal())
        member[0]["mean"][[X, V]] = 0.010 + 0.003 * random.normal(), 1e-3
        correct_force(member, GEOMETRY, step)
    ln = np.log(member[0]["mean"][SPRING:])
    assert np.ptp(ln) > 0.1
    assert np.abs(np.diff(ln, 2)).max() < 1e-9
    p = member[0]["covariance"][SPRING:, SPRING:] / np.outer(np.exp(ln), np.exp(ln))
    assert np.linalg.matrix_rank(p, tol=1e-9 * np.trace(p)) == 2


def test_without_a_significant_acceleration_the_mass_is_kept():
    member = member_of("any spring")
    member[0]["covariance"][A, A] = 1.0
    mass = float(member[0]["mean"][M])
    correct_force(member, GEOMETRY, force_step(gradient_of(member)[0] + 0.02))
    assert member[0]["mean"][M] == mass
    assert member[0]["gain"][M] == 0.0


def test_an_uncertain_stiffness_keeps_the_force_from_the_motion():
    member = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[INDEX["any spring"] : INDEX["any spring"] + 1]
    motion = member[0]["mean"][:MOTION].copy()
    correct_force(member, GEOMETRY, force_step(31.0))
    assert np.array_equal(member[0]["mean"][:MOTION], motion)
    assert member[0]["mean"][L] != 30.0


def test_coefficients_stay_within_their_bounds():
    z = np.zeros(SIZE)
    z[[M, D0, D1, DELAY]], z[SPRING] = (-1.0, -0.1, -500.0, 1.0), -3.0
    apply_bounds(z)
    assert z[[M, D0, D1, DELAY]] == pytest.approx([0.0, 0.0, MIN_D1, MAX_DELAY])
    assert z[SPRING] == -3.0
    z[DELAY] = -1.0
    apply_bounds(z)
    assert z[DELAY] == -MAX_DELAY
