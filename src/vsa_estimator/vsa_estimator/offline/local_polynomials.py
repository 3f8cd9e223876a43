# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Zero-phase local polynomials over samples at any stamps: value, slope and curvature as linear operators."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.tuning.offline import EVEN_TOLERANCE, POLYNOMIAL_DEGREE, RESIDUAL_CAP

CANDIDATES = (4, 6, 8, 11, 16, 22, 32, 45, 64, 90, 128, 180)  # half-widths [samples], a factor of 1.4 apart


@dataclass(frozen=True)
class LocalPolynomials:
    """Linear operators of a smoother: row i of `value`, `slope`, `curvature` weights the samples `window[i]`."""

    window: NDArray[np.int64]  # (samples, width) indices
    value: Array  # (samples, width)
    slope: Array  # [1/s]
    curvature: Array  # [1/s^2]

    def apply(self, weights: Array, signal: Array) -> Array:
        """One of the three operators on `signal` (samples,)."""
        return np.asarray(np.einsum("ij,ij->i", weights, signal[self.window]))

    def transpose(self, weights: Array, rows: Array) -> Array:
        """Transposed operator on `rows` (samples, n): sensitivity of their sum to the noise of each sample."""
        result = np.zeros_like(rows)
        for column in range(rows.shape[1]):
            spread = (weights * rows[:, column, None]).ravel()
            result[:, column] = np.bincount(self.window.ravel(), spread, minlength=len(rows))
        return result

    @property
    def freedom(self) -> float:
        """Effective degrees of freedom of the smoother: trace of its hat matrix."""
        return float(np.sum(self.value[self.window == np.arange(len(self.window))[:, None]]))


def local_polynomials(time: Array, half: int) -> LocalPolynomials:
    """Least-squares polynomials over the 2 half + 1 samples around each one, or the first or last ones at the ends.

    `time` (samples,) [s].
    """
    count = len(time)
    width = min(2 * half + 1, count)
    first = np.clip(np.arange(count) - half, 0, count - width)
    window = first[:, None] + np.arange(width)
    steps = np.diff(time)
    if np.ptp(steps) > EVEN_TOLERANCE * steps.mean():
        return LocalPolynomials(window, *_operators(time[window] - time[:, None]))
    # Even stamps: rows with the same position in their window have the same weights.
    position, shape = np.unique(np.arange(count) - first, return_inverse=True)
    offsets = (np.arange(width) - position[:, None]) * steps.mean()
    value, slope, curvature = _operators(offsets)
    return LocalPolynomials(window, value[shape], slope[shape], curvature[shape])


def _operators(offset: Array) -> tuple[Array, Array, Array]:
    """Weights of value, slope and curvature at zero for windows with stamps `offset` (windows, width) [s]."""
    scale = np.abs(offset).max(axis=1, keepdims=True)
    powers = (offset / scale)[:, :, None] ** np.arange(POLYNOMIAL_DEGREE + 1)
    normal = np.swapaxes(powers, 1, 2) @ powers
    weights = np.linalg.solve(normal, np.swapaxes(powers, 1, 2))
    return weights[:, 0], weights[:, 1] / scale, 2.0 * weights[:, 2] / scale**2


def noise_std(polynomials: LocalPolynomials, signal: Array) -> float:
    """Standard deviation of white noise on `signal` from the smoother's residual; robust against discontinuities."""
    residual = signal - polynomials.apply(polynomials.value, signal)
    share = max(1.0 - polynomials.freedom / len(signal), 1e-3)
    variance = float(np.mean(residual**2))
    for _ in range(4):
        variance = float(np.mean(np.minimum(residual**2, RESIDUAL_CAP**2 * variance)))
    return float(np.sqrt(variance / share))


def best_half(time: Array, signal: Array) -> int:
    """Half-width [samples] of the window with the least generalised cross-validation error."""
    best, minimum = CANDIDATES[0], np.inf
    for half in CANDIDATES:
        if 2 * half + 1 > len(time):
            break
        polynomials = local_polynomials(time, half)
        residual = signal - polynomials.apply(polynomials.value, signal)
        score = float(np.mean(residual**2)) / max(1.0 - polynomials.freedom / len(time), 1e-3) ** 2
        if score < minimum:
            best, minimum = half, score
        elif score > 1.2 * minimum:
            break
    return best
