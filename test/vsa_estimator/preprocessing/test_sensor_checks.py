# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stuck-at, run-length, variance-ratio and timestamp-burst tests of raw samples."""

import numpy as np
import pytest
from vsa_estimator.preprocessing.pipeline import Pipeline, preprocess
from vsa_estimator.preprocessing.sensor_checks import check_burst, initial_checks, update_noise
from vsa_estimator.preprocessing.sensor_flags import SensorFlag
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.preprocessing import SLEW_MEMORY

STD, HIGH_SLEW = 0.017, 10.0  # N, standard deviations a sample
VIBRATION = 0.25  # N
MS = 1_000_000


def noise_ratios(force, beyond_peak_speed=False):
    noise, slew = initial_checks()[0]["force_noise"], (HIGH_SLEW * STD, 0.002 / SLEW_MEMORY)
    return [update_noise(noise, float(value), STD, slew, beyond_peak_speed) for value in force]


def vibration(count, slope=0.0):
    """Sampled near its Nyquist frequency: nearly from peak to peak in each sample."""
    k = np.arange(count)
    return slope * k + VIBRATION * np.cos(2.6 * k)


def flags_of(force, deflection, period_ns=2 * MS):
    """Flags of each sample."""
    state = Pipeline(EstimatorConfig()).state
    samples = zip(np.asarray(force, float).tolist(), np.asarray(deflection, float).tolist(), strict=True)
    return [preprocess(state, 10**12 + k * period_ns, *sample)[1] for k, sample in enumerate(samples)]


def test_vibration_beyond_the_peak_speed_is_tolerated_and_below_it_is_noise():
    measured = 1.3 / VIBRATION * vibration(400)
    assert max(noise_ratios(measured, beyond_peak_speed=True)) == 1.0
    assert max(noise_ratios(measured)) > 3.0
    assert max(noise_ratios(vibration(400))) > 3.0


def test_residual_vibration_after_a_motion_of_high_slew_rate_is_tolerated_until_it_has_decayed():
    swept = np.concatenate([0.3 * np.arange(100), 30.0 + vibration(250)])
    assert max(noise_ratios(swept)) == 1.0
    long_after = np.concatenate([swept, 30.0 + vibration(600)])
    assert max(noise_ratios(long_after)) > 3.0


@pytest.mark.parametrize("rate_hz", [100, 500, 1000])
def test_a_noisy_force_after_a_fast_motion_is_detected_in_the_same_time_at_any_rate(rate_hz):
    t = np.arange(5 * rate_hz) / rate_hz
    noise = np.random.default_rng(1).normal(0.0, 1.0, t.size)
    force = 30.0 + 100.0 * np.clip(t, 0.0, 0.1) + np.where(t < 0.2, 1.0, 10.0) * STD * noise
    noisy = np.array(flags_of(force, 0.01 + 1e-5 * noise, 1000 * MS // rate_hz)) & SensorFlag.FORCE_NOISY > 0
    assert not noisy[t < 0.2].any()
    assert 0.2 < t[noisy.argmax()] < 2.5


@pytest.mark.parametrize("rate_hz", [100, 500, 1000])
def test_a_noisy_encoder_after_a_fast_motion_is_detected_within_25_samples(rate_hz):
    t = np.arange(5 * rate_hz) / rate_hz
    deflection = 0.01 + 0.030 * np.clip(t, 0.0, 0.1)  # 30 mm/s, then a rest
    noise = np.random.default_rng(1).normal(0.0, 1.0, t.size)
    deflection += np.where(t < 0.2, 1e-5, 1e-4) * noise
    noisy = np.array(flags_of(30.0 + 1e-9 * t, deflection, 1000 * MS // rate_hz)) & SensorFlag.ENCODER_NOISY > 0
    assert not noisy[t < 0.2].any()
    assert 0.2 < t[noisy.argmax()] < 0.2 + 25 / rate_hz


def test_a_sensor_is_noisy_from_several_times_the_configured_noise_on():
    noise = np.random.default_rng(1).normal(0.0, STD, 400_000)  # 13 min at 500 Hz
    assert max(noise_ratios(1.5 * noise)) == 1.0
    assert max(noise_ratios(4.0 * noise[:1000])) > 1.0


@pytest.mark.parametrize("beyond_peak_speed", [False, True])
def test_noise_far_above_any_residual_vibration_is_detected(beyond_peak_speed):
    noise = np.random.default_rng(1).normal(0.0, 500.0 * STD, 400)
    assert max(noise_ratios(noise, beyond_peak_speed)) > 1.0


def test_a_constant_force_during_motion_is_stuck():
    moving = 0.005 * np.sin(0.02 * np.arange(400))
    force = np.where(np.arange(400) < 100, 30.0 + 0.1 * np.arange(400), 40.0)
    flags = flags_of(force, moving)
    assert not any(flag & SensorFlag.FORCE_STUCK for flag in flags[:200])
    assert flags[-1] & SensorFlag.FORCE_STUCK
    assert flags[-1] & SensorFlag.FORCE_REPEATED


def test_a_constant_encoder_during_a_change_of_force_is_stuck_and_a_fault():
    flags = flags_of(30.0 + 0.05 * np.arange(400), np.full(400, 0.01))
    assert flags[-1] & SensorFlag.ENCODER_STUCK
    assert flags[-1] & SensorFlag.ENCODER_FAULT
    assert not flags[50] & SensorFlag.ENCODER_CONSTANT


def test_an_encoder_whose_dither_ceases_is_frozen():
    rng = np.random.default_rng(2)
    deflection = 0.01 + 1e-5 * rng.integers(0, 2, 800)
    deflection[600:] = 0.01
    flags = flags_of(30.0 + rng.normal(0.0, STD, 800), deflection)
    assert not any(flag & SensorFlag.ENCODER_FROZEN for flag in flags[:600])
    assert flags[700] & SensorFlag.ENCODER_FROZEN


def test_a_short_burst_makes_the_timing_suspect_once_and_a_long_one_is_a_fault():
    burst, found = initial_checks()[0]["burst"], []
    for stamp_ns in [*range(MS, 200 * MS, MS), *(199 * MS + 10_000 * k for k in range(1, 80))]:
        found.append(check_burst(burst, stamp_ns))
    assert not any(found[:199])
    assert found.count(SensorFlag.TIMING_SUSPECT) == 1
    assert found[-1] == SensorFlag.BURST


def test_values_at_the_limits_are_saturated():
    config = EstimatorConfig()
    flags = flags_of([config.force_limit, 30.0], [0.01, -config.deflection_limit])
    assert flags[0] == SensorFlag.FORCE_SATURATED
    assert flags[1] == SensorFlag.DEFLECTION_SATURATED | SensorFlag.ENCODER_FAULT


def test_flags_are_distinct_bits():
    values = [flag.value for flag in SensorFlag]
    assert sum(values) == np.bitwise_or.reduce(values) == 2 ** len(values) - 1
