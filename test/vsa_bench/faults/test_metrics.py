# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of the fault detection on made data with known answers."""

import numpy as np
import pytest
from scipy.stats import poisson
from vsa_bench.faults.hypotheses import COLUMNS, hypothesis
from vsa_bench.faults.metrics import (
    Detection,
    alarms,
    detect,
    isolation_matrix,
    longest,
    poisson_interval,
    time_to_valid,
)
from vsa_estimator.fault_detection.consistency import AFTER_FAULT, AFTER_GAP, INCONSISTENT
from vsa_estimator.fault_detection.latch import FAULT_TEXTS
from vsa_estimator.filter_parts import POSITION_UNCERTAIN
from vsa_estimator.preprocessing.sensor_flags import SensorFlag

STUCK, STEP = "encoder stuck: constant while the force changes", "encoder step of +1.00 mm"
TIME = 0.1 * np.arange(100)


def report(time, *texts):
    return time, frozenset(texts)


def test_the_delay_is_that_of_the_first_new_text_and_the_hypothesis_that_of_the_first_text_that_names_one():
    reports = [report(30.2, INCONSISTENT), report(30.7, INCONSISTENT, STEP), report(31.0, STUCK)]
    found = detect(reports, 30.0)
    assert found == (pytest.approx(0.2), "encoder step", pytest.approx(0.7))


def test_a_text_that_was_active_before_the_fault_detects_nothing():
    reports = [report(29.5, STUCK), report(30.1, STUCK)]
    assert detect(reports, 30.0) == Detection(None, "not detected", None)
    assert detect([*reports, report(30.4, STUCK, STEP)], 30.0).delay == pytest.approx(0.4)
    assert detect(reports, 30.6) == Detection(None, "not detected", None)
    assert detect([report(28.0, STUCK), report(30.1, STUCK)], 30.0).delay == pytest.approx(0.1)


def test_a_text_that_names_several_hypotheses_isolates_none():
    assert detect([report(31.0, INCONSISTENT)], 30.0) == Detection(1.0, "not isolated", None)


def test_the_longest_run_of_flags_is_found_at_begin_middle_and_end():
    assert longest(np.zeros(4, bool), 0.1) == 0.0
    for pattern in ([1, 1, 0, 1], [1, 0, 1, 1, 0], [0, 1, 0, 1, 1]):
        assert longest(np.array(pattern, bool), 0.1) == pytest.approx(0.2)


def test_stiffness_is_valid_again_once_it_stays_valid_for_a_second():
    valid = np.ones(100, bool)
    assert time_to_valid(TIME, valid, 3.0) == 0.0
    valid[25:40] = False  # 2.5 s to 4.0 s
    valid[45] = False  # an interval of half a second does not count
    assert time_to_valid(TIME, valid, 3.0) == pytest.approx(1.6)
    assert time_to_valid(TIME, valid, 5.0) == 0.0
    valid[:] = False
    valid[92:] = True  # less than a second until the end
    assert time_to_valid(TIME, valid, 3.0) is None


def test_detections_within_a_second_of_each_other_are_one_alarm():
    degraded, resets = np.zeros(100, bool), np.zeros(100, bool)
    degraded[20:25] = degraded[30:32] = resets[33] = True
    resets[70] = True
    assert alarms(TIME, degraded, resets) == [pytest.approx(2.0), pytest.approx(7.0)]
    assert alarms(TIME, np.zeros(100, bool), np.zeros(100, bool)) == []


@pytest.mark.parametrize("count", [0, 1, 4, 30])
def test_the_poisson_interval_has_its_tail_probabilities(count):
    hours = 2.5
    low, high = poisson_interval(count, hours)
    assert poisson.cdf(count, high * hours) == pytest.approx(0.025)
    if count:
        assert poisson.sf(count - 1, low * hours) == pytest.approx(0.025)
    else:
        assert low == 0.0


def test_the_isolation_matrix_counts_runs_by_fault_and_named_hypothesis():
    pairs = [("step", "encoder step"), ("step", "encoder step"), ("step", "not isolated"), ("stuck", "encoder stuck")]
    assert isolation_matrix(pairs) == {"step": {"encoder step": 2, "not isolated": 1}, "stuck": {"encoder stuck": 1}}


def test_every_fault_text_of_the_estimator_names_its_hypothesis():
    expected = {
        SensorFlag.FORCE_NOISY: "force noisy",
        SensorFlag.ENCODER_NOISY: "encoder noisy",
        SensorFlag.BURST: "stamps late",
        SensorFlag.ENCODER_FROZEN: "encoder stuck",
        SensorFlag.FORCE_STUCK: "force stuck",
        SensorFlag.ENCODER_STUCK: "encoder stuck",
        SensorFlag.FORCE_SATURATED: "saturation",
        SensorFlag.DEFLECTION_SATURATED: "saturation",
    }
    assert {flag: hypothesis(text) for flag, text in FAULT_TEXTS.items()} == expected
    for text in (INCONSISTENT, AFTER_FAULT, AFTER_GAP, POSITION_UNCERTAIN):
        assert hypothesis(text) == "not isolated"
    assert hypothesis("force sensor drift") == hypothesis("force bias of +2.0 N") == "force bias or drift"
    assert hypothesis("transmission changed: k2") == "transmission changed"
    assert hypothesis("something else") == "other"
    assert set(expected.values()) <= set(COLUMNS)
