# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vsa_driver.acquisition.clock import CaptureClock

SECOND = 1_000_000_000
EPOCH = 1_800_000_000 * SECOND
STEADY = 5_000 * SECOND


def test_a_stamp_of_the_hosts_clock_passes_unchanged():
    assert CaptureClock().to_epoch(1_800_000_000.25, EPOCH + SECOND // 2, STEADY) == EPOCH + SECOND // 4


def test_a_frame_without_stamp_gets_the_time_of_arrival():
    clock = CaptureClock()
    assert clock.to_epoch(0.0, EPOCH, STEADY) == EPOCH
    assert clock.to_epoch(float("nan"), EPOCH + 7, STEADY) == EPOCH + 7


def arrivals(drift, seconds=30.0, rate=500.0, seed=4):
    """True capture times, the adapter's stamps of them, and their arrivals at the host [s], 0.2 ms late at least."""
    true = np.arange(0.0, seconds, 1 / rate)
    delay = 2e-4 + np.random.default_rng(seed).exponential(3e-3, true.size)
    return true, 17.0 + true * (1 + drift), true + delay


def mapped(clock, stamps, arrival, step_s=0.0, step_from=None):
    now = arrival + (0.0 if step_from is None else step_s * (arrival > step_from))
    return (
        np.array(
            [
                clock.to_epoch(s, EPOCH + int(n * 1e9), STEADY + int(h * 1e9)) - EPOCH
                for s, n, h in zip(stamps, now, arrival, strict=True)
            ]
        )
        / 1e9
    )


def test_an_adapter_that_counts_from_its_own_start_is_mapped_by_the_least_delay_and_its_drift_is_followed():
    for drift in (0.0, 1e-4, -1e-4):
        true, stamps, arrival = arrivals(drift)
        epoch = mapped(CaptureClock(), stamps, arrival)
        converged = slice(1000, None)
        late = (epoch - true)[converged]
        assert np.all(epoch <= arrival)
        assert np.abs(late - 2e-4).max() < 4e-4  # the arrivals alone scatter by 20 ms


def test_a_restarted_adapter_is_mapped_again():
    clock = CaptureClock()
    true, stamps, arrival = arrivals(0.0, seconds=4.0)
    stamps[1000:] -= 18.9
    epoch = mapped(clock, stamps, arrival)
    assert clock.restarts == 1
    assert np.abs(epoch - true)[1100:].max() < 2e-3


def test_stamps_follow_the_hosts_clock_when_it_is_set():
    true, stamps, arrival = arrivals(0.0, seconds=4.0)
    epoch = mapped(CaptureClock(), stamps, arrival, step_s=-5.0, step_from=2.0)
    after = arrival > 2.0
    assert np.abs(epoch - true + 5.0)[after].max() < 1e-3


@pytest.mark.parametrize("ahead", [0.11, 0.2, 1.0, 59.0, 61.0])
def test_a_clock_ahead_of_the_hosts_is_mapped_by_the_least_delay(ahead):
    true, _, arrival = arrivals(0.0, seconds=4.0)
    epoch = mapped(CaptureClock(), 1_800_000_000.0 + ahead + true, arrival)
    assert np.all(epoch <= arrival + 0.1)
    assert np.abs(epoch - true)[1000:].max() < 1e-3


def test_a_clock_slightly_ahead_of_the_hosts_passes_unchanged():
    assert CaptureClock().to_epoch(1_800_000_000.0625, EPOCH, STEADY) == EPOCH + SECOND // 16


def test_frames_stamped_before_the_clock_was_set_back_are_mapped_each_time_anew():
    clock = CaptureClock()
    for k, queued in enumerate((5.0, 4.0)):
        now, steady = EPOCH + 100 * k * SECOND, STEADY + 107 * k * SECOND
        assert clock.to_epoch(1_800_000_000.0 + 100 * k + queued, now, steady) == now
        assert clock.to_epoch(1_800_000_000.0 + 100 * k + 1.0, now + SECOND, steady + SECOND) == now + SECOND


@settings(deadline=None)
@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=30))
def test_no_stamp_raises_or_maps_into_the_future(stamps):
    clock = CaptureClock()
    for i, stamp in enumerate(stamps):
        now = EPOCH + i * SECOND
        assert clock.to_epoch(stamp, now, STEADY + i * SECOND) <= now + SECOND // 10
