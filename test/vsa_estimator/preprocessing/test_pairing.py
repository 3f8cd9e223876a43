# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Approximate time synchronisation of force and encoder messages."""

import numpy as np
import pytest
from vsa_estimator.preprocessing.pairing import ENCODER, FORCE, Pairing, Sample, pair_all

MS = 1_000_000


def test_equal_stamps_make_a_sample_whichever_comes_first():
    pairing = Pairing(0, 50 * MS)
    assert pairing.add_force(10 * MS, 20.0) == []
    assert pairing.add_encoder(10 * MS, 0.01) == [Sample(10 * MS, 20.0, 0.01)]
    assert pairing.add_encoder(20 * MS, 0.02) == []
    assert pairing.add_force(20 * MS, 21.0) == [Sample(20 * MS, 21.0, 0.02)]
    assert pairing.dropped == 0


@pytest.mark.parametrize("lead", [1, 7, 30])
def test_one_stream_may_lead_by_many_messages(lead):
    pairing = Pairing(0, 50 * MS)
    out = []
    for k in range(100):
        out += pairing.add_force(k * MS, float(k))
        if k >= lead:
            out += pairing.add_encoder((k - lead) * MS, 0.001 * (k - lead))
    assert [sample.stamp_ns for sample in out] == [k * MS for k in range(100 - lead)]
    assert pairing.dropped == 0


def test_stamps_within_the_tolerance_pair_with_the_nearest_and_take_the_force_stamp():
    pairing = Pairing(2 * MS, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(13 * MS, 2.0)
    assert pairing.add_encoder(12 * MS, 0.01) == []  # an older message is queued
    assert pairing.add_encoder(9 * MS, 0.009) == [Sample(10 * MS, 1.0, 0.009), Sample(13 * MS, 2.0, 0.01)]


def test_a_message_is_dropped_and_counted_when_the_other_stream_has_passed_it_by_the_window():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(20 * MS, 2.0)
    assert pairing.add_encoder(20 * MS, 0.02) == []
    pairing.add_force(61 * MS, 3.0)
    assert pairing.dropped == 0
    assert [sample.stamp_ns for sample in pairing.add_encoder(61 * MS, 0.03)] == [20 * MS, 61 * MS]
    assert pairing.dropped == 1


@pytest.mark.parametrize("first", ["force", "encoder"])
def test_a_long_delay_of_one_stream_loses_no_message(first):
    pairing = Pairing(0, 50 * MS)
    prompt, late = pairing.add_force, pairing.add_encoder
    if first == "encoder":
        prompt, late = late, prompt
    assert not any(prompt(k * MS, 0.01) for k in range(1, 1000))
    out = [sample.stamp_ns for k in range(1, 1000) for sample in late(k * MS, 0.01)]
    assert out == [k * MS for k in range(1, 1000)]
    assert pairing.dropped == 0


def test_reordered_messages_become_samples_in_order():
    pairing = Pairing(0, 50 * MS)
    out = []
    for k in (0, 2, 1, 3):
        out += pairing.add_force(k * MS, float(k))
    for k in (1, 0, 3, 2):
        out += pairing.add_encoder(k * MS, float(k))
    assert [sample.stamp_ns for sample in out] == [0, MS, 2 * MS, 3 * MS]


def test_queues_are_bounded_when_one_stream_is_down():
    pairing = Pairing(0, 10_000 * MS, capacity=100)
    for k in range(1000):
        pairing.add_force(k * MS, 0.0)
    assert pairing.dropped == 900


def test_a_second_message_with_the_same_stamp_is_counted():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(10 * MS, 1.5)
    assert pairing.dropped == 1
    assert pairing.add_encoder(10 * MS, 0.01) == [Sample(10 * MS, 1.5, 0.01)]


def test_a_time_reset_does_not_block_later_messages():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(100_000 * MS, 1.0)
    pairing.add_force(10 * MS, 2.0)
    assert [sample.stamp_ns for sample in pairing.add_encoder(10 * MS, 0.01)] == [10 * MS]


@pytest.mark.parametrize("back", [2000, 5000])
def test_a_clock_that_is_set_back_by_seconds_goes_on_with_the_next_messages(back):
    pairing, out = Pairing(0, 100 * MS), []
    for k in range(10_000, 10_100):
        out += [*pairing.add_force(k * MS, 1.0), *pairing.add_encoder(k * MS, 0.01)]
    pairing.add_force(10_100 * MS, 1.0)
    pairing.add_force(10_101 * MS, 1.0)
    pairing.add_encoder(10_101 * MS, 0.01)  # a pair that is later than a message without its partner
    before = len(out)
    for k in range(10_102 - back, 10_202 - back):
        out += [*pairing.add_force(k * MS, 1.0), *pairing.add_encoder(k * MS, 0.01)]
    assert [sample.stamp_ns for sample in out[before:]] == [k * MS for k in range(10_102 - back, 10_202 - back)]
    assert pairing.dropped == 3


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("reordered", [False, True])
def test_a_recording_is_paired_as_live_messages_are(seed, reordered):
    generator = np.random.default_rng(seed)
    arrivals = []
    for sensor in (FORCE, ENCODER):
        stamps = np.flatnonzero(generator.random(600) > 0.1) * MS  # a tenth is lost
        # and the encoder is delayed at times
        late = np.maximum.accumulate(stamps + sensor * 400 * MS * (generator.random(len(stamps)) > 0.99))
        if reordered:
            late = late + generator.integers(0, 3 * MS, len(stamps))
        arrivals += [(at, sensor, stamp, 0.1 * k) for k, (at, stamp) in enumerate(zip(late, stamps, strict=True))]
    rows = [row[1:] for row in sorted(arrivals)]
    pairing = Pairing(0, 100 * MS)
    add = {FORCE: pairing.add_force, ENCODER: pairing.add_encoder}
    live = [tuple(sample) for sensor, stamp, value in rows for sample in add[sensor](int(stamp), value)]
    sensors, stamps, values = zip(*rows, strict=True)
    columns = pair_all(np.array(sensors, np.uint8), np.array(stamps, np.int64), np.array(values), 0, 100 * MS)
    assert len(live) > 200
    assert list(zip(*(column.tolist() for column in columns), strict=True))[: len(live)] == live
