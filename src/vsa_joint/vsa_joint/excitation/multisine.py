# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The family of motions: a slow sine over the travel and two faster ones, within limits of range and speed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from vsa_common.types import Array
from vsa_joint.excitation.tuning import (
    FADE_TIME,
    FAST_FREQUENCIES,
    FAST_RATIO,
    SLOW_FREQUENCIES,
    SLOW_SHARES,
    SPEED_SHARES,
    TRAVEL_SHARES,
)


@dataclass(frozen=True)
class Range:
    """Range of the mean deflection [m], relative to the start, and its greatest speed [m/s]."""

    low: float
    high: float
    speed: float

    @property
    def centre(self) -> float:
        """Middle of the range [m]."""
        return 0.5 * (self.low + self.high)

    @property
    def half(self) -> float:
        """Half of the range [m]."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True)
class Multisine:
    """Mean deflection about `centre` [m]: sines of `amplitudes` [m] at `frequencies` [Hz]; none: at rest."""

    centre: float
    amplitudes: tuple[float, ...] = ()
    frequencies: tuple[float, ...] = ()

    def __call__(self, time: Array) -> Array:
        """Mean deflection [m] at each instant since the begin [s]."""
        omega = 2.0 * math.pi * np.array(self.frequencies)
        return np.asarray(self.centre + np.sin(np.multiply.outer(time, omega)) @ np.array(self.amplitudes))

    def __str__(self) -> str:
        parts = zip(self.amplitudes, self.frequencies, strict=True)
        return " + ".join(f"{1e3 * abs(amplitude):.2g} mm at {f:.2g} Hz" for amplitude, f in parts) or "at rest"


def fade(time: Array) -> Array:
    """Share of a new motion at an instant since its begin [s]: 0 to 1 within FADE_TIME, a cubic."""
    part = np.clip(time / FADE_TIME, 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part), float)


def paths(motions: Sequence[Multisine], mean: float, step: float, count: int) -> Array:
    """Mean deflection of each motion from rest at `mean` [m], (motions, count), at steps of `step` [s]."""
    time = np.asarray(step * np.arange(1, count + 1), float)
    targets = np.array([motion(time) for motion in motions])
    return np.asarray(mean + fade(time) * (targets - mean))


def family(limits: Range, peak_speed: float) -> Iterator[Multisine]:
    """All motions of the family within limits; `peak_speed` [m/s] is that of the dampers."""
    slow = product(SPEED_SHARES, SLOW_SHARES, SLOW_FREQUENCIES, TRAVEL_SHARES)
    for (speed_share, slow_share, low, travel), high in product(slow, FAST_FREQUENCIES):
        speed = min(speed_share * peak_speed, limits.speed)
        frequencies = (low, high, FAST_RATIO * high)
        speeds = (slow_share * speed, *(0.5 * (1.0 - slow_share) * speed,) * 2)
        amplitudes = [v / (2.0 * math.pi * f) for v, f in zip(speeds, frequencies, strict=True)]
        amplitudes[0] = min(amplitudes[0], abs(travel) * limits.half - sum(amplitudes[1:]))
        if amplitudes[0] > 0.0:
            amplitudes[0] = math.copysign(amplitudes[0], travel)
            yield Multisine(limits.centre, tuple(amplitudes), frequencies)
