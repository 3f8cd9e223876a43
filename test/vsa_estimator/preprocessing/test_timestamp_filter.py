"""When samples were taken, from stamps that are late, uneven, or not all there."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from transmission_data import MULTISINE, SLOW, TRANSMISSION_1, column, record, run, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.preprocessing.timestamp_filter import STAMPS, instant, no_instant, no_pace, pace


def held_up(taken, seed=5, often=8.0, long=8e-3):
    """Stamps [s] of a sender that is kept from its work `often` times a second, and then catches up."""
    rng = np.random.default_rng(seed)
    stamp = taken + np.abs(rng.normal(0.0, 1e-4, taken.size))
    for begin in np.sort(rng.uniform(taken[0], taken[-1], rng.poisson(often * np.ptp(taken)))):
        end = begin + rng.exponential(long)
        waiting = (taken >= begin) & (taken < end)
        stamp[waiting] = np.maximum(stamp[waiting], end + 5e-5 * np.arange(np.count_nonzero(waiting)))
    for index in range(1, stamp.size):
        stamp[index] = max(stamp[index], stamp[index - 1] + 2e-5)
    return stamp


def starved(taken, seed=5):
    """Stamps [s] of a sender that often needs most of a period for each sample, and so catches up slowly."""
    rng = np.random.default_rng(seed)
    period, busy, free = taken[1] - taken[0], 1.0, 0.0
    stamp = np.empty_like(taken)
    for index, when in enumerate(taken):
        if rng.uniform() < 0.01:
            busy = rng.choice([0.2, 0.3, 0.5, 0.8])
        free = max(free, when) + 1e-4 + 0.7 * busy * period * rng.exponential()
        stamp[index] = free
    return stamp


def instants(stamp, taken, motion=SLOW):
    """What the clock makes of the stamps [s] of samples of a motion."""
    recording = record(TRANSMISSION_1, motion, stamps=taken)
    clock = partial(instant, no_instant(), np.zeros(STAMPS, dtype=np.int64))
    stamp_ns = 10**18 + np.round(stamp * 1e9).astype(np.int64)
    found = [clock(*sample) for sample in zip(stamp_ns.tolist(), recording.deflection.tolist(), strict=True)]
    return (np.array(found) - 10**18) * 1e-9


@pytest.mark.parametrize("rate", [500, 1000])
@pytest.mark.parametrize("motion", [SLOW, MULTISINE], ids=["slow", "multisine"])
def test_behind_late_stamps_the_sensor_s_own_pace_is_found(rate, motion):
    taken = np.arange(10 * rate) / rate
    stamp = held_up(taken)
    off = (instants(stamp, taken, motion) - taken)[3 * rate :]
    assert np.std((stamp - taken)[3 * rate :]) > 1.5e-3
    assert np.std(off) < 1e-4


@pytest.mark.parametrize("seed", [5, 6, 7])
def test_the_pace_is_found_behind_a_sender_that_catches_up_slowly(seed):
    taken = np.arange(10000) / 500
    stamp = starved(taken, seed)
    memory = no_pace()
    off = (np.array([pace(memory, stamp_ns) for stamp_ns in np.round(stamp * 1e9)]) * 1e-9 - taken)[2500:]
    assert np.std((stamp - taken)[2500:]) > 0.8e-3
    assert np.std(off) < 1e-4


def test_samples_that_were_lost_meanwhile_cost_their_neighbours_only():
    taken = np.arange(5000) / 500
    kept = np.random.default_rng(1).uniform(size=taken.size) > 0.02
    stamp, taken = held_up(taken)[kept], taken[kept]
    off = np.abs(instants(stamp, taken) - taken)[1500:]
    assert np.median(off) < 1e-4
    assert np.percentile(off, 95.0) < 3e-3


@pytest.mark.parametrize("rate", [100, 1000])
def test_stamps_that_are_true_are_left_alone_even_or_uneven_with_all_samples_or_not(rate):
    rng = np.random.default_rng(4)
    even = np.arange(10 * rate) / rate
    uneven = (np.arange(10 * rate) + 0.35 * rng.uniform(-1.0, 1.0, 10 * rate)) / rate
    some = rng.uniform(size=even.size) > 0.1
    for taken in (even, even[some], uneven, uneven[some]):
        assert np.abs(instants(taken, taken) - taken).max() < 1e-6


@pytest.mark.parametrize("pause", [0.0, 3.0])
def test_another_pace_is_no_lateness(pause):
    taken = np.concatenate([np.arange(2000) / 500, 4.0 + pause + np.arange(4000) / 1000])
    off = instants(held_up(taken, often=4.0), taken) - taken
    assert np.percentile(np.abs(off[3500:]), 90.0) < 2e-4


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(1, 10**12), st.floats(-1.0, 1.0)), max_size=150))
def test_instants_increase_with_any_stamps_and_are_never_after_them(samples):
    clock = partial(instant, no_instant(), np.zeros(STAMPS, dtype=np.int64))
    stamps = np.cumsum([step for step, _ in samples]).tolist()
    found = [clock(stamp, value) for stamp, (_, value) in zip(stamps, samples, strict=True)]
    assert all(b > a for a, b in pairwise(found))
    assert all(instant <= stamp for instant, stamp in zip(found, stamps, strict=True))


def test_an_estimate_from_late_stamps_is_nearly_as_good_and_as_honest_as_from_true_ones():
    rate = 500
    recording = record(TRANSMISSION_1, SLOW, 30.0, rate=rate)
    stamp = held_up(np.arange(30 * rate) / rate, often=15.0, long=15e-3)
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
