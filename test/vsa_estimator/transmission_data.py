# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Samples of a transmission on a prescribed motion: eqs. (2) to (6) evaluated in closed form, nothing integrated."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_common.config.configuration import build
from vsa_common.types import Array
from vsa_estimator.estimator import Estimator
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.settings import EstimatorConfig


@dataclass(frozen=True)
class Rig:
    """Coefficients of one transmission, SI."""

    k1: float = 0.776
    k2: float = 267.2
    d1: float = 4000.0
    d2: float = -1.089e8
    mass: float = 0.3755
    force_offset: float = 16.39
    coulomb_friction: float = 0.3


TRANSMISSION_1 = Rig()
ANOTHER = Rig(k1=2.0, k2=220.0, d1=2500.0, d2=-5e7, mass=0.3755, force_offset=12.0, coulomb_friction=0.5)
SLOW = (0.010, ((7.5e-3, 0.05),))
MULTISINE = (0.0105, ((4e-3, 0.05), (1.6e-4, 0.7), (8e-5, 1.7)))


@dataclass(frozen=True)
class Recording:
    """Sensor samples and the truth behind them."""

    stamp_ns: NDArray[np.int64]
    force: Array
    deflection: Array
    stiffness: Array
    damping: Array


def record(rig: Rig, motion, seconds=20.0, rate=100, seed=1, stamps=None) -> Recording:
    """Noise of section VI: 0.017 N and 0.01 mm, encoder steps of 0.01 mm."""
    t = np.arange(int(seconds * rate)) / rate if stamps is None else stamps
    centre, tones = motion
    x, v, a = np.full_like(t, centre), np.zeros_like(t), np.zeros_like(t)
    for index, (amplitude, frequency) in enumerate(tones):
        w = 2.0 * np.pi * frequency
        phase = w * t + 1.3 * index
        x += amplitude * np.sin(phase)
        v += amplitude * w * np.cos(phase)
        a -= amplitude * w * w * np.sin(phase)
    return measure(rig, t, x, v, a, seed)


def measure(rig: Rig, t: Array, x: Array, v: Array, a: Array, seed=1) -> Recording:
    """Sensor samples of a motion, as `record` makes them."""
    w = np.sqrt(rig.d1 / (-3.0 * rig.d2))
    c = np.clip(v, -w, w)
    spring = rig.k1 * np.exp(rig.k2 * x)
    damper = rig.coulomb_friction * np.tanh(v / 5e-5) + rig.d1 * c + rig.d2 * c**3
    rng = np.random.default_rng(seed)
    force = rig.force_offset + spring + damper + rig.mass * a + 0.017 * rng.standard_normal(t.size)
    deflection = np.round((x + 1e-5 * rng.standard_normal(t.size)) / 1e-5) * 1e-5
    stamp_ns = 1_000_000_000 + np.round(t * 1e9).astype(np.int64)
    return Recording(stamp_ns, force, deflection, rig.k2 * spring, rig.d1 + 3.0 * rig.d2 * c**2)


def wrong_start(rig: Rig, k2_factor=0.7, **more) -> EstimatorConfig:
    """k2 30 % off, d1 0.6x, d2 half, mass double; standard deviations as large as the errors and larger."""
    values = {
        "initial.k2": k2_factor * rig.k2, "initial.k2_std": 0.35 * rig.k2,
        "initial.d1": 0.6 * rig.d1, "initial.d1_std": 0.6 * rig.d1,
        "initial.d2": 0.5 * rig.d2, "initial.d2_std": -0.6 * rig.d2,
        "initial.inertia": 2.0 * rig.mass, "initial.inertia_std": 2.0 * rig.mass,
        "initial.force_offset": rig.force_offset + 2.0, "initial.force_offset_std": 5.0,
    }  # fmt: skip
    return build(EstimatorConfig, values | more)


def run(estimator: Estimator, recording: Recording) -> list[Estimate]:
    """All samples through the estimator; none may be dropped."""
    samples = zip(recording.stamp_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    estimates = [estimator.add(*sample) for sample in samples]
    assert None not in estimates
    return estimates  # type: ignore[return-value]


def column(estimates: list[Estimate], name: str) -> Array:
    """One field of all estimates."""
    return np.array([getattr(estimate, name) for estimate in estimates], float)
