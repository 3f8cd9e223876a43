# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Chi-square tests: of the innovations over a window, and of one set of coefficients against another."""

from collections import deque

import numpy as np
from vsa_common.types import Array
from vsa_estimator.tuning.filter import NIS_CAP, NIS_THRESHOLD, NIS_WINDOW


class NisTest:
    """Mean of the NIS over NIS_WINDOW; 1 for a consistent filter."""

    def __init__(self, rate: float) -> None:
        """`rate` of the innovations [Hz]."""
        self._values: deque[float] = deque(maxlen=int(NIS_WINDOW * rate))
        self._sum = 0.0

    def add(self, nis: float) -> None:
        """Add the NIS of one innovation."""
        nis = min(nis, NIS_CAP)
        if len(self._values) == self._values.maxlen:
            self._sum -= self._values[0]
        self._values.append(nis)
        self._sum += nis

    def reset(self) -> None:
        """Start a new window."""
        self._values.clear()
        self._sum = 0.0

    @property
    def failed(self) -> bool:
        """Whether the mean of a full window exceeds NIS_THRESHOLD."""
        full = len(self._values) == self._values.maxlen
        return full and self._sum > NIS_THRESHOLD * len(self._values)


def mahalanobis_square(error: Array, covariance: Array) -> float:
    """Squared Mahalanobis distance of an error (n) under its covariance (n x n), scaled for numerical stability."""
    scale = np.sqrt(np.diag(covariance))
    error = error / scale
    return float(error @ np.linalg.solve(covariance / np.outer(scale, scale), error))
