"""Simulated recordings with their truth: the one place where the bench meets the rig."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vsa_bringup.estimation_bench.cases import MOTIONS, Case, Coefficients, Motion

Array = NDArray[np.float64]

RESOLUTION = 1e-5  # step of the encoder [m]
RAMP = 8.0  # a motion grows to its full amplitude within this time [s]
MOVE, REST = 4.0, 11.0  # of the dwells [s]
COULOMB_SPEED = 0.05e-3  # the rig's friction has risen to 76 % at this speed [m/s]


@dataclass(frozen=True)
class Truth:
    """What really happened, sample by sample, SI."""

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
        """D = d1 + 3 d2 v^2 [N s/m], zero beyond the damper's greatest force."""
        c = self.coefficients
        return np.where(np.abs(self.velocity) < c.maximum_speed, c.d1 + 3.0 * c.d2 * self.velocity**2, 0.0)


@dataclass(frozen=True)
class Recording:
    """What the sensors said about one truth, one row a seed."""

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


def record(case: Case, seeds: list[int], seconds: float = 60.0) -> Recording:
    """The sensors' view of `case`: white noise on both, the encoder's steps on deflection."""
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
    """Truth of one transmission that is moved exactly as wanted; the force follows from eq. (6)."""
    time = np.arange(int(seconds * rate)) / rate
    h = 1e-3
    before, x, after = (wanted(MOTIONS[motion], time + shift) for shift in (-h, 0.0, h))
    v = (after - before) / (2.0 * h)
    a = (after - 2.0 * x + before) / (h * h)
    c = coefficients
    held = np.clip(v, -c.maximum_speed, c.maximum_speed)
    damper = c.coulomb_friction * np.tanh(v / COULOMB_SPEED) + c.d1 * held + c.d2 * held**3
    return Truth(c, time, x, v, a, c.inertia * a + damper + c.force_offset + c.k1 * np.exp(c.k2 * x))


def wanted(motion: Motion, time: Array) -> Array:
    """Deflection [m] that a motion asks for at `time` [s]."""
    if motion.places:
        places = np.array(motion.places)
        index = np.maximum(time // (MOVE + REST), 0.0).astype(int)
        start, goal = places[index % len(places)], places[(index + 1) % len(places)]
        r = np.clip((time - index * (MOVE + REST)) / MOVE, 0.0, 1.0)
        return start + (goal - start) * r**3 * (10.0 - 15.0 * r + 6.0 * r * r)
    r = np.clip(time / RAMP, 0.0, 1.0)
    tones = [a * np.sin(2 * np.pi * f * time + 1.3 * i) for i, (a, f) in enumerate(motion.tones)]
    return motion.centre + r * r * (3.0 - 2.0 * r) * np.sum(tones, axis=0)
