# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vsa_driver.acquisition.counter import RollingCounter, Unwrapped

MS = 1_000_000


def feed(counter, raws, period_ns=MS, start_ns=10**18):
    return [counter.add(raw, start_ns + i * period_ns) for i, raw in enumerate(raws)]


@settings(deadline=None)
@given(
    st.integers(4, 24),
    st.integers(-(2**30), 2**30),
    st.lists(st.floats(-0.49, 0.49), max_size=200),
)
def test_any_motion_below_half_a_period_per_sample_is_unwrapped(bits, start, moves):
    period = 2**bits
    position, true = start, [start]
    for move in moves:
        position += int(move * period)
        true.append(position)
    unwrapped = Unwrapped(period, centre=start)
    assert [unwrapped.add(value % period) for value in true] == true


def test_the_first_count_is_unwrapped_nearest_to_the_centre_of_the_travel():
    assert Unwrapped(65536, centre=1000).add(65531) == -5
    assert Unwrapped(1024, centre=1000).add(0) == 1024
    assert Unwrapped(1024, centre=1000).add(1000) == 1000


def test_sequence_numbers_continue_through_the_wrap():
    assert feed(RollingCounter(16), [65534, 65535, 0, 1]) == [65534, 65535, 65536, 65537]
    assert feed(RollingCounter(8), [254, 255, 0, 1]) == [254, 255, 256, 257]


def test_a_gap_is_counted_with_its_length_also_across_the_wrap():
    counter = RollingCounter(16)
    feed(counter, [65530, 65531, 65532])
    assert counter.add(3, 10**18 + 9 * MS) == 65536 + 3
    assert counter.lost == 6


def test_a_repeated_or_late_frame_has_no_sequence_number():
    counter = RollingCounter(16)
    assert feed(counter, [7, 8, 8, 10, 9, 11], period_ns=MS // 2) == [7, 8, None, 10, None, 11]
    assert (counter.duplicates, counter.late, counter.lost, counter.restarts) == (1, 1, 1, 0)


@pytest.mark.parametrize("before", [50, 12_345, 40_000, 50_000])
def test_a_restarted_device_is_distinguished_from_a_gap(before):
    counter = RollingCounter(16)
    feed(counter, range(before - 20, before))
    numbers = feed(counter, [0, 1, 2], start_ns=10**18 + 520 * MS)
    assert numbers == [None, 1, 2]  # the first may be corrupted; the second confirms it
    assert (counter.restarts, counter.lost, counter.implausible) == (1, 0, 1)


def test_garbage_among_the_numbers_is_counted_and_nothing_else_changes():
    counter = RollingCounter(16)
    assert feed(counter, [7, 8, 30_000, 9, 60_000, 200, 10, 11], period_ns=MS // 2) == [
        7,
        8,
        None,
        9,
        None,
        None,
        10,
        11,
    ]
    assert (counter.implausible, counter.lost, counter.restarts) == (3, 0, 0)


def test_samples_that_are_all_fifty_milliseconds_late_are_counted_until_a_burst_clears_the_backlog():
    counter = RollingCounter(16)
    feed(counter, range(1000), period_ns=2 * MS)
    assert counter.delayed == 0
    for number in range(1000, 1500):
        counter.add(number, 10**18 + number * 2 * MS + 50 * MS)
    assert 50 < counter.delayed <= 500
    delayed = counter.delayed
    for number in range(1500, 3000):
        counter.add(number, 10**18 + max(number * 2 * MS, 1500 * 2 * MS + 48 * MS + number))
    assert counter.delayed <= delayed + 25
    assert (counter.lost, counter.restarts) == (0, 0)


def test_garbage_among_the_counts_does_not_shift_the_unwrapped_value_permanently():
    count = Unwrapped(period=65536, centre=1000, max_travel=2150)
    for garbage in (30_000, 60_000, 25_000, 55_000, 20_000, 50_000, 10_000):
        count.add(garbage)
    assert [count.add(raw) for raw in (1000, 65_530, 2000)] == [1000, -6, 2000]


@pytest.mark.parametrize("silence", [5_000, 40_000, 65_600, 200_000])
def test_samples_lost_in_a_long_silence_are_counted_by_the_clock(silence):
    counter = RollingCounter(16)
    feed(counter, range(100))
    number = counter.add((99 + silence) % 65536, 10**18 + (99 + silence) * MS + MS // 3)
    assert number == 99 + silence
    assert (counter.lost, counter.restarts) == (silence - 1, 0)


@pytest.mark.parametrize(("bits", "pause_ms"), [(8, 300), (16, 5_000), (16, 100_000)])
def test_a_device_that_paused_has_lost_no_sample(bits, pause_ms):
    counter = RollingCounter(bits)
    feed(counter, range(100))
    assert counter.add(100, 10**18 + (99 + pause_ms) * MS) == 100
    assert (counter.lost, counter.restarts) == (0, 0)


@settings(deadline=None, max_examples=200)
@given(
    st.integers(1, 32), st.lists(st.tuples(st.integers(0, 2**32 - 1), st.integers(-(10**10), 2 * 10**18)), max_size=60)
)
def test_no_sequence_of_numbers_and_stamps_raises(bits, frames):
    counter = RollingCounter(bits)
    for raw, stamp_ns in frames:
        number = counter.add(raw % 2**bits, stamp_ns)
        assert number is None or number % 2**bits == raw % 2**bits
    assert min(counter.lost, counter.duplicates, counter.late, counter.restarts) >= 0
