# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Filters of the formulation `force_rate`: state equations, process noise, offset filter."""

import math

import numpy as np
import pytest
from vsa_estimator.force_rate.ekf import SIZE, ForceRateFilter, OffsetFilter, R, white_snap

STATE = np.array([0.010, 1.5e-3, 4e-3, 0.02, 7.0, 3000.0, 3200.0, 0.4, 260.0, -1.0e8])


def test_the_jacobian_is_the_derivative_of_the_state_equations():
    filter = ForceRateFilter(STATE, np.ones(SIZE))
    start = filter.x.copy()
    filter._dt = 0.01
    jacobian = filter._jacobian(0.01)
    numeric = np.empty((SIZE, SIZE))
    for i in range(SIZE):
        ends = []
        step = 1e-5 * max(abs(start[i, 0]), 1e-3)
        for sign in (1.0, -1.0):
            filter.x = start.copy()
            filter.x[i, 0] += sign * step
            filter.predict_x()
            ends.append(filter.x[:, 0].copy())
        numeric[:, i] = (ends[0] - ends[1]) / (2.0 * step)
    np.testing.assert_allclose(jacobian, numeric, rtol=1e-5, atol=1e-7)


def test_stiffness_and_damping_follow_their_laws_over_a_step():
    """(15) and (16) integrated: sigma exp(k2 dx) and D + 3 d2 d(v^2), for any step."""
    filter = ForceRateFilter(STATE, np.ones(SIZE))
    filter.advance(0.01, 1.0)
    moved = filter.state[R.X] - STATE[R.X]
    assert filter.state[R.SIGMA] == pytest.approx(3000.0 * math.exp(260.0 * moved), rel=1e-12)
    assert filter.state[R.D] == pytest.approx(3200.0 - 3e8 * (filter.state[R.V] ** 2 - 1.5e-3**2), rel=1e-12)


def test_the_covariance_of_white_snap_adds_up_over_steps():
    """Two half steps of the chain of integrators are one whole step."""
    half, whole = white_snap(0.5), white_snap(1.0)
    f = np.array([[1.0, 0.5, 0.125, 0.125 / 6.0], [0.0, 1.0, 0.5, 0.125], [0.0, 0.0, 1.0, 0.5], [0.0, 0.0, 0.0, 1.0]])
    np.testing.assert_allclose(f @ half @ f.T + half, whole, rtol=1e-12)


def test_the_offset_filter_separates_offset_and_friction():
    offsets = OffsetFilter(10.0, 5.0, 0.0, 0.5)
    random = np.random.default_rng(1)
    for k in range(400):
        direction = 1.0 if (k // 40) % 2 else -1.0
        offsets.add(16.0 + 0.3 * direction + 0.05 * random.standard_normal(), direction, 0.05**2, 0.1)
    assert offsets.offset == pytest.approx(16.0, abs=0.02)
    assert offsets.friction == pytest.approx(0.3, abs=0.02)
