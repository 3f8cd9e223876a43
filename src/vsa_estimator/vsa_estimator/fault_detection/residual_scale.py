# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Usual magnitude of the mean parity residuals, in motion and at rest."""

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
    """Root mean square of the mean residuals of n windows, apart for rows in motion and at rest.

    In motion the mean has the noise of the velocity, at rest only what exceeds stiction.
    """

    def __init__(self) -> None:
        """At the prior."""
        self._squares = np.tile(np.square(INITIAL_SCALE), (2, 1))  # in motion, at rest [N^2], (2, n)
        self._weights = np.full(self._squares.shape, float(PRIOR_WEIGHT))  # evaluations

    def adapt(self, means: Array, hidden: Array, in_motion: Array) -> None:
        """Adapt to mean residuals [N], the stiction that they may hide [N], and shares of rows in motion, each (n,).

        NaN is no mean.
        """
        shares = np.where(np.isnan(means), 0.0, [in_motion, 1.0 - in_motion])
        magnitudes = np.nan_to_num(np.abs(means))
        squares = np.square([magnitudes, np.maximum(magnitudes - hidden, 0.0)])
        self._weights = np.minimum(self._weights + shares, MEMORY)
        self._squares += shares / self._weights * (np.minimum(squares, SCALE_CAP * self._squares) - self._squares)
        self._squares = np.maximum(self._squares, MIN_SCALE**2)

    def std(self, index: int, in_motion: float = 1.0) -> float:
        """Usual mean residual of a window [N] with a share of rows `in_motion`."""
        moving, resting = self._squares[:, index].tolist()
        return math.sqrt(in_motion * moving + (1.0 - in_motion) * resting)
