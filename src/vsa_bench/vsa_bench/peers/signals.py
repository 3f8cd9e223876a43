# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Causal filters, a polynomial basis and least squares for the peers, over many recordings at once.

Arrays are (recordings, samples).
"""

import numpy as np
from numpy.polynomial import chebyshev
from vsa_common.types import Array

LOW_NOISE = 0.02e-3  # encoder noise above which deflection is smoothed before a polynomial is evaluated [m]
RANGE = (0.0, 0.020)  # deflection that the polynomials span [m]


def state_variable_filter(signal: Array, rate: float, cutoff: float) -> tuple[Array, Array]:
    """Signal and its first derivative behind a causal third-order Butterworth filter of `cutoff` [Hz]."""
    w = 2.0 * np.pi * cutoff
    first = signal[:, :1]
    value, slope = (_filtered(numerator, w, signal - first, rate) for numerator in ([w**3], [w**3, 0.0]))
    return value + first, slope


def second_derivative(signal: Array, rate: float, cutoff: float) -> Array:
    """Second derivative behind the same filter."""
    w = 2.0 * np.pi * cutoff
    return _filtered([w**3, 0.0, 0.0], w, signal - signal[:, :1], rate)


def _filtered(numerator: list[float], w: float, signal: Array, rate: float) -> Array:
    """Signal behind a numerator over the third-order Butterworth denominator of `w` [rad/s]."""
    from scipy.signal import bilinear, lfilter  # takes more than half a second, which --help does not need

    b, a = bilinear(numerator, [1.0, 2.0 * w, 2.0 * w**2, w**3], rate)
    return np.asarray(lfilter(b, a, signal, axis=1), dtype=np.float64)


def evaluation_point(deflection: Array, rate: float, noise: float) -> Array:
    """Deflection at which a fitted law is evaluated: as measured at low noise, else filtered at 15 Hz."""
    return deflection if noise <= LOW_NOISE else state_variable_filter(deflection, rate, 15.0)[0]


def basis(deflection: Array, degree: int) -> tuple[Array, Array]:
    """Chebyshev polynomials 0 to `degree` over RANGE and their slopes [1/m], stacked in the last axis."""
    low, high = RANGE
    scaled = (2.0 * deflection - low - high) / (high - low)
    slopes = [chebyshev.chebval(scaled, chebyshev.chebder(row)) for row in np.eye(degree + 1)]
    values = np.asarray(chebyshev.chebvander(scaled, degree), dtype=np.float64)
    return values, np.asarray(np.stack(slopes, axis=-1) * 2.0 / (high - low), dtype=np.float64)


class ForgettingLeastSquares:
    """Recursive least squares with exponential forgetting, one problem a recording.

    Without excitation the covariance grows; its trace is limited.
    """

    START = 100.0  # variance of a coefficient at the start [N^2]
    WINDUP = 10.0  # times the start's trace

    def __init__(self, start: Array, forgetting: float) -> None:
        """`start`: (recordings, coefficients); `forgetting`: weight of the past after one step, below 1."""
        self.coefficients = start.copy()
        self._forgetting = forgetting
        self._p = np.tile(self.START * np.eye(start.shape[1]), (len(start), 1, 1))
        self._most = self.WINDUP * self.START * start.shape[1]

    def add(self, row: Array, value: Array) -> None:
        """Update with one equation a recording: row (recordings, coefficients), value (recordings,)."""
        ph = np.einsum("sij,sj->si", self._p, row)
        scale = self._forgetting + np.einsum("si,si->s", row, ph)
        error = value - np.einsum("si,si->s", row, self.coefficients)
        self.coefficients += ph * (error / scale)[:, None]
        self._p = (self._p - ph[:, :, None] * ph[:, None, :] / scale[:, None, None]) / self._forgetting
        trace = np.trace(self._p, axis1=1, axis2=2)
        self._p *= np.minimum(1.0, self._most / trace)[:, None, None]
