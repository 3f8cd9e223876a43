# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Segments of a recording for identification: held forces removed, motion smoothed, noise measured."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.offline.local_polynomials import LocalPolynomials, best_half, local_polynomials, noise_std
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.tuning.offline import (
    HELD_SHARE,
    MAX_RATE,
    MIN_SAMPLES,
    REVERSAL_SHARE,
    REVERSAL_SPEED,
    SEGMENT_SAMPLES,
    SIGN_STDS,
    WINDOW_SHARE,
)


@dataclass(frozen=True)
class Segment:
    """Smoothed motion and measured force, some seconds of a recording."""

    time: Array  # [s]
    force: Array  # [N]
    deflection: Array  # [m]
    velocity: Array  # [m/s]
    acceleration: Array  # [m/s^2]
    polynomials: LocalPolynomials
    force_noise: float  # [N]
    deflection_noise: float  # [m]
    min_speed: Array  # below it the weight of a row is zero, from twice this speed on it is full [m/s]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Rows with a weight above zero."""
        return np.asarray(np.abs(self.velocity) > self.min_speed)

    @cached_property
    def motion_covariance(self) -> Array:
        """Covariance of deflection, velocity and acceleration at each sample, (samples, 3, 3)."""
        weights = np.stack([self.polynomials.value, self.polynomials.slope, self.polynomials.curvature], axis=1)
        return np.asarray(self.deflection_noise**2 * np.einsum("iaw,ibw->iab", weights, weights))


def segments_of(recording: Recording) -> tuple[list[Segment], int]:
    """Smoothed segments of at most SEGMENT_SAMPLES each, and the number of held force samples that were removed.

    Raises RecordingError where too few samples are usable.
    """
    time, force, deflection, held = _prepare(recording)
    parts = np.array_split(np.arange(len(time)), max(1, -(-len(time) // SEGMENT_SAMPLES)))
    return [_smooth(time[part], force[part], deflection[part]) for part in parts], held


def _prepare(recording: Recording) -> tuple[Array, Array, Array, int]:
    """Time [s], force and deflection: finite, in order, not held, averaged to about MAX_RATE; the held forces."""
    usable = np.isfinite(recording.stamp) & np.isfinite(recording.force) & np.isfinite(recording.deflection)
    time, force, deflection = (a[usable] for a in (recording.stamp, recording.force, recording.deflection))
    forward = np.r_[True, time[1:] > np.maximum.accumulate(time)[:-1]] if len(time) else np.zeros(0, bool)
    time, force, deflection = time[forward] - time[:1], force[forward], deflection[forward]
    held = np.r_[False, np.diff(force) == 0.0]
    repeated = int(held.sum()) if held.mean() > HELD_SHARE else 0
    if repeated:
        time, force, deflection = time[~held], force[~held], deflection[~held]
    size = max(1, int(1.0 / (MAX_RATE * float(np.median(np.diff(time)))) + 0.5)) if len(time) > 1 else 1
    if len(time) < MIN_SAMPLES * size:
        expected = f"expected at least {MIN_SAMPLES * size} usable samples"
        raise RecordingError(f"{recording.source}: {expected}, found {len(time)}")
    count = len(time) // size * size
    time, force, deflection = (a[:count].reshape(-1, size).mean(axis=1) for a in (time, force, deflection))
    return time, force, deflection, repeated


def _smooth(time: Array, force: Array, deflection: Array) -> Segment:
    """Motion by local polynomials, noise from their residuals."""
    best = best_half(time, deflection)
    polynomials = local_polynomials(time, max(4, round(WINDOW_SHARE * best)))
    x, v, a = (polynomials.apply(w, deflection) for w in (polynomials.value, polynomials.slope, polynomials.curvature))
    high_speed = float(np.quantile(np.abs(v), 0.95))
    deflection_noise = noise_std(polynomials, deflection)
    velocity_noise = deflection_noise * np.linalg.norm(polynomials.slope, axis=1)
    resolution = float(np.finfo(float).eps) * max(float(np.abs(force).max()), 1.0)
    return Segment(
        time=time, force=force, deflection=x, velocity=v, acceleration=a, polynomials=polynomials,
        force_noise=max(noise_std(local_polynomials(time, max(4, best // 4)), force), resolution),
        deflection_noise=deflection_noise,
        min_speed=np.maximum(
            min(REVERSAL_SPEED, REVERSAL_SHARE * high_speed), SIGN_STDS * velocity_noise
        ),
    )  # fmt: skip
