# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The set-point filters against their analytic step responses."""

import numpy as np
import pytest
from vsa_joint.control.setpoint_filter import RateLimitedFilter, SetpointFilter


def test_the_step_response_is_that_of_a_critically_damped_second_order_system():
    setpoint_filter = SetpointFilter(0.0)
    values = [setpoint_filter.step(1.0, 0.1, 0.01) for _ in range(200)]
    time = 0.01 * np.arange(1, 201)
    assert values == pytest.approx(1.0 - (1.0 + time / 0.1) * np.exp(-time / 0.1))


def test_without_a_limit_the_step_response_is_that_of_three_equal_lags():
    setpoint_filter = RateLimitedFilter(0.0)
    values = [setpoint_filter.step(1.0, 1e9, 0.1, 1e-4) for _ in range(10_000)]
    x = 1e-3 * np.arange(1, 10_001)
    assert values == pytest.approx(1.0 - (1.0 + x + 0.5 * x**2) * np.exp(-x), abs=1e-3)


def test_the_limit_bounds_the_rate_and_a_ramp_ends_after_its_travel_and_the_lags():
    setpoint_filter = RateLimitedFilter(0.0)
    values = np.array([setpoint_filter.step(-2.0, 4.0, 0.04, 0.01) for _ in range(100)])
    assert np.diff(values).min() == pytest.approx(-4.0 * 0.01, rel=0.05)
    assert values[59] > -1.95
    assert values[79] == pytest.approx(-2.0, abs=0.01)


def test_it_settles_towards_the_limited_setpoint_reached_so_far():
    setpoint_filter = RateLimitedFilter(0.0)
    for _ in range(10):
        setpoint_filter.step(2.0, 4.0, 0.04, 0.01)
    for _ in range(100):
        setpoint_filter.settle(0.04, 0.01)
    assert setpoint_filter.value == pytest.approx(0.4)
