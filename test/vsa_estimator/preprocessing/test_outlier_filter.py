# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Single outliers of a fast stream."""

import numpy as np
from vsa_estimator.preprocessing.outlier_filter import accept, initial_outlier

STD = 0.01


def accepted(values):
    outlier = initial_outlier(STD)[0]
    return [bool(accept(outlier, float(value))) for value in values]


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


def test_a_growing_vibration_is_accepted_and_an_outlier_in_it_rejected():
    k = np.arange(200)
    values = np.minimum(np.exp(0.05 * k) * STD, 1.0) * np.sin(2.0 * np.pi / 3.0 * k)  # 167 Hz at 500 Hz
    assert all(accepted(values))
    values[150] += 20.0
    assert [k for k, passed in enumerate(accepted(values)) if not passed] == [150]


def test_outliers_in_a_row_do_not_raise_the_gate():
    values = np.zeros(200)
    values[20::20] = 1.0
    assert [k for k, passed in enumerate(accepted(values)) if not passed] == list(range(20, 200, 20))
