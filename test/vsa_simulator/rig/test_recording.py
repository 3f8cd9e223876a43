# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings of one transmission: noise, seeds, stamps, masses."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.dampers import DamperConfig
from vsa_simulator.laws.friction import FrictionConfig
from vsa_simulator.laws.internal import HysteresisConfig, ViscoelasticConfig
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig.config import SensorConfig, SensorErrorConfig, TransmissionConfig
from vsa_simulator.rig.motion import Tone, tones
from vsa_simulator.rig.recording import Simulation, TransmissionVariant

MOTION = tones(0.010, Tone(0.0008, 1.3), Tone(0.0001, 6.0, 1.0), fade_in=0.4)


def test_recordings_differ_by_seed_in_their_noise_alone():
    simulation = Simulation(TransmissionVariant(), MOTION, 20.0, 100)
    one, same, other = (simulation.recording(seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.force, same.force)
    assert not np.array_equal(one.force, other.force)
    assert (one.force - simulation.force).std() == pytest.approx(0.017, rel=0.05)
    assert (one.deflection - simulation.deflection).std() == pytest.approx(np.hypot(1e-5, 1e-5 / 12**0.5), rel=0.05)
    np.testing.assert_allclose(np.rint(one.deflection / 1e-5) * 1e-5, one.deflection, atol=1e-12)
    np.testing.assert_array_equal(one.stamp_ns - one.stamp_ns[0], np.arange(2000) * 10_000_000)


def test_the_force_saturates_at_the_range_of_its_sensor():
    variant = TransmissionVariant(sensors=SensorConfig(force_range=25.0))
    assert Simulation(variant, MOTION, 2.0, 100).recording(1).force.max() == 25.0


def test_stamps_jitter_about_the_true_times_and_ascend():
    variant = TransmissionVariant(stamp_jitter=1e-3)
    simulation = Simulation(variant, MOTION, 20.0, 1000)
    stamps = simulation.recording(3).stamp_ns
    assert np.diff(stamps).min() >= 0
    slow = Simulation(variant, MOTION, 20.0, 100).recording(3).stamp_ns
    assert np.std(slow - slow[0] - np.arange(2000) * 1e7) == pytest.approx(1e6, rel=0.05)
    plain = Simulation(TransmissionVariant(), MOTION, 20.0, 100).recording(3)
    late = TransmissionVariant(sensor_errors=SensorErrorConfig(frame_jitter=4e-3))
    delay = (Simulation(late, MOTION, 20.0, 100).recording(3).stamp_ns - plain.stamp_ns) * 1e-9
    assert 0.0 <= delay.min() < delay.max() <= 4e-3
    assert delay.std() == pytest.approx(4e-3 / 12**0.5, rel=0.05)
    np.testing.assert_array_equal(Simulation(variant, MOTION, 20.0, 100).recording(3).force, plain.force)


@pytest.mark.parametrize("mass", [0.1, 0.3755, 10.0])
def test_all_terms_together_equal_an_independent_integration_for_a_rod_of_any_mass_in_scope(mass):
    laws = ForceLaws(
        SpringConfig("cubic", drift=60.0),
        DamperConfig("quadratic"),
        FrictionConfig("stribeck"),
        ViscoelasticConfig(0.3, 0.2),
        HysteresisConfig(0.6, 4e-4, 0.3),
    )
    simulation = Simulation(TransmissionVariant(replace(TransmissionConfig(), inertia=mass), laws), MOTION, 0.9, 1000)
    rise, peak = 0.776 * np.expm1(267.2 * 0.02), np.sqrt(4000.0 / (3 * 1.089e8))
    force0 = 0.776 + rise * (0.04 + 0.92 * 0.125)

    def rhs(t, state):
        x, v, q, y = state
        part = min(t / 0.4, 1.0)
        envelope = part * part * (3 - 2 * part)
        wave = envelope * (8e-4 * np.sin(2 * np.pi * 1.3 * t) + 1e-4 * np.sin(12 * np.pi * t + 1.0))
        tension = max(0.0, 1e5 * (2 * (0.010 + wave) + (16.39 + force0) / 2e5 - 2 * x))
        u, scale = x / 0.02, 1.0 + 0.01 * t
        spring = 16.39 + scale * (0.776 + rise * (0.08 * u + 0.92 * u**3))
        sigma = scale * rise / 0.02 * (0.08 + 2.76 * u**2)
        damper = 1000.0 * v + (2 / 3 - 0.25) * 4000.0 * v * abs(v) / peak
        friction = 0.3 * (1 + np.exp(-((v / 3e-4) ** 2))) * np.tanh(v / 5e-5)
        a = (2 * tension - spring - damper - friction - q - 0.6 * y) / mass
        return [v, a, 0.3 * sigma * v - q / 0.2, (v - 0.3 * abs(y) * v - 0.7 * abs(v) * y) / 4e-4]

    start = [0.010, 0.0, 0.0, 0.0]
    solution = solve_ivp(rhs, (0.0, 0.9), start, "LSODA", simulation.time, rtol=1e-10, atol=1e-13, max_step=2e-3)
    np.testing.assert_allclose(simulation.deflection, solution.y[0], rtol=1e-6)
    np.testing.assert_allclose(simulation.velocity, solution.y[1], atol=2e-6 * np.abs(solution.y[1]).max())
