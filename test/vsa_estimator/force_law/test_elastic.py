# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Exponential spring: derivatives by difference quotients, initial state and covariance, shift of the encoder."""

import math

import numpy as np
import pytest
from vsa_estimator.force_law.elastic import (
    compliance_at_reference,
    deflection_shift,
    elastic_force,
    elastic_gradient,
    ln_stiffness,
    ln_stiffness_gradient,
    relative_stiffness,
    s_covariance,
    s_from_force,
    stiffness,
)

S, K2, DX = 7.5, 250.0, 2e-3


def elastic(s, k2, dx):
    return elastic_force(stiffness(s, k2, dx), k2)


def slopes(function):
    """Central differences by dx, s and k2."""
    steps = ((0.0, 0.0, 1e-8), (1e-6, 0.0, 0.0), (0.0, 1e-4, 0.0))
    return [
        (function(S + s, K2 + k2, DX + dx) - function(S - s, K2 - k2, DX - dx)) / (2.0 * (s + k2 + dx))
        for s, k2, dx in steps
    ]


def test_gradients_are_those_of_the_force_and_of_the_logarithm_of_the_stiffness():
    assert elastic_gradient(stiffness(S, K2, DX), K2, DX) == pytest.approx(slopes(elastic), rel=1e-6)
    assert ln_stiffness_gradient(K2, DX) == pytest.approx(slopes(ln_stiffness), rel=1e-6)


def test_stiffness_and_relative_stiffness_stay_finite_for_any_deflection():
    assert 0.0 < stiffness(S, K2, -1e3) < stiffness(S, K2, 1e3) < math.inf
    assert np.isfinite(relative_stiffness(np.array([K2]), np.array([-1e3, 1e3]))).all()
    assert compliance_at_reference(S) == pytest.approx(1.0 / stiffness(S, K2, 0.0))


def test_the_initial_state_reproduces_the_force_with_the_covariance_of_its_sources():
    s = s_from_force(10.0, K2, DX)
    assert elastic(s, K2, DX) == pytest.approx(10.0)
    rng = np.random.default_rng(1)
    forces, k2 = 10.0 + 0.1 * rng.standard_normal(20_000), K2 + 2.0 * rng.standard_normal(20_000)
    drawn = np.cov(np.log(k2 * forces) - k2 * DX, k2)
    s_variance, k2_variance, _ = s_covariance(10.0, 0.1, K2, 2.0, DX)
    assert k2_variance == pytest.approx(drawn[1, 1], rel=0.05)
    assert s_variance == pytest.approx(2.0**2 / K2**2 + 0.01**2 + DX**2 * 2.0**2)


@pytest.mark.parametrize("shift", [-1e-3, 1e-4, 2e-3])
def test_a_shift_of_the_encoder_follows_from_the_force_that_it_causes(shift):
    sigma = stiffness(S, K2, DX)
    ratio = (elastic(S, K2, DX - shift) - elastic(S, K2, DX)) / sigma
    assert deflection_shift(K2, ratio) == pytest.approx(shift)
