"""Recorded samples made ready to identify from: held forces left out, motion smoothed, noise measured."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.offline.smoothing import LocalPolynomials, best_half, local_polynomials, noise_std

RATE = 100.0  # faster recordings are averaged to about this [Hz]
REVERSAL_SPEED = 0.2e-3  # below it Coulomb's law does not hold [m/s] ...
REVERSAL_SHARE = 0.15  # ... or below this share of the usual speed, whichever is less
HELD_SHARE = 0.2  # more repeated forces than this: a sensor slower than the recording
LEAST_SAMPLES = 12
UNDERSMOOTHED = 0.6  # of the best window for deflection: its slopes want less bias, and their noise is accounted for


@dataclass(frozen=True)
class Piece:
    """Smoothed motion beside measured force, some seconds of a recording."""

    time: Array  # [s]
    force: Array  # [N]
    deflection: Array  # [m]
    velocity: Array
    acceleration: Array
    polynomials: LocalPolynomials
    force_noise: float  # [N]
    deflection_noise: float  # [m]
    slowest: Array  # below this speed Coulomb's law is not trusted; from twice this speed on entirely [m/s]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Rows that count."""
        return np.asarray(np.abs(self.velocity) > self.slowest)

    @cached_property
    def motion_covariance(self) -> Array:
        """Covariance of deflection, velocity and acceleration at each sample, (samples, 3, 3)."""
        weights = np.stack([self.polynomials.value, self.polynomials.slope, self.polynomials.curvature], axis=1)
        return np.asarray(self.deflection_noise**2 * np.einsum("iaw,ibw->iab", weights, weights))


def prepare(recording: Recording) -> tuple[Array, Array, Array, int]:
    """Time [s], force, deflection: finite, in order, fresh, averaged to about RATE; how many forces were held."""
    usable = np.isfinite(recording.stamp) & np.isfinite(recording.force) & np.isfinite(recording.deflection)
    time, force, deflection = (a[usable] for a in (recording.stamp, recording.force, recording.deflection))
    forward = np.r_[True, time[1:] > np.maximum.accumulate(time)[:-1]] if len(time) else np.zeros(0, bool)
    time, force, deflection = time[forward] - time[:1], force[forward], deflection[forward]
    held = np.r_[False, np.diff(force) == 0.0]
    repeated = int(held.sum()) if held.mean() > HELD_SHARE else 0
    if repeated:
        time, force, deflection = time[~held], force[~held], deflection[~held]
    if len(time) < LEAST_SAMPLES:
        raise RecordingError(f"{recording.source}: expected at least {LEAST_SAMPLES} usable samples, found {len(time)}")
    size = max(1, int(1.0 / (RATE * float(np.median(np.diff(time)))) + 0.5))
    count = len(time) // size * size
    time, force, deflection = (a[:count].reshape(-1, size).mean(axis=1) for a in (time, force, deflection))
    return time, force, deflection, repeated


def smooth(time: Array, force: Array, deflection: Array) -> Piece:
    """Motion by local polynomials, noise from what they leave over."""
    best = best_half(time, deflection)
    polynomials = local_polynomials(time, max(4, round(UNDERSMOOTHED * best)))
    x, v, a = (polynomials.apply(w, deflection) for w in (polynomials.value, polynomials.slope, polynomials.curvature))
    usual = float(np.quantile(np.abs(v), 0.95))
    deflection_noise = noise_std(polynomials, deflection)
    velocity_noise = deflection_noise * np.linalg.norm(polynomials.slope, axis=1)
    slowest = np.maximum(min(REVERSAL_SPEED, REVERSAL_SHARE * usual), 3.0 * velocity_noise)
    resolution = float(np.finfo(float).eps) * max(float(np.abs(force).max()), 1.0)
    force_noise = max(noise_std(local_polynomials(time, max(4, best // 4)), force), resolution)
    return Piece(time, force, x, v, a, polynomials, force_noise, deflection_noise, slowest)
