# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Usual magnitude of the mean parity residuals."""

import math

import numpy as np
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
        shares, squares = np.where(np.isnan(means), 0.0, in_motion), np.square(np.nan_to_num(means))
        self._weights = np.minimum(self._weights + shares, MEMORY)
        self._squares += shares / self._weights * (np.minimum(squares, SCALE_CAP * self._squares) - self._squares)
        self._squares = np.maximum(self._squares, MIN_SCALE**2)

    def std(self, index: int) -> float:
        """Usual mean residual of a window [N]."""
        return math.sqrt(float(self._squares[index]))
