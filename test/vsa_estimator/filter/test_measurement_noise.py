# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Noise of a sensor and jerk density of its motion, estimated from its samples."""

import numpy as np
import pytest
from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.tuning.filter import PSD_SCALE


def level(values, configured=0.017, count=1):
    noise = NoiseLevel(configured, 0.0, 900)
    for value in values:
        noise.add(float(value), count)
    return noise.refresh()


@pytest.mark.parametrize("configured", [0.006, 0.017, 0.05])
def test_white_noise_is_estimated_for_any_configured_noise(configured):
    t = np.arange(900) / 100.0
    motion = 30.0 * np.sin(2.0 * np.pi * 0.2 * t)
    rng = np.random.default_rng(1)
    assert level(motion + 0.017 * rng.standard_normal(t.size), configured) == pytest.approx(0.017, rel=0.1)


def test_the_noise_of_one_sample_is_estimated_from_means_of_ten():
    rng = np.random.default_rng(2)
    means = 0.017 * rng.standard_normal((900, 10)).mean(axis=1)
    assert level(means, count=10) == pytest.approx(0.017, rel=0.1)


def test_the_estimate_is_robust_to_single_outliers():
    rng = np.random.default_rng(3)
    values = 0.017 * rng.standard_normal(900)
    values[::100] += 10.0
    assert level(values) == pytest.approx(0.017, rel=0.35)


def test_the_estimate_stays_within_a_quarter_and_four_times_of_the_configured_noise():
    assert level(np.zeros(900)) == pytest.approx(0.017 / 4.0)
    assert level(np.random.default_rng(4).standard_normal(900)) == pytest.approx(0.017 * 4.0)


def test_friction_at_fast_reversals_raises_the_estimate_by_less_than_40_percent():
    rng = np.random.default_rng(1)
    time, omega = 0.01 * np.arange(3000), 2.0 * np.pi * np.array([0.05, 0.7, 1.7])
    speed = np.cos(time[:, None] * omega + np.array([0.0, 1.3, 2.6])) @ (omega * np.array([4e-3, 1.6e-4, 8e-5]))
    noise = NoiseLevel(0.01, 0.0, 3000)
    for force in 0.5 * np.tanh(speed / 5e-5) + 0.0054 * rng.standard_normal(time.size):
        noise.add(force)
    assert 0.0054 < noise.refresh() < 1.4 * 0.0054


def test_the_least_noise_of_a_minute_excludes_a_rough_motion():
    rng, noise = np.random.default_rng(6), NoiseLevel(0.017, 0.0, 900)
    for k in range(3000):
        rough = 0.2 * rng.standard_normal() if k > 2000 else 0.0
        noise.add(0.017 * rng.standard_normal() + rough)
        if k % 50 == 49:
            noise.refresh()
    assert noise.std == pytest.approx(4.0 * 0.017)
    assert noise.least_std == pytest.approx(0.017, rel=0.1)


def bank_on_white_jerk(density):
    rng = np.random.default_rng(5)
    dt = 0.01
    x = v = a = 0.0
    jerk = JerkDensity()
    for k in range(2000):
        step = np.sqrt(density * dt) * rng.standard_normal()
        x, v, a = x + dt * v + dt * dt / 2.0 * a, v + dt * a, a + step
        jerk.add(x + 1e-5 * rng.standard_normal(), 1e-10, dt)
        if k % 50 == 49:
            jerk.refresh()
    return jerk


def test_the_jerk_density_of_simulated_white_jerk_is_estimated_within_a_factor_of_two():
    jerk = bank_on_white_jerk(1e-3)
    assert 5e-4 < jerk.ml_estimate < 2e-3
    assert jerk.density == PSD_SCALE * jerk.ml_estimate


def test_jerk_densities_between_two_candidates_of_the_bank_are_resolved():
    estimates = [bank_on_white_jerk(density).ml_estimate for density in (1e-3, 1.5e-3, 2.2e-3)]
    assert np.all(np.diff(estimates) > 0.0)
    assert estimates[2] / estimates[0] == pytest.approx(2.2, rel=0.25)


def test_the_density_of_a_manoeuvre_lasts_as_long_as_the_motion_is_fast():
    jerk, t, densities = JerkDensity(), 0.01 * np.arange(1500), []
    fast = (t > 10.0) & (t < 10.8)
    motion = 1e-3 * np.sin(2.0 * np.pi * 0.05 * t) + np.where(fast, 1e-3 * np.sin(2.0 * np.pi * 5.0 * (t - 10.0)), 0.0)
    for k, deflection in enumerate(motion + 1e-5 * np.random.default_rng(7).standard_normal(t.size)):
        jerk.add(deflection, 1e-10, 0.01)
        if k in (1002, 1003):  # two large NIS of the filter
            detected = jerk.detect_manoeuvre(1e3)
        if k % 50 == 49:
            densities.append(jerk.refresh())
    assert detected
    assert densities[20] > 100.0 * densities[19]  # the window of the motion
    assert densities[23] < 0.1 * densities[20]


def test_a_faster_motion_has_a_higher_jerk_density():
    def density(frequency):
        jerk = JerkDensity()
        for k in range(600):
            jerk.add(1e-3 * np.sin(2.0 * np.pi * frequency * k * 0.01), 1e-10, 0.01)
            if k % 50 == 49:
                jerk.refresh()
        return jerk.density

    slow, fast = density(0.05), density(2.0)
    assert slow < fast / 100.0
