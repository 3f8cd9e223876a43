# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Manoeuvre detection: the jerk density rises at the onset of a motion and settles again."""

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, column, measure, run, wrong_start
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.fault_detection.encoder_step import OffsetHypothesis
from vsa_estimator.filter.process_noise import JerkDensity

NOMINAL_NIS = 1.0


def test_chi_square_innovations_cause_less_than_one_false_alarm_in_a_thousand():
    generator = np.random.default_rng(2)
    jerk = JerkDensity()
    assert sum(jerk.detect_manoeuvre(float(nis)) for nis in generator.chisquare(1, 20_000)) < 20


def test_three_large_innovations_raise_the_density_by_orders_of_magnitude():
    jerk = JerkDensity()
    for _ in range(100):
        jerk.detect_manoeuvre(NOMINAL_NIS)
    before = jerk.density
    assert not jerk.detect_manoeuvre(40.0)  # a single one is an outlier
    assert jerk.detect_manoeuvre(40.0)
    for _ in range(5):
        jerk.detect_manoeuvre(40.0)
    assert jerk.density > 1000.0 * before


def test_the_density_stays_within_the_bank():
    jerk = JerkDensity()
    for _ in range(100):
        jerk.detect_manoeuvre(1e9)
    assert jerk.density <= 10.0


@pytest.mark.parametrize(
    ("offsets", "onset"),
    [((1.0, 1.6, 2.3), True), ((-1.0, -1.6, -2.3), True), ((0.5, 1.0, 1.0), False), ((1.0, -2.0, 4.0), False)],
    ids=["motion", "motion back", "encoder step", "outliers"],
)
def test_growing_offsets_are_a_motion_onset_and_constant_ones_an_encoder_step(offsets, onset):
    hypothesis = OffsetHypothesis()
    for offset in offsets:
        assert not hypothesis.is_motion_onset
        hypothesis.reject(0.01 + 1e-4 * offset, 1e-4 * offset, 0.0, 0.0)
    assert hypothesis.is_motion_onset == onset


def motion_with_rest(seconds=20.0, rest=15.0, travel=3e-3, rise=0.1, rate=500):
    """A multisine, a rest and a fast point-to-point motion: time, position, velocity, acceleration."""
    t = np.arange(round((seconds + rest + 1.0) * rate)) / rate
    centre, tones = MULTISINE
    fade = np.clip((t - seconds) / 0.5, 0.0, 1.0)
    x = centre + (1.0 - fade**3 * (10.0 - 15.0 * fade + 6.0 * fade**2)) * sum(
        amplitude * np.sin(2.0 * np.pi * frequency * t) for amplitude, frequency in tones
    )
    step = np.clip((t - seconds - rest) / rise, 0.0, 1.0)
    x = x - travel * step**3 * (10.0 - 15.0 * step + 6.0 * step**2)
    return t, x, np.gradient(x, t), np.gradient(np.gradient(x, t), t)


def test_a_fast_motion_after_a_long_rest_is_tracked_without_a_reset():
    t, *motion = motion_with_rest()
    recording = measure(TRANSMISSION_1, t, *motion)
    estimates = run(Estimator(wrong_start(TRANSMISSION_1)), recording)
    late = t > 34.0
    status, resets = column(estimates, "status"), column(estimates, "reset_count")
    assert Status.DEGRADED not in status[late]
    assert (status[late] != Status.VALID).sum() < 25  # 50 ms: motion onset and encoder step are not yet isolated
    assert resets[-1] == resets[late][0]
    error = np.abs(column(estimates, "stiffness") / recording.stiffness - 1.0)
    std = np.sqrt(column(estimates, "stiffness_variance")) / recording.stiffness
    assert error[t > 35.2].max() < 0.02
    assert (error[late] > np.maximum(0.01, 4.0 * std[late])).sum() < 10  # 20 ms at the onset
