# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Measurement noise: white noise of a sensor from its samples, and what the model adds to the noise of a force.

The noise is estimated from third differences, in which smooth motion nearly vanishes.
"""

from collections import deque

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.records import NOISE_LEVEL, Record
from vsa_estimator.force_law.elastic import stiffness
from vsa_estimator.force_law.state import D0, K2, S, V, X
from vsa_estimator.tuning.filter import (
    CROSS_NOISE_SHARE,
    MIN_NOISE_SAMPLES,
    MIN_REVERSAL_FORCE,
    MINIMUM_WINDOWS,
    NOISE_OUTLIER_RATIO,
    NOISE_RANGE,
    REVERSAL_SHARE,
    REVERSAL_SPEED,
    REVERSAL_TIME,
)

THIRD_DIFFERENCE_VARIANCE = 20.0  # of unit white noise: 1 + 9 + 9 + 1
CHI_SQUARE_MEDIAN = 0.455  # one degree of freedom
CAPPED_MEAN = 0.9205  # of the square of a unit Gaussian, capped at NOISE_OUTLIER_RATIO = 4


@compiled
def measurement_cross_noise(z: Array, reference: float, deflection_variance: float) -> float:
    """Noise of the encoder through the stiffness, which is correlated with that of the state [N^2]."""
    sigma = stiffness(z[S], z[K2], z[X] - reference)
    return float(CROSS_NOISE_SHARE * sigma * sigma * deflection_variance)


@compiled
def friction_error_variance(z: Array, p: Array, time_since_motion: float, dt: float) -> float:
    """Variance [N^2] of the Coulomb model error around zero velocity.

    All forces of `time_since_motion` [s], at `dt` [s] each, share one error: it counts as often as they are.
    """
    force_error = max(REVERSAL_SHARE * (z[D0] + np.sqrt(p[D0, D0])), MIN_REVERSAL_FORCE)
    reversal = force_error * np.exp(-(z[V] ** 2) / (REVERSAL_SPEED**2 + 2.0 * p[V, V]))
    correlated = max(1.0, max(REVERSAL_TIME, time_since_motion) / dt)
    return float(reversal * reversal * correlated)


@compiled
def add_mean(level: Record, squares: Array, mean: float, count: int) -> None:
    """Add the mean of `count` samples; the square of its third difference goes into the ring buffer `squares`."""
    one = level[0]
    means = one["means"]
    difference = mean - 3.0 * means[2] + 3.0 * means[1] - means[0]
    means[0], means[1], means[2] = means[1], means[2], mean
    one["run_length"] += 1
    if one["run_length"] >= 4:
        squares[one["differences"] % squares.size] = count * difference * difference / THIRD_DIFFERENCE_VARIANCE
        one["differences"] += 1


@compiled
def robust_mean(squares: Array) -> float:
    """Mean of squared Gaussian values, by M-estimation: values above NOISE_OUTLIER_RATIO times the mean are capped."""
    mean = float(np.median(squares)) / CHI_SQUARE_MEDIAN + 1e-300
    for _ in range(4):
        cap, total = NOISE_OUTLIER_RATIO * mean, 0.0
        for square in squares:
            total += min(square, cap)
        mean = total / (CAPPED_MEAN * squares.size)
    return mean


class NoiseLevel:
    """Running standard deviation of the white noise of one sample, over the last `capacity` means of samples.

    Fast motion adds to it; `least_std` is the least one of the last MINIMUM_WINDOWS refreshes (minimum statistics;
    Martin, IEEE Trans. Speech Audio Process. 9, 2001).
    """

    def __init__(self, configured: float, minimum: float, capacity: int) -> None:
        """Start at the `configured` one; limited to a NOISE_RANGE-th (and `minimum`) and NOISE_RANGE times of it."""
        self.std = configured
        self._recent: deque[float] = deque(maxlen=MINIMUM_WINDOWS)
        self._low = max(configured / NOISE_RANGE, minimum)
        self._high = NOISE_RANGE * configured
        self._squares = np.zeros(capacity)
        self._level = np.zeros(1, NOISE_LEVEL)

    @property
    def least_std(self) -> float:
        """Least `std` of the last MINIMUM_WINDOWS refreshes [unit of the samples]."""
        return min(self._recent, default=self.std)

    def add(self, value: float, count: int = 1) -> None:
        """Add the mean of `count` samples of an evenly sampled sequence."""
        add_mean(self._level, self._squares, value, count)

    def interrupt(self) -> None:
        """Start a new sequence after a gap: no difference is taken across it."""
        self._level["run_length"] = 0

    def refresh(self) -> float:
        """Update `std` [unit of the samples] from the stored differences; the new value."""
        squares = self._squares[: self._level["differences"][0]]
        if squares.size >= MIN_NOISE_SAMPLES:
            self.std = float(np.clip(np.sqrt(robust_mean(squares)), self._low, self._high))
            if squares.size == self._squares.size:  # a short record scatters
                self._recent.append(self.std)
        return self.std
