# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Prediction of a member against the matrix exponential and a dense covariance."""

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm
from vsa_estimator.general.models import MODELS, geometry_at, members_at
from vsa_estimator.general.prediction import add_snap_noise, advance_memory, predict_member
from vsa_estimator.general.records import LEVEL_RATE, MOTION, SIZE, SPRING, A, B, J, L, V, X
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.general import LEVEL_RATE_TIME, RELAXATION_TIMES, STOP_TRAVELS

GEOMETRY = geometry_at(Initial(), 0.010, Initial().k2)
DENSITY, DT = 0.02, 0.01
RELAXATION_MEMBER = [model.name for model in MODELS].index("relaxation")


def random_member(index, seed=1):
    """(1,) MEMBER with a full covariance over its active states."""
    member = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[index : index + 1]
    one, random = member[0], np.random.default_rng(seed)
    active = one["active"][: one["count"]]
    std = np.sqrt(np.diag(one["covariance"]))[active]
    std[std == 0.0] = 0.01
    root = std[:, None] * random.normal(size=(active.size, active.size))
    one["covariance"][np.ix_(active, active)] = root @ root.T
    one["mean"][[X, V, A, J]] = 0.011, 1.2e-3, 0.02, -0.3
    one["mean"][[L, LEVEL_RATE, B]] = 30.0, 0.2, 0.01
    return member


def dense_transition(dt, travel, length):
    """Matrix F of the model; the chain of integrators by the matrix exponential."""
    f = np.eye(SIZE)
    f[:MOTION, :MOTION] = expm(dt * np.eye(MOTION, k=1))
    f[B, B] = np.exp(-travel / length)
    f[L, LEVEL_RATE], f[LEVEL_RATE, LEVEL_RATE] = dt, np.exp(-dt / LEVEL_RATE_TIME)
    return f


def snap_noise(density, dt):
    """Integral of the outer products of the responses to an impulse of snap."""

    def response(s):
        column = np.array([s**3 / 6.0, s * s / 2.0, s, 1.0])
        return density * np.outer(column, column)

    return quad_vec(response, 0.0, dt, epsrel=1e-12, epsabs=0.0)[0]


@pytest.mark.parametrize("dt", [0.002, 0.01, 0.1])
def test_the_noise_of_white_snap_is_the_integral_of_impulse_responses(dt):
    p = np.zeros((SIZE, SIZE))
    add_snap_noise(p, DENSITY, dt)
    expected = snap_noise(DENSITY, dt)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert p[:MOTION, :MOTION] / scale == pytest.approx(expected / scale, abs=1e-6)
    assert not p[MOTION:].any()


@pytest.mark.parametrize("index", range(len(MODELS)), ids=[model.name for model in MODELS])
def test_mean_and_covariance_are_those_of_dense_matrices(index):
    member, model = random_member(index), MODELS[index]
    z, p = member[0]["mean"].copy(), member[0]["covariance"].copy()
    bias = member[0]["bias"][:] = np.random.default_rng(2).normal(size=SIZE)
    bias = bias.copy()
    predict_member(member, GEOMETRY, DT, DENSITY)
    f = dense_transition(DT, abs(z[V] * DT), model.travel_length)
    q = np.zeros((SIZE, SIZE))
    q[:MOTION, :MOTION] = snap_noise(DENSITY, DT)
    q[B, B] = model.travel_std**2 * (1.0 - f[B, B] ** 2)
    q[L, L], q[LEVEL_RATE, LEVEL_RATE] = model.level_density * DT, model.rate_density * DT
    # The elastic law drifts as a whole: its stiffness, and its force at the reference.
    direction = np.zeros(SIZE)
    direction[SPRING:] = z[SPRING:]
    direction[L] = z[SPRING] / Initial().k2
    q += model.scale_density * DT * np.outer(direction, direction)
    expected = f @ p @ f.T + q
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected))) + 1e-300
    after = member[0]["covariance"]
    assert member[0]["mean"] == pytest.approx(f @ z, rel=1e-12, abs=1e-15)
    assert member[0]["bias"] == pytest.approx(f @ bias, rel=1e-12, abs=1e-15)
    assert after / scale == pytest.approx(expected / scale, abs=1e-9)
    assert after / scale == pytest.approx(after.T / scale, abs=1e-12)


def test_the_covariance_of_the_motion_is_that_of_a_monte_carlo():
    member, steps, fine = members_at(Initial(), GEOMETRY, 30.0, 1e-10)[:1], 20, 10
    member[0]["covariance"][:MOTION, :MOTION] = 0.0
    for _ in range(steps):
        predict_member(member, GEOMETRY, DT, DENSITY)
    random, motion, h = np.random.default_rng(5), np.zeros((20_000, MOTION)), DT / fine
    f = expm(h * np.eye(MOTION, k=1))
    for _ in range(steps * fine):
        motion = motion @ f.T
        motion[:, J] += np.sqrt(DENSITY * h) * random.standard_normal(len(motion))
    variances = np.diag(member[0]["covariance"])[:MOTION]
    assert motion.var(axis=0) / variances == pytest.approx(1.0, abs=0.12)


def test_relaxation_is_that_of_maxwell_elements_at_constant_rate():
    member, v, geometry = random_member(RELAXATION_MEMBER), 1e-3, geometry_at(Initial(), 0.010, 0.0)
    one = member[0]
    one["driving"], one["relaxation"] = 3000.0, 0.0
    for i in range(300):
        advance_memory(member, geometry, 0.010 + (i + 1) * v * DT, DT)
    times = np.array(RELAXATION_TIMES)
    assert one["relaxation"] == pytest.approx(3000.0 * v * times * (1.0 - np.exp(-3.0 / times)), rel=1e-9)


def test_stops_follow_the_travel_and_saturate_in_both_directions():
    member = random_member(0)
    one = member[0]
    for travel, expected in ((2e-5, 2e-5 / np.array(STOP_TRAVELS)), (2e-3, np.ones(3))):
        one["stop"] = 0.0
        advance_memory(member, GEOMETRY, one["deflection"] + travel, DT)
        assert one["stop"] == pytest.approx(expected)
    advance_memory(member, GEOMETRY, one["deflection"] - 1e-4, DT)
    assert one["stop"] == pytest.approx(np.maximum(1.0 - 1e-4 / np.array(STOP_TRAVELS), -1.0))
