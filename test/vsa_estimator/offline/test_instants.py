# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings with delayed stamps: noise and coefficients as from even ones, and a line on how uneven they were."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from transmission_data import SLOW, TRANSMISSION_1, record
from vsa_estimator.offline.identification import identify
from vsa_estimator.offline.instants import corrected
from vsa_estimator.offline.noise import analyse
from vsa_estimator.offline.recordings import Recording, RecordingError

RATE = 500.0
START_NS = 1_700_000_000_000_000_000


def delayed(count, seed=5):
    """Instants and stamps [s] of a host that is interrupted eight times a second for 8 ms, and then catches up."""
    rng = np.random.default_rng(seed)
    taken = np.arange(count) / RATE
    stamp = taken + np.abs(rng.normal(0.0, 1e-4, count))
    for begin in np.sort(rng.uniform(0.0, taken[-1], int(8 * taken[-1]))):
        end = begin + rng.exponential(8e-3)
        waiting = (taken >= begin) & (taken < end)
        stamp[waiting] = np.maximum(stamp[waiting], end + 5e-5 * np.arange(np.count_nonzero(waiting)))
    for index in range(1, count):
        stamp[index] = max(stamp[index], stamp[index - 1] + 2e-5)
    return taken, stamp


def recording(stamp, force, deflection):
    stamp_ns = START_NS + np.round(stamp * 1e9).astype(np.int64)
    return Recording(Path("bag"), "transmission_1", stamp_ns, stamp_ns / 1e9, force, deflection)


@pytest.fixture(scope="module")
def moving():
    """A motion recorded with delayed stamps, and the instants [s]."""
    taken, stamp = delayed(20_000)
    data = record(TRANSMISSION_1, SLOW, stamps=taken)
    return recording(stamp, data.force, data.deflection), taken


def test_the_instants_are_those_of_the_sensor_and_the_timing_states_the_jitter(moving):
    raw, taken = moving
    better, timing = corrected(raw)
    late = raw.stamp_ns - START_NS - taken * 1e9
    error = better.stamp_ns - START_NS - taken * 1e9
    assert np.std(error[1500:]) < 0.1 * np.std(late[1500:])
    assert timing.period == pytest.approx(1.0 / RATE, rel=1e-3)
    assert timing.jitter == pytest.approx(np.diff(raw.stamp_ns).std() * 1e-9, rel=1e-6)
    assert timing.delay > 5e-3
    assert "standard deviation" in str(timing)


def test_coefficients_of_a_recording_with_delayed_stamps_are_right_only_with_the_correction(moving):
    raw, _ = moving
    before, after = identify([raw]), identify([corrected(raw)[0]])
    assert after.residual.std() < 0.3 * before.residual.std()
    assert abs(after.value("k2") - TRANSMISSION_1.k2) < min(4.0 * after.std("k2"), 0.01 * TRANSMISSION_1.k2)


def test_noise_is_measured_from_delayed_stamps_as_from_even_ones():
    taken, stamp = delayed(20_000)
    rng = np.random.default_rng(1)
    force, deflection = 30.0 + 0.017 * rng.standard_normal(taken.size), 0.01 + 1e-5 * rng.standard_normal(taken.size)
    found, timing = analyse(recording(stamp, force, deflection))
    even, _ = analyse(recording(taken, force, deflection))
    assert found["force"].std == pytest.approx(even["force"].std, rel=1e-3)
    assert found["force"].white
    assert found["deflection"].std == pytest.approx(1e-5, rel=0.03)
    assert timing.jitter > 0.5e-3


def test_even_stamps_are_unchanged_and_unusable_samples_are_left_out():
    data = record(TRANSMISSION_1, SLOW, 10.0)
    even = Recording(Path("a"), "transmission_1", data.stamp_ns, data.stamp_ns / 1e9, data.force, data.deflection)
    better, timing = corrected(even)
    assert better.stamp_ns.tolist() == data.stamp_ns.tolist()
    assert str(timing) == "stamps 10 ms apart, even"
    stamp_ns, force = data.stamp_ns.copy(), data.force.copy()
    stamp_ns[50], force[70] = stamp_ns[40], np.nan
    found, timing = corrected(dataclasses.replace(even, stamp_ns=stamp_ns, force=force))
    assert len(found) == len(even) - 2
    assert timing.missing == 2
    with pytest.raises(RecordingError, match="found 1"):
        corrected(dataclasses.replace(even, force=np.where(np.arange(len(even)) == 3, 1.0, np.nan)))
