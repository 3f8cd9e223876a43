# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Usual magnitude of the mean parity residuals."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.tuning.fault_detection import (
    EVALUATION_PERIOD,
    INITIAL_SCALE,
    MIN_SCALE,
    PRIOR_WEIGHT,
    SCALE_CAP,
)
from vsa_estimator.tuning.filter import EXCITATION_TIME_CONSTANT

MEMORY = round(EXCITATION_TIME_CONSTANT / EVALUATION_PERIOD)  # evaluations


@compiled
def adapt(squares: Array, weights: Array, means: Array, in_motion: Array) -> None:
    """Adapt mean squares [N^2] and their weights, each (n,), to mean residuals [N] and shares of rows in motion."""
    for i in range(squares.size):
        if np.isnan(means[i]):
            continue
        weights[i] = min(weights[i] + in_motion[i], MEMORY)
        square = min(means[i] * means[i], SCALE_CAP * squares[i])
        squares[i] += in_motion[i] / weights[i] * (square - squares[i])
        squares[i] = max(squares[i], MIN_SCALE**2)


class ResidualScale:
    """Root mean square of the mean residuals of n windows, of rows in motion.

    At rest the noise is that of the velocity too, but stiction shifts the mean by an unknown force, and what exceeds
    the greatest stiction is no measure of the noise.
    """

    def __init__(self) -> None:
        """At the prior."""
        self._squares = np.square(INITIAL_SCALE)  # [N^2], (n,)
        self._weights = np.full(len(INITIAL_SCALE), float(PRIOR_WEIGHT))  # evaluations

    def adapt(self, means: Array, in_motion: Array) -> None:
        """Adapt to mean residuals [N] and shares of rows in motion, each (n,). NaN is no mean."""
        adapt(self._squares, self._weights, means, in_motion)

    def std(self, index: int) -> float:
        """Usual mean residual of a window [N]."""
        return math.sqrt(float(self._squares[index]))
