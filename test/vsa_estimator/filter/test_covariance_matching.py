# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Innovation covariance matching: white jerk is rougher than most motions, and the intervals follow the innovations."""

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.filter.excitation import accumulate_matching, consistency_ratio, reset_matching
from vsa_estimator.filter.records import initial_excitation
from vsa_estimator.tuning.filter import MATCHING_TIME_CONSTANT, MIN_MATCHING_SPEED


def after(seconds, predicted_var, observed_var, speed=1e-3):
    excitation = initial_excitation()
    for _ in range(round(100 * seconds)):
        accumulate_matching(excitation, speed, predicted_var, observed_var, 0.01)
    return excitation


def test_the_consistency_ratio_converges_to_observed_over_predicted_variance():
    assert consistency_ratio(initial_excitation()) == 1.0
    assert consistency_ratio(after(0.1, 4.0, 1.0)) > 0.95
    assert consistency_ratio(after(5.0 * MATCHING_TIME_CONSTANT, 4.0, 1.0)) == pytest.approx(0.25, abs=0.01)
    assert consistency_ratio(after(5.0 * MATCHING_TIME_CONSTANT, 4.0, 9.0)) == 1.0
    assert consistency_ratio(after(5.0 * MATCHING_TIME_CONSTANT, 4.0, -1.0)) < 0.01
    assert consistency_ratio(after(5.0 * MATCHING_TIME_CONSTANT, 4.0, 1.0, speed=0.9 * MIN_MATCHING_SPEED)) == 1.0


def test_a_reset_of_the_matching_restores_the_predicted_variance():
    excitation = after(5.0 * MATCHING_TIME_CONSTANT, 4.0, 1.0)
    reset_matching(excitation)
    assert consistency_ratio(excitation) == 1.0


def test_intervals_narrow_in_smooth_motion_and_widen_at_a_manoeuvre():
    recording = record(TRANSMISSION_1, MULTISINE, 41.0, rate=100)
    late = recording.stamp_ns >= recording.stamp_ns[0] + 40_000_000_000
    stroke = np.where(late, 1e-3 * (1.0 - np.cos(25.0 * (np.cumsum(late) - 1.0) / 100.0)), 0.0)
    estimator, scales = Estimator(wrong_start(TRANSMISSION_1)), []
    deflection = (recording.deflection + stroke).tolist()
    for sample in zip(recording.stamp_ns.tolist(), recording.force.tolist(), deflection, strict=True):
        estimator.add(*sample)
        uncertainty = estimator._supervisor.tracker.state[0]["uncertainty"]
        scales.append((float(uncertainty["position_scale"]), float(uncertainty["velocity_scale"])))
    smooth, manoeuvre = np.array(scales)[~late], np.array(scales)[late]
    assert (np.array(scales[0]) == 1.0).all()
    assert (smooth[-1] < [0.8, 0.6]).all()
    assert (manoeuvre[20:].max(axis=0) > 0.99).all()
