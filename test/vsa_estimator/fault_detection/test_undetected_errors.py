# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sensor faults: detection, delay, and no valid stiffness that is wrong meanwhile."""

import functools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_common.types import ResetReason, Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.settings import EstimatorConfig

RATE, BEGIN = 500, 20.0
FAST = (0.009, ((2.5e-3, 0.05), (3.5e-4, 0.7), (1.5e-4, 1.7)))
MAX_UNDETECTED = 0.1  # longest time in which a valid stiffness may be off by 1 % and 4 standard deviations [s]


@functools.cache
def clean(seconds, motion=MULTISINE):
    recording = record(TRANSMISSION_1, motion, seconds, RATE)
    return recording, (recording.stamp_ns - 1_000_000_000) * 1e-9


def run_with_fault(force=lambda t, f: f, deflection=lambda t, x: x, seconds=30.0, motion=MULTISINE):
    """Recording, estimates, reasons and longest undetected error [s] of a run with a sensor fault from BEGIN on."""
    recording, t = clean(seconds, motion)
    forces, deflections = force(t, recording.force.copy()), deflection(t, recording.deflection.copy())
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimates, reasons, error_time, longest = [], [], 0.0, 0.0
    samples = zip(recording.stamp_ns.tolist(), forces.tolist(), deflections.tolist(), strict=True)
    for k, sample in enumerate(samples):
        estimate = estimator.add(*sample)
        estimates.append(estimate)
        if t[k] < BEGIN:
            continue
        if k % 10 == 0:
            reasons.append((t[k] - BEGIN, estimator.state().reason))
        error = math.log(estimate.stiffness / recording.stiffness[k])
        std = math.sqrt(estimate.stiffness_variance) / estimate.stiffness
        wrong = estimate.stiffness_valid and abs(error) > max(0.01, 4.0 * std)
        error_time = error_time + 1.0 / RATE if wrong else 0.0
        longest = max(longest, error_time)
    return recording, estimates, reasons, longest


def reported_after(reasons, text):
    return next((after for after, reason in reasons if text in reason), math.inf)


def within(t, seconds):
    return (t > BEGIN) & (t < BEGIN + seconds)


def test_a_drifting_force_is_detected_before_the_stiffness_is_wrong():
    drift = lambda t, f: f + 0.5 * (t - BEGIN) * within(t, 4.0)  # noqa: E731
    recording, estimates, reasons, error_time = run_with_fault(force=drift)
    assert reported_after(reasons, "inconsistent") < 1.2
    assert error_time < MAX_UNDETECTED
    assert estimates[-1].status is Status.VALID
    assert estimates[-1].stiffness == pytest.approx(recording.stiffness[-1], rel=0.003)


def test_a_force_offset_that_stays_is_taken_over_and_the_stiffness_kept():
    recording, estimates, _, error_time = run_with_fault(force=lambda t, f: f + 5.0 * (t > BEGIN))
    assert error_time < MAX_UNDETECTED
    assert (estimates[-1].reset_count, estimates[-1].reset_reason) == (1, ResetReason.INNOVATION)
    assert estimates[-1].status is Status.VALID
    assert estimates[-1].force_offset == pytest.approx(TRANSMISSION_1.force_offset + 5.0, abs=0.3)
    assert estimates[-1].stiffness == pytest.approx(recording.stiffness[-1], rel=0.003)


def test_a_drifting_encoder_makes_no_valid_stiffness_wrong():
    drift = lambda t, x: x + 1e-4 * (t - BEGIN) * within(t, 4.0)  # noqa: E731
    recording, estimates, reasons, error_time = run_with_fault(deflection=drift)
    assert reported_after(reasons, "inconsistent") < 1.0
    assert error_time < MAX_UNDETECTED
    assert estimates[-1].stiffness == pytest.approx(recording.stiffness[-1], rel=0.003)


@pytest.mark.parametrize("sensor", ["force", "deflection"])
def test_a_noisy_sensor_is_reported_and_the_interval_holds(sensor):
    rng = np.random.default_rng(5)
    std = {"force": 0.17, "deflection": 1e-4}[sensor]
    noisy = lambda t, value: value + std * rng.standard_normal(t.size) * within(t, 3.0)  # noqa: E731
    recording, estimates, reasons, error_time = run_with_fault(**{sensor: noisy})
    assert reported_after(reasons, "noisy") < 0.3
    assert error_time < MAX_UNDETECTED
    assert estimates[-1].status is Status.VALID
    assert estimates[-1].stiffness == pytest.approx(recording.stiffness[-1], rel=0.003)


@pytest.mark.parametrize("size", [3e-4, -5e-4, 1e-3, -2e-3])
def test_an_encoder_step_in_fast_motion_is_not_followed(size):
    steps = BEGIN + 3.1 * np.arange(7)  # and back after a second; no two in the same phase of the motion
    stepping = lambda t, x: x + size * sum((t >= begin) & (t < begin + 1.0) for begin in steps)  # noqa: E731
    recording, estimates, reasons, error_time = run_with_fault(deflection=stepping, seconds=44.0, motion=FAST)
    assert error_time < MAX_UNDETECTED
    reported = [any("encoder step" in why and 0.0 < BEGIN + at - t < 0.5 for at, why in reasons) for t in steps]
    assert sum(reported) >= 6
    assert estimates[-1].stiffness == pytest.approx(recording.stiffness[-1], rel=0.003)


def test_a_stuck_encoder_makes_no_valid_stiffness_wrong():
    stuck = lambda t, x: np.where(within(t, 2.0), x[np.searchsorted(t, BEGIN)], x)  # noqa: E731
    recording, estimates, reasons, error_time = run_with_fault(deflection=stuck)
    assert reported_after(reasons, "encoder stuck") < 0.2
    assert error_time < MAX_UNDETECTED
    assert estimates[-1].stiffness == pytest.approx(recording.stiffness[-1], rel=0.003)


def test_a_burst_of_queued_samples_makes_no_valid_stiffness_wrong():
    recording, t = clean(30.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    arrival_ns = recording.stamp_ns.copy()
    late = (t >= BEGIN) & (t < BEGIN + 0.06)
    arrival_ns[late] = arrival_ns[late][-1] + 1000 * np.arange(late.sum())  # 60 ms of samples at once
    reasons, invalid, sensor_fault, error_time, longest = [], 0.0, False, 0.0, 0.0
    for k, sample in enumerate(zip(arrival_ns.tolist(), recording.force.tolist(), recording.deflection.tolist())):  # noqa: B905
        estimate = estimator.add(*sample)
        if estimate is None or t[k] < BEGIN:
            continue
        reasons.append((t[k] - BEGIN, estimator.state().reason) if k % 5 == 0 else (math.inf, ""))
        sensor_fault |= estimator.state().sensor_fault
        invalid += 0.0 if estimate.force_valid else 1.0 / RATE
        error = abs(math.log(estimate.stiffness / recording.stiffness[k]))
        std = math.sqrt(estimate.stiffness_variance) / estimate.stiffness
        error_time = error_time + 1.0 / RATE if estimate.stiffness_valid and error > max(0.01, 4.0 * std) else 0.0
        longest = max(longest, error_time)
    assert reported_after(reasons, "burst") < 0.1
    assert not sensor_fault
    assert invalid < 0.25  # the samples are right: for less time than the text is shown
    assert longest < MAX_UNDETECTED
    assert estimate.status is Status.VALID


NUMBERS = st.floats(width=64) | st.sampled_from([0.0, 0.01, 20.0, -1e300, 5e-324])


@settings(deadline=None, max_examples=100)
@given(st.lists(st.tuples(st.integers(-(2**63), 2**63 - 1) | st.integers(1, 10**10), NUMBERS, NUMBERS), max_size=40))
def test_no_stamp_and_no_number_makes_the_estimator_raise_or_its_output_non_finite(samples):
    estimator = Estimator(EstimatorConfig())
    for stamp_ns, force, deflection in samples:
        for estimate in (estimator.add(stamp_ns, force, deflection), estimator.predict_to(stamp_ns)):
            assert estimate is None or np.isfinite(estimate).all()
        covariance = np.array(estimator.state().coefficient_covariance).reshape(7, 7)
        assert np.isfinite(covariance).all()
        assert (covariance == covariance.T).all()
