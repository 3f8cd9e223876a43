# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The first-order filter of the force rate against its analytic response."""

import numpy as np
from vsa_estimator.force_rate.rate_filter import RateFilter, filtered_rate
from vsa_estimator.tuning.force_rate import RATE_FILTER


def test_the_rate_filter_lags_a_ramp_by_its_time_constant():
    """Response of a first-order lag to a ramp of 2 N/s: 2 (1 - exp(-t / tau))."""
    time = np.arange(200) * 0.01
    expected = 2.0 * (1.0 - np.exp(-time / RATE_FILTER))
    np.testing.assert_allclose(filtered_rate(2.0 * time, 0.01), expected, atol=1e-12)


def test_both_forms_of_the_rate_filter_agree():
    force, rate = 0.017 * np.random.default_rng(3).standard_normal(500), RateFilter()
    np.testing.assert_allclose([rate.add(f, 0.01) for f in force], filtered_rate(force, 0.01), rtol=1e-9, atol=1e-12)


def test_many_recordings_are_filtered_as_one_by_one():
    forces = np.random.default_rng(4).standard_normal((3, 200))
    np.testing.assert_array_equal(filtered_rate(forces, 0.01), [filtered_rate(force, 0.01) for force in forces])
