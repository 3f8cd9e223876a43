# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The general force with the coefficients of the paper's transmission, eqs. (2) to (6)."""

import numpy as np
import pytest
from vsa_estimator.general.law import LAW, general_force
from vsa_estimator.general.models import geometry_at, members_at
from vsa_estimator.general.records import D0, D1, D2, DELAY, SIZE, SPRING, A, B, J, L, M, V, X
from vsa_estimator.settings import Initial

K1, K2, D1_TRUE, D2_TRUE, MASS, OFFSET, COULOMB = 0.776, 267.2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3
REFERENCE, COULOMB_SPEED, CERTAIN = 0.010, 5e-5, 1e-7
PEAK = np.sqrt(D1_TRUE / (-3.0 * D2_TRUE))


def paper_force(x, v, a):
    c = np.clip(v, -PEAK, PEAK)
    damper = D1_TRUE * c + D2_TRUE * c**3 + COULOMB * np.tanh(v / COULOMB_SPEED)
    return OFFSET + K1 * np.exp(K2 * x) + damper + MASS * a


def paper_member(x, v, a, delay=0.0):
    """Member of the exponential law with the coefficients of the paper, (1,) MEMBER, and its geometry."""
    geometry = geometry_at(Initial(), REFERENCE, K2)
    member = members_at(Initial(), geometry, 30.0, 1e-10)[:1]
    z = member[0]["mean"]
    elastic = K1 * np.exp(K2 * REFERENCE)
    z[[X, V, A, J, B, DELAY]] = x, v, a, 0.0, 0.0, delay
    z[[L, M, D0, D1, D2]] = OFFSET + elastic, MASS, COULOMB, D1_TRUE, D2_TRUE
    z[SPRING:] = K2 * elastic
    member[0]["linear"] = z
    return member, geometry


def evaluate(member, geometry, speed_std=CERTAIN):
    gradient, law = np.zeros(SIZE), np.zeros(1, LAW)
    return general_force(member, geometry, COULOMB_SPEED, speed_std, gradient, law), gradient, law[0]


@pytest.mark.parametrize("x", [0.003, 0.0081, 0.010, 0.0187])
@pytest.mark.parametrize("v", [-6e-3, -2e-3, 1e-4, 3e-3, 5e-3])
def test_the_force_and_the_stiffness_are_those_of_the_paper(x, v):
    force, gradient, law = evaluate(*paper_member(x, v, 0.02))
    assert force == pytest.approx(paper_force(x, v, 0.02), rel=1e-6)
    assert law["stiffness"] == pytest.approx(K1 * K2 * np.exp(K2 * x), rel=1e-9)
    assert gradient[X] == pytest.approx(law["stiffness"])


@pytest.mark.parametrize("v", [1.01 * PEAK, 2.0 * PEAK, -1.5 * PEAK])
def test_beyond_the_peak_speed_the_damper_has_no_slope(v):
    force, gradient, law = evaluate(*paper_member(0.010, v, 0.0))
    faster, _, _ = evaluate(*paper_member(0.010, 1.2 * v, 0.0))
    assert faster == pytest.approx(force, abs=1e-9)
    assert gradient[V] == pytest.approx(0.0, abs=1e-6)
    assert law["below_peak"] == 0.0


def test_the_force_lags_the_encoder_by_the_delay():
    delay, x, v, a = 0.006, 0.012, 1.5e-3, 0.03
    force, _, _ = evaluate(*paper_member(x, v, a, delay))
    earlier = paper_force(x - delay * v + 0.5 * delay**2 * a, v - delay * a, a)
    assert force == pytest.approx(earlier, rel=1e-7)


def test_the_statistical_linearisation_is_that_of_a_monte_carlo():
    member, geometry = paper_member(0.010, 1.5e-3, 0.0)
    std, v = 8e-4, 1.5e-3 + 8e-4 * np.random.default_rng(4).standard_normal(400_000)
    member[0]["mean"][D0] = member[0]["linear"][D0] = 0.0
    c = np.clip(v, -PEAK, PEAK)
    damper = D1_TRUE * c + D2_TRUE * c**3
    force, _, law = evaluate(member, geometry, std)
    assert force - OFFSET - K1 * np.exp(K2 * 0.010) == pytest.approx(damper.mean(), rel=0.02)
    assert law["damper_slope"] == pytest.approx(np.mean(damper * (v - 1.5e-3)) / std**2, rel=0.1)
