# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Samples lost before a sample, by sequence numbers that come before or after it."""

from vsa_estimator.preprocessing.sequence_gaps import SequenceGaps
from vsa_estimator.tuning.preprocessing import MAX_GAPS


def test_lost_samples_count_once_with_the_next_sample_that_is_not_earlier():
    gaps = SequenceGaps()
    gaps.add([10, 20], [1, 2])
    assert gaps.lost_before(20) == 0
    gaps.add([50, 60, 90], [5, 6, 9])
    assert gaps.lost_before(40) == 0
    assert gaps.lost_before(60) == 2  # that of stamp 50 did not come
    assert gaps.lost_before(90) == 2
    assert gaps.lost_before(100) == 0


def test_a_new_device_and_a_repeated_number_are_no_gap():
    gaps = SequenceGaps()
    gaps.add([10, 20, 30, 40], [100, 100, 3, 4])
    assert gaps.lost_before(40) == 0


def test_gaps_are_bounded_without_samples():
    gaps = SequenceGaps()
    count = 3 * MAX_GAPS
    gaps.add(range(count), range(0, 2 * count, 2))
    assert gaps.lost_before(count) == MAX_GAPS
