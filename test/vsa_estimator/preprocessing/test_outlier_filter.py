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
