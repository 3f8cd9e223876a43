# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Systematic sensor errors against closed forms, for recordings and for the whole rig."""

from dataclasses import replace

import numpy as np
import pytest
from vsa_simulator.rig.config import RigConfig, SensorConfig, SensorErrorConfig, TorqueConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.motion import ProfileConfig, Tone, tones
from vsa_simulator.rig.recording import Simulation, TransmissionVariant
from vsa_simulator.rig.rig import Rig
from vsa_simulator.rig.sensor_errors import ForceErrors, oversampling

PERFECT = SensorConfig(0.0, 0.0, 200.0, 0.0, 1e-9, 0, 0.0, 0.0)
SMOOTH = replace(TransmissionVariant().transmission, coulomb_friction=0.0)
MIX = tones(0.010, Tone(0.002, 0.1), Tone(0.0004, 0.9, 0.4), Tone(0.0001, 2.3, 1.0), fade_in=1.0)


def simulation(rate_hz=100, motion=MIX, duration=10.0, **errors):
    variant = TransmissionVariant(transmission=SMOOTH, sensors=PERFECT, sensor_errors=SensorErrorConfig(**errors))
    return Simulation(variant, motion, duration, rate_hz)


def delay_of(sensed, reference, reference_dt, dt):
    """Delay [s] at which the reference, interpolated, correlates best with `sensed`."""
    time = dt * np.arange(len(sensed))
    inner = (time > 1.0) & (time < time[-1] - 1.0)
    grid = reference_dt * np.arange(len(reference))
    delays = np.arange(-0.005, 0.02, 2.5e-4)
    correlation = [np.corrcoef(sensed[inner], np.interp(time[inner] - one, grid, reference))[0, 1] for one in delays]
    best = int(np.argmax(correlation))
    a, b, _ = np.polyfit(delays[best - 2 : best + 3], correlation[best - 2 : best + 3], 2)
    return -b / (2 * a)


@pytest.mark.parametrize("rate_hz", [100, 333, 1000])
@pytest.mark.parametrize("delay", [0.002, 0.005, 0.010])
def test_the_delay_of_the_force_is_recovered_by_cross_correlation_at_any_rate(delay, rate_hz):
    exact = simulation(1000)
    late = simulation(rate_hz, force_delay=delay)
    assert delay_of(late.sensed_force, exact.force, 1e-3, 1.0 / rate_hz) == pytest.approx(delay, abs=5e-5)
    np.testing.assert_array_equal(late.sensed_deflection, late.deflection)


def test_the_low_pass_has_gain_and_phase_of_the_first_order():
    frequency, cut_off = 10.0, 20.0
    errors = SensorErrorConfig(force_lowpass=cut_off)
    time = np.arange(8000) / 4000.0
    sensed = ForceErrors(errors, 4000.0, channels=1).apply(
        np.sin(2 * np.pi * frequency * time)[:, None], np.zeros((8000, 1))
    )[4000:, 0]
    response = 2.0 * np.mean(sensed * np.exp(-2j * np.pi * frequency * time[4000:]))
    expected = -1j / (1.0 + 1j * frequency / cut_off)
    assert response == pytest.approx(expected, abs=2e-4)


def test_the_force_sensor_loop_has_the_area_of_dahls_model():
    h, span, swing = 0.1, 5.0, 10.0
    time = np.arange(40000) / 4000.0
    force = 30.0 + swing * np.sin(2 * np.pi * 0.2 * time)
    errors = ForceErrors(SensorErrorConfig(force_hysteresis=h, force_hysteresis_span=span), 4000.0, 1)
    deviation = errors.apply(force[:, None], np.zeros((40000, 1)))[:, 0] - force
    cycle = slice(20000, 40000)
    area = np.sum(0.5 * (deviation[cycle][1:] + deviation[cycle][:-1]) * np.diff(force[cycle]))
    y0 = np.tanh(swing / span)
    assert area == pytest.approx(2 * h * (2 * swing - (1 + y0) * span * (1 - np.exp(-2 * swing / span))), rel=1e-3)
    assert np.abs(deviation).max() <= h


def test_drift_and_crosstalk_are_added_to_the_force():
    run = simulation(force_drift=0.2, crosstalk=0.02)
    other = 30.0 + 10.0 * np.sin(2 * np.pi * 0.11 * run.time)
    np.testing.assert_allclose(run.sensed_force - run.force, 0.02 * other + 0.2 / 60.0 * run.time, atol=1e-12)


def test_the_encoder_error_is_periodic_in_the_deflection():
    run = simulation(encoder_cyclic=2e-5, encoder_pitch=1e-3)
    error = run.sensed_deflection - run.deflection
    np.testing.assert_allclose(error, 2e-5 * np.sin(2000.0 * np.pi * run.deflection), atol=1e-15)
    assert np.ptp(error) == pytest.approx(4e-5, rel=1e-2)


def test_without_errors_that_have_memory_no_further_rows_are_computed():
    assert oversampling(SensorErrorConfig(force_drift=1.0, crosstalk=0.1, encoder_cyclic=1e-5), 100.0) == 1
    assert oversampling(SensorErrorConfig(force_delay=1e-3), 100.0) == 40
    assert oversampling(SensorErrorConfig(force_lowpass=20.0), 10000.0) == 1


@pytest.fixture(scope="module")
def rig_config():
    return RigConfig(
        rate_hz=500,
        sensors=PERFECT,
        profile=ProfileConfig(amplitudes=(0.002, 0.0003), frequencies=(0.3, 1.9), phases=(0.0, 1.0), fade_in=0.5),
        torque=TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,)),
    )


def test_in_the_rig_blocks_of_any_size_give_the_same_readings(rig_config):
    errors = SensorErrorConfig(0.0047, 30.0, 0.1, 5.0, 0.2, 0.02, 5e-6)
    whole = Rig(replace(rig_config, sensor_errors=errors)).advance(60)
    split = Rig(replace(rig_config, sensor_errors=errors))
    blocks = [split.advance(n) for n in (1, 9, 50)]
    np.testing.assert_array_equal(np.concatenate([b.truth for b in blocks]), whole.truth)
    np.testing.assert_array_equal(np.concatenate([b.readings.forces for b in blocks]), whole.readings.forces)
    np.testing.assert_array_equal(np.concatenate([b.readings.counts for b in blocks]), whole.readings.counts)


def test_in_the_rig_both_forces_are_late_and_the_truth_is_not(rig_config):
    exact = Rig(rig_config).advance(3000)
    late = Rig(replace(rig_config, sensor_errors=SensorErrorConfig(force_delay=0.005))).advance(3000)
    np.testing.assert_allclose(late.truth, exact.truth, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(late.truth[:, 0], np.arange(3000) / 500.0, atol=1e-12)
    for side in (0, 1):
        true = exact.truth[:, TRUTH.index(f"force_{side + 1}")]
        assert delay_of(late.readings.forces[:, side], true, 2e-3, 2e-3) == pytest.approx(0.005, abs=1e-4)


def test_in_the_rig_each_force_has_a_share_of_the_other(rig_config):
    samples = Rig(replace(rig_config, sensor_errors=SensorErrorConfig(crosstalk=0.02))).advance(100)
    one, two = (samples.truth[:, TRUTH.index(f"force_{side}")] for side in (1, 2))
    np.testing.assert_allclose(samples.readings.forces, np.column_stack([one + 0.02 * two, two + 0.02 * one]))
