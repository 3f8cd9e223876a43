# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Simulated recordings with their truth; the only module of the bench that imports the rig."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from vsa_bench.estimation.cases import Case, Coefficients
from vsa_common.types import Array
from vsa_simulator.rig import single_transmission
from vsa_simulator.rig.config import TransmissionConfig

RESOLUTION = 1e-5  # step of the encoder [m]


@dataclass(frozen=True)
class Truth:
    """True motion and force at each sample, SI."""

    coefficients: Coefficients
    time: Array
    deflection: Array
    velocity: Array
    acceleration: Array
    force: Array

    @property
    def stiffness(self) -> Array:
        """Eq. (3) [N/m]."""
        c = self.coefficients
        return c.k1 * c.k2 * np.exp(c.k2 * self.deflection)

    @property
    def damping(self) -> Array:
        """D = d1 + 3 d2 v^2 [N s/m], zero beyond the peak speed of the damper."""
        c = self.coefficients
        return np.where(np.abs(self.velocity) < c.maximum_speed, c.d1 + 3.0 * c.d2 * self.velocity**2, 0.0)


@dataclass(frozen=True)
class Recording:
    """Sensor samples of one truth, one row a seed."""

    truth: Truth
    rate: float  # [Hz]
    force: Array  # (seeds, samples) [N]
    deflection: Array  # (seeds, samples) [m]
    force_noise: float  # standard deviation [N]
    deflection_noise: float  # standard deviation, without the resolution [m]

    @property
    def stamps_ns(self) -> NDArray[np.int64]:
        """Capture stamps [ns]."""
        return np.round((1.0 + self.truth.time) * 1e9).astype(np.int64)

    def noise_parameters(self) -> dict[str, float]:
        """The estimator's parameters of the sensor noise."""
        return {
            "force_noise_std": self.force_noise,
            "deflection_noise_std": self.deflection_noise,
            "deflection_resolution": RESOLUTION,
        }


def record(case: Case, seeds: list[int], seconds: float = 60.0) -> Recording:
    """Simulate `case`: white noise on both sensors, quantisation on deflection."""
    truth = simulate(case.coefficients, case.motion, case.rate_hz, seconds)
    noise = case.deflection_noise_mm * 1e-3
    force, deflection = [], []
    for seed in seeds:
        random = np.random.default_rng(seed)
        force.append(truth.force + case.force_noise_n * random.standard_normal(len(truth.time)))
        raw = truth.deflection + noise * random.standard_normal(len(truth.time))
        deflection.append(np.round(raw / RESOLUTION) * RESOLUTION)
    return Recording(truth, float(case.rate_hz), np.array(force), np.array(deflection), case.force_noise_n, noise)


@lru_cache(maxsize=8)
def simulate(coefficients: Coefficients, motion: str, rate: int, seconds: float) -> Truth:
    """Truth of one transmission whose tendon is moved at its far end."""
    c = coefficients
    transmission = TransmissionConfig(
        c.force_offset, c.k1, c.k2, c.d1, c.d2, coulomb_friction=c.coulomb_friction, inertia=c.inertia
    )
    columns = single_transmission.simulate(transmission, single_transmission.MOTIONS[motion], seconds, rate)
    named = dict(zip(single_transmission.COLUMNS, columns.T.copy(), strict=True))
    return Truth(c, *(named[name] for name in ("time", "deflection", "velocity", "acceleration", "force")))
