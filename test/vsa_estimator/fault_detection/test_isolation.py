# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Isolation of a constant shift of one sensor."""

import numpy as np
import pytest
from vsa_estimator.fault_detection.isolation import isolate
from vsa_estimator.tuning.fault_detection import MAX_RIPPLE

K2 = 267.2
LIMIT = 0.2  # [N]


def noisy(values, rng):
    return values + 0.03 * rng.standard_normal(values.size)


def test_the_shift_of_each_sensor_is_isolated():
    rng = np.random.default_rng(2)
    sigma = 2600.0 * np.exp(K2 * np.linspace(-2e-3, 2e-3, 250))
    force = isolate(noisy(np.full(250, 1.5), rng), sigma, K2, LIMIT)
    assert force.force == pytest.approx(1.5, rel=0.02)
    assert force.deflection == 0.0
    shift = 3e-4
    encoder = isolate(noisy(sigma / K2 * (1.0 - np.exp(K2 * shift)), rng), sigma * np.exp(K2 * shift), K2, LIMIT)
    assert encoder.deflection == pytest.approx(shift, rel=0.03)
    assert encoder.force == 0.0


def test_a_drift_is_no_constant_shift():
    rng = np.random.default_rng(3)
    sigma = 2600.0 * np.exp(K2 * 2e-3 * np.sin(np.linspace(0.0, 6.0, 250)))
    assert isolate(noisy(0.5 * np.linspace(1.0, 3.5, 250), rng), sigma, K2, LIMIT) is None
    assert 0.5 * 2.5 / np.sqrt(12.0) > MAX_RIPPLE * 0.065  # usual mean residual at 100 Hz; ripple of 0.5 N/s


def test_another_law_over_a_short_travel_is_no_shift():
    rng = np.random.default_rng(4)
    sigma = 8000.0 * np.exp(K2 * np.linspace(-4e-4, 4e-4, 250))
    assert isolate(noisy(np.full(250, 6.7), rng), sigma, K2, LIMIT).force == pytest.approx(6.7, rel=0.01)
    assert isolate(noisy(6.7 - 0.045 * (sigma - sigma.mean()) / K2, rng), sigma, K2, LIMIT) is None
