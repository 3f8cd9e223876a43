# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Instants of samples from stamps that are delayed or uneven, or with samples lost."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from transmission_data import MULTISINE, SLOW, TRANSMISSION_1, column, record, run, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.preprocessing.clock_estimate import initial_clock, update_clock
from vsa_estimator.preprocessing.timestamp_filter import corrected_stamp, initial_timestamps


def delayed(taken, seed=5, delay_rate=8.0, mean_delay=8e-3):
    """Stamps [s] of a sender that is delayed `delay_rate` times a second, and then catches up."""
    rng = np.random.default_rng(seed)
    stamp = taken + np.abs(rng.normal(0.0, 1e-4, taken.size))
    for begin in np.sort(rng.uniform(taken[0], taken[-1], rng.poisson(delay_rate * np.ptp(taken)))):
        end = begin + rng.exponential(mean_delay)
        waiting = (taken >= begin) & (taken < end)
        stamp[waiting] = np.maximum(stamp[waiting], end + 5e-5 * np.arange(np.count_nonzero(waiting)))
    for index in range(1, stamp.size):
        stamp[index] = max(stamp[index], stamp[index - 1] + 2e-5)
    return stamp


def overloaded(taken, seed=5):
    """Stamps [s] of a sender that needs most of a period for each sample, and catches up slowly."""
    rng = np.random.default_rng(seed)
    period, load, free = taken[1] - taken[0], 1.0, 0.0
    stamp = np.empty_like(taken)
    for index, when in enumerate(taken):
        if rng.uniform() < 0.01:
            load = rng.choice([0.2, 0.3, 0.5, 0.8])
        free = max(free, when) + 1e-4 + 0.7 * load * period * rng.exponential()
        stamp[index] = free
    return stamp


def instants(stamp, taken, motion=SLOW, lost=None):
    """Corrected stamps [s] of the samples of a motion; `lost` before each, where the driver counts them."""
    recording = record(TRANSMISSION_1, motion, stamps=taken)
    timestamps, corrected = initial_timestamps()[0], []
    timestamps["clock"]["is_counted"] = lost is not None
    stamp_ns = 10**18 + np.round(stamp * 1e9).astype(np.int64)
    for k, sample in enumerate(zip(stamp_ns.tolist(), recording.deflection.tolist(), strict=True)):
        timestamps["clock"]["lost"] += 0 if lost is None else lost[k]
        corrected.append(corrected_stamp(timestamps, *sample))
    return (np.array(corrected) - 10**18) * 1e-9


@pytest.mark.parametrize("rate", [500, 1000])
@pytest.mark.parametrize("motion", [SLOW, MULTISINE], ids=["slow", "multisine"])
def test_sample_clock_is_estimated_from_delayed_stamps(rate, motion):
    taken = np.arange(10 * rate) / rate
    stamp = delayed(taken)
    error = (instants(stamp, taken, motion) - taken)[3 * rate :]
    assert np.std((stamp - taken)[3 * rate :]) > 1.5e-3
    assert np.std(error) < 1e-4


@pytest.mark.parametrize("seed", [5, 6, 7])
def test_sample_clock_is_estimated_from_a_sender_that_catches_up_slowly(seed):
    taken = np.arange(10000) / 500
    stamp = overloaded(taken, seed)
    clock = initial_clock()[0]
    error = (np.array([update_clock(clock, stamp_ns) for stamp_ns in np.round(stamp * 1e9)]) * 1e-9 - taken)[2500:]
    assert np.std((stamp - taken)[2500:]) > 0.8e-3
    assert np.std(error) < 1e-4


def test_samples_that_were_queued_in_a_silence_leave_the_period_as_it_was():
    taken = np.arange(5000) / 500
    stamp = delayed(taken)
    queued = (taken > 5.0) & (taken < 5.4)
    stamp[queued] = 5.4 + 4e-5 * np.arange(np.count_nonzero(queued))
    error = instants(stamp, taken) - taken
    assert np.abs(error[2750:]).max() < 3e-4


@pytest.mark.parametrize("seed", [5, 6, 8])
def test_late_samples_of_a_polled_sensor_keep_their_stamps(seed):
    stamp = delayed(np.arange(5000) / 500, seed)
    assert np.abs(instants(stamp, stamp) - stamp)[1500:].max() < 1e-6


def test_lost_samples_affect_their_neighbours_only():
    taken = np.arange(5000) / 500
    kept = np.random.default_rng(1).uniform(size=taken.size) > 0.02
    stamp, taken = delayed(taken)[kept], taken[kept]
    error = np.abs(instants(stamp, taken) - taken)[1500:]
    assert np.median(error) < 1e-4
    assert np.percentile(error, 95.0) < 3e-3


@pytest.mark.parametrize("seed", [5, 6, 7])
def test_losses_that_the_driver_counts_and_long_delays_affect_no_instant(seed):
    taken, rng = np.arange(5000) / 500, np.random.default_rng(seed)
    stamp, received = delayed(taken, seed, delay_rate=4.0, mean_delay=20e-3), rng.uniform(size=taken.size) > 0.01
    received[2500:2525] = False
    assert np.max(stamp - taken) > 0.06
    lost = np.diff(np.flatnonzero(received), prepend=-1) - 1
    error = instants(stamp[received], taken[received], lost=lost) - taken[received]
    assert np.abs(error[1500:]).max() < 2e-4


def test_an_overload_of_two_seconds_affects_no_instant_where_lost_samples_are_counted():
    taken = np.arange(10000) / 500
    stamp = delayed(taken)
    overload = (taken > 10.0) & (taken < 12.0)
    late = 0.02 + 0.05 * np.abs(np.random.default_rng(3).normal(size=taken.size))
    stamp = np.maximum.accumulate(np.where(overload, taken + late, stamp)) + 1e-8 * np.arange(taken.size)
    error = instants(stamp, taken, lost=np.zeros(taken.size, int)) - taken
    assert np.abs(error[3000:]).max() < 1e-2 * np.max(stamp - taken)


def test_an_overload_beyond_the_window_affects_no_instant_where_lost_samples_are_counted():
    taken = np.arange(20000) / 500
    lag = np.interp(taken, [14.0, 20.0, 22.0, 25.0, 27.0], [0.0, 2.3, 1.7, 2.6, 0.0])
    batch = np.searchsorted(np.cumsum(np.random.default_rng(3).integers(1, 40, 2000)), np.arange(taken.size))
    last = np.flatnonzero(np.diff(batch, append=-1))[np.unique(batch, return_inverse=True)[1]]
    stamp = np.where(lag > 0.0, taken[last] + lag[last] + 2e-5 * np.arange(taken.size) % 0.5e-3, delayed(taken))
    stamp = np.maximum.accumulate(stamp) + 1e-8 * np.arange(taken.size)
    corrected = instants(stamp, taken, lost=np.zeros(taken.size, int))
    assert np.abs(corrected - taken)[3000:].max() < 1e-3


@pytest.mark.parametrize("rate", [100, 500, 1000])
def test_a_lower_sample_rate_is_not_a_delay_where_lost_samples_are_counted(rate):
    taken = np.concatenate([np.arange(20 * rate) / rate, 20.0 + np.arange(5 * rate) * 2.0 / rate])
    error = instants(delayed(taken, delay_rate=4.0), taken, lost=np.zeros(taken.size, int)) - taken
    assert np.percentile(np.abs(error[23 * rate :]), 90.0) < 2e-4


def test_a_delay_of_all_samples_that_lasts_is_a_change_of_phase_where_lost_samples_are_counted():
    taken = np.arange(30000) / 500
    stamp = delayed(taken) + 0.1 * (taken > 20.0)
    error = instants(stamp, taken, lost=np.zeros(taken.size, int)) - taken
    assert np.abs(error[(taken > 10.0) & (taken < 40.0)]).max() < 1e-3
    assert np.abs(error[taken > 45.0] - 0.1).max() < 1e-3


@pytest.mark.parametrize("rate", [100, 1000])
def test_true_stamps_are_unchanged_even_or_uneven_with_or_without_losses(rate):
    rng = np.random.default_rng(4)
    even = np.arange(10 * rate) / rate
    uneven = (np.arange(10 * rate) + 0.35 * rng.uniform(-1.0, 1.0, 10 * rate)) / rate
    received = rng.uniform(size=even.size) > 0.1
    for taken in (even, even[received], uneven, uneven[received]):
        assert np.abs(instants(taken, taken) - taken).max() < 1e-6


@pytest.mark.parametrize("pause", [0.0, 3.0])
def test_a_change_of_the_sample_rate_is_not_a_delay(pause):
    taken = np.concatenate([np.arange(2000) / 500, 4.0 + pause + np.arange(4000) / 1000])
    error = instants(delayed(taken, delay_rate=4.0), taken) - taken
    assert np.percentile(np.abs(error[3500:]), 90.0) < 2e-4


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(1, 10**12), st.floats(-1.0, 1.0)), max_size=150))
def test_instants_are_strictly_increasing_and_never_after_their_stamps(samples):
    correct = partial(corrected_stamp, initial_timestamps()[0])
    stamps = np.cumsum([step for step, _ in samples]).tolist()
    corrected = [correct(stamp, value) for stamp, (_, value) in zip(stamps, samples, strict=True)]
    assert all(b > a for a, b in pairwise(corrected))
    assert all(instant <= stamp for instant, stamp in zip(corrected, stamps, strict=True))


def test_estimates_from_delayed_stamps_are_accurate_and_consistent():
    rate = 500
    recording = record(TRANSMISSION_1, SLOW, 30.0, rate=rate)
    stamp = delayed(np.arange(30 * rate) / rate, delay_rate=15.0, mean_delay=15e-3)
    recording.stamp_ns[:] = 10**18 + np.round(stamp * 1e9).astype(np.int64)
    estimates = run(Estimator(wrong_start(TRANSMISSION_1)), recording)
    assert [estimate.stamp_ns for estimate in estimates] == recording.stamp_ns.tolist()
    late = slice(15 * rate, None)
    stiffness = np.log(column(estimates, "stiffness") / recording.stiffness)[late]
    std = (np.sqrt(column(estimates, "stiffness_variance")) / column(estimates, "stiffness"))[late]
    damping = (column(estimates, "damping") / recording.damping - 1.0)[late]
    assert np.sqrt(np.mean(stiffness**2)) < 3e-3
    assert np.mean(np.abs(stiffness) < 1.96 * std) > 0.9
    assert np.sqrt(np.mean(damping**2)) < 0.02
