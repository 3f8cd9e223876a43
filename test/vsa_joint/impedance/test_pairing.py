# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Pairing of both transmissions through the fusion: losses, delays, gaps, skew; instants are given."""

import pytest
from transmission_streams import MS, feed, fusion, run, skews_ms
from vsa_common.types import Status
from vsa_joint.tuning import QUEUE_LENGTH


@pytest.mark.parametrize("lost", [(0, 20), (1, 20)])
@pytest.mark.parametrize("offset", [0.1, 0.4])
def test_a_lost_sample_costs_one_pair_and_does_not_shift_the_pairing(lost, offset):
    core = fusion(max_skew=0.005)
    out = run(core, 60, lost=[lost], offset=offset)
    assert len(out) == 59
    assert max(skews_ms(out)) == pytest.approx(offset)
    assert core.counts.unpaired == 1


@pytest.mark.parametrize("late", [0.45, 0.55, 0.7])
@pytest.mark.parametrize("index", [0, 1])
def test_a_frame_delayed_by_more_than_half_a_period_pairs_with_its_own_sample(index, late):
    core, out = fusion(max_skew=0.005), []
    for k in range(60):
        stamps = {0: k, 1: k + 0.02}
        stamps[index] += late * (k == 20)
        for number in sorted(stamps, key=stamps.get):
            estimate = feed(core, number, stamps[number])
            out += [estimate] if estimate else []
    assert [round(e.transmission_stamp_ns[1 - index] / MS) for e in out] == list(range(60))
    assert core.counts.unpaired == 0


@pytest.mark.parametrize("index", [0, 1])
def test_frames_delayed_by_a_stall_pair_with_their_own_samples(index):
    """The sender stalled between both frames of a sample, and then caught up."""
    first = [18.0, 19.0, 20.04, 23.01, 23.17, 23.98, 24.15, 25.0, 26.0, 27.0]
    second = [18.02, 19.02, 22.14, 23.03, 23.19, 24.0, 24.17, 25.02, 26.02, 27.02]
    core = fusion()
    out = run(core, 18, offset=0.02)
    arrivals = [(stamp, index) for stamp in first] + [(stamp, 1 - index) for stamp in second]
    out += [estimate for stamp, one in sorted(arrivals) if (estimate := feed(core, one, stamp))]
    expected = [(round(a * MS), round(b * MS)) for a, b in zip(first, second, strict=True)]
    paired = [e.transmission_stamp_ns for e in out[18:]]
    assert [pair if index == 0 else pair[::-1] for pair in paired] == expected[: len(paired)]
    assert len(paired) >= len(expected) - 1  # the last may be pending
    assert core.counts.unpaired == 0


DELAYED = [
    [(1.69, 1.72), (2.64, 2.66), (7.03, 8.17), (8.40, 8.79), (9.03, 9.04), (10.46, 10.48)],
    [(1.01, 1.03), (2.00, 2.02), (2.61, 3.04), (3.19, 3.54), (3.68, 3.70), (4.22, 4.23)],
    [(2.01, 2.03), (2.80, 3.32), (5.14, 7.41), (7.54, 7.55), (8.10, 8.12)],
]


@pytest.mark.parametrize("frames", DELAYED)
@pytest.mark.parametrize("index", [0, 1])
def test_frames_of_a_sender_that_was_interrupted_between_them_pair_with_their_own_samples(frames, index):
    core, out = fusion(max_skew=0.005), []
    run(core, 400, offset=0.02 - 0.04 * index)
    for sample in frames:
        for number, stamp in zip((index, 1 - index), sample, strict=True):
            out.append(feed(core, number, 398.5 + stamp))
    out += run(core, 440, offset=0.02 - 0.04 * index, first=420)
    pairs = [tuple(round(ns / MS - 398.5, 2) for ns in e.transmission_stamp_ns) for e in out if e]
    assert pairs[: len(frames)] == [sample if index == 0 else sample[::-1] for sample in frames]
    assert core.counts.unpaired == 0


@pytest.mark.parametrize("index", [0, 1])
def test_a_long_gap_within_a_sample_does_not_shift_the_pairing(index):
    core, out = fusion(max_skew=0.005), []
    run(core, 400, offset=0.02 - 0.04 * index)
    feed(core, index, 400.0)
    feed(core, 1 - index, 576.7)  # of the same sample
    for k in range(40):
        for number in (index, 1 - index):
            out.append(feed(core, number, 577.0 + 0.1 * k + 0.02 * (number != index)))
    assert skews_ms(filter(None, out)) == pytest.approx([0.02] * 40, rel=1e-3)
    assert core.counts.unpaired == 2


@pytest.mark.parametrize("ahead", [0, 1])
def test_after_a_gap_of_both_transmissions_their_own_samples_pair(ahead):
    core, out = fusion(max_skew=0.005), []
    for k in range(60):
        for index in (0, 1):
            feed(core, index, 20.0 * k + 0.02 * index)
    for index in (0, 1):
        feed(core, index, 1280.0 + 0.02 * index, status=Status.STALE)
    feed(core, 1 - ahead, 1290.0, status=Status.STALE)  # the other transmission has resumed
    for k in range(8):  # the backlog of the gap
        for index in (ahead, 1 - ahead):
            estimate = feed(core, index, 1292.0 + 0.7 * k + 0.02 * (index != ahead))
            out += [estimate] if estimate else []
    assert len(out) == 8
    assert skews_ms(out) == pytest.approx([0.02] * 8, rel=1e-3)
    assert core.counts.unpaired == 0


@pytest.mark.parametrize("silent", [0, 1])
def test_a_prediction_pairs_with_the_simultaneous_measurement_of_the_other_transmission(silent):
    core = fusion(max_skew=0.005)
    run(core, 60)
    out = []
    for k in range(60, 160):
        estimates = [feed(core, 1 - silent, k + 0.3)]
        if k >= 110 and k % 10 == 0:
            estimates.append(feed(core, silent, k + 0.6, status=Status.STALE))
        out += filter(None, estimates)
    assert len(out) == 5
    assert max(skews_ms(out)) < 0.5
    assert all(e.status == Status.STALE for e in out)


def test_stamps_beyond_max_skew_do_not_pair():
    core = fusion(max_skew=0.001)
    assert feed(core, 0, 0) is None
    assert feed(core, 1, 1.5) is None
    assert feed(core, 0, 1.6) is not None
    assert core.counts.unpaired == 1


def test_a_delayed_burst_pairs_in_order():
    core = fusion()
    for k in range(100):
        assert feed(core, 0, k) is None
    out = [feed(core, 1, k + 0.1, now_ms=100) for k in range(100)]
    assert all(out)
    assert max(skews_ms(out)) == pytest.approx(0.1)


def test_the_queue_without_partners_is_bounded():
    core = fusion()
    run(core, QUEUE_LENGTH + 500, lost=[(1, k) for k in range(QUEUE_LENGTH + 500)])
    assert core.counts.unpaired == 500


def test_after_a_time_reset_samples_pair():
    core = fusion()
    for index in (0, 1):
        for k in range(20):
            feed(core, index, 5000 + k)
    out = run(core, 30)
    assert len(out) == 30
