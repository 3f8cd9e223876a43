# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Allan deviation of noises with a known law."""

import allantools
import numpy as np
import pytest
from vsa_estimator.offline.allan import allan

STD = 0.017


def white(seed: int, count: int = 20_000) -> np.ndarray:
    return STD * np.random.default_rng(seed).standard_normal(count)


@pytest.mark.parametrize("seed", range(20))
def test_white_noise_is_measured_within_three_percent_and_classified_as_white(seed):
    found = allan(white(seed), 100.0)
    assert found.white
    assert found.std == pytest.approx(STD, rel=0.03)
    assert found.density == pytest.approx(STD / 10.0, rel=0.03)


@pytest.mark.parametrize("seed", range(20))
def test_drift_is_not_white_and_not_part_of_the_noise(seed):
    drift = np.cumsum(0.03 * STD * np.random.default_rng(100 + seed).standard_normal(20_000))
    found = allan(white(seed) + drift, 100.0)
    assert not found.white
    assert found.std == pytest.approx(STD, rel=0.03)


@pytest.mark.parametrize("count", [3, 100, 20_001])
def test_the_deviation_equals_that_of_allantools(count):
    signal = 30.0 + white(7, count) + np.linspace(0.0, 0.1, count)
    found = allan(signal, 250.0)
    tau, deviation, _, _ = allantools.oadev(signal, rate=250.0, data_type="freq", taus=found.tau)
    np.testing.assert_allclose(found.tau, tau)
    np.testing.assert_allclose(found.deviation, deviation, rtol=1e-12)


def test_smoothed_noise_is_not_white():
    assert not allan(np.convolve(white(1), np.ones(5) / 5.0, "valid"), 100.0).white


def test_a_constant_is_not_white():
    assert not allan(np.full(1000, 3.0), 100.0).white
