"""Zero-phase local polynomials over samples at any stamps: value, slope and curvature with their exact noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array

DEGREE = 5
EVEN = 1e-2  # steps that differ by less than this share count as even
CANDIDATES = (4, 6, 8, 11, 16, 22, 32, 45, 64, 90, 128, 180)  # samples on each side


@dataclass(frozen=True)
class LocalPolynomials:
    """Linear operators of a smoother: row i of `value`, `slope`, `curvature` weighs the samples `window[i]`."""

    window: NDArray[np.int64]  # (samples, width) indices
    value: Array  # (samples, width)
    slope: Array  # [1/s]
    curvature: Array  # [1/s^2]

    def apply(self, weights: Array, signal: Array) -> Array:
        """`signal` (samples,) behind one of the three operators."""
        return np.asarray(np.einsum("ij,ij->i", weights, signal[self.window]))

    def transpose(self, weights: Array, rows: Array) -> Array:
        """Transposed operator on rows (samples, n): what each sample's noise does to a sum over the rows."""
        result = np.zeros_like(rows)
        for column in range(rows.shape[1]):
            spread = (weights * rows[:, column, None]).ravel()
            result[:, column] = np.bincount(self.window.ravel(), spread, minlength=len(rows))
        return result

    @property
    def freedom(self) -> float:
        """Degrees of freedom that the smoother spends on its samples."""
        return float(np.sum(self.value[self.window == np.arange(len(self.window))[:, None]]))


def local_polynomials(time: Array, half: int) -> LocalPolynomials:
    """Least-squares quintics over the 2 half + 1 samples around each one (at the ends, of the first or last ones)."""
    count = len(time)
    width = min(2 * half + 1, count)
    first = np.clip(np.arange(count) - half, 0, count - width)
    window = first[:, None] + np.arange(width)
    steps = np.diff(time)
    if np.ptp(steps) > EVEN * steps.mean():
        return LocalPolynomials(window, *_operators(time[window] - time[:, None]))
    # Even stamps: rows as far from the first sample of their window have the same weights.
    place, shape = np.unique(np.arange(count) - first, return_inverse=True)
    offsets = (np.arange(width) - place[:, None]) * steps.mean()
    value, slope, curvature = _operators(offsets)
    return LocalPolynomials(window, value[shape], slope[shape], curvature[shape])


def _operators(offset: Array) -> tuple[Array, Array, Array]:
    scale = np.abs(offset).max(axis=1, keepdims=True)
    powers = (offset / scale)[:, :, None] ** np.arange(DEGREE + 1)
    normal = np.swapaxes(powers, 1, 2) @ powers
    weights = np.linalg.solve(normal, np.swapaxes(powers, 1, 2))
    return weights[:, 0], weights[:, 1] / scale, 2.0 * weights[:, 2] / scale**2


def noise_std(polynomials: LocalPolynomials, signal: Array) -> float:
    """Standard deviation of white noise on `signal`, from what the smoother leaves over; robust against kinks."""
    left = signal - polynomials.apply(polynomials.value, signal)
    share = max(1.0 - polynomials.freedom / len(signal), 1e-3)
    variance = float(np.mean(left**2))
    for _ in range(4):
        variance = float(np.mean(np.minimum(left**2, 9.0 * variance)))
    return float(np.sqrt(variance / share))


def best_half(time: Array, signal: Array) -> int:
    """The window of least generalised cross-validation error, as samples on each side."""
    best, least = CANDIDATES[0], np.inf
    for half in CANDIDATES:
        if 2 * half + 1 > len(time):
            break
        polynomials = local_polynomials(time, half)
        left = signal - polynomials.apply(polynomials.value, signal)
        score = float(np.mean(left**2)) / max(1.0 - polynomials.freedom / len(time), 1e-3) ** 2
        if score < least:
            best, least = half, score
        elif score > 1.2 * least:
            break
    return best
