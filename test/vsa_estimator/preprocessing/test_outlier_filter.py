# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Single outliers of a fast stream."""

import numpy as np
from vsa_estimator.preprocessing.outlier_filter import accept, initial_outlier

STD = 0.01


def accepted(values, vibration=0.0):
    outlier = initial_outlier(STD)[0]
    return [bool(accept(outlier, float(value), vibration)) for value in values]


def test_white_noise_on_a_smooth_motion_is_accepted():
    k = np.arange(2000)
    assert all(accepted(np.sin(0.01 * k) + np.random.default_rng(1).normal(0.0, STD, k.size)))


def test_a_single_outlier_is_rejected_and_the_next_sample_accepted():
    values = np.zeros(20)
    values[10] = 1.0
    assert [k for k, passed in enumerate(accepted(values)) if not passed] == [10]


def test_a_step_of_the_signal_is_accepted_after_two_samples():
    values = np.where(np.arange(20) < 10, 0.0, 1.0)
    assert [k for k, passed in enumerate(accepted(values)) if not passed] == [10, 11]


def test_a_vibration_within_its_bound_is_accepted_and_an_outlier_in_it_rejected():
    values = np.sin(2.0 * np.pi / 3.0 * np.arange(60))  # 167 Hz at 500 Hz
    assert not all(accepted(values))
    assert all(accepted(values, vibration=1.0))
    values[30] = 10.0
    assert [k for k, passed in enumerate(accepted(values, vibration=1.0)) if not passed] == [30]
