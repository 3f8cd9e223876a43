# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force rate by the paper's first-order filter (section V-B)."""

import math

import numpy as np
from vsa_common.types import Array
from vsa_estimator.tuning.force_rate import RATE_FILTER


def filtered_rate(force: Array, step: float) -> Array:
    """Force rate [N/s] of evenly sampled force [N] (..., samples), `step` [s] apart; zero at the first sample."""
    from scipy.signal import lfilter  # not for live nodes: takes half a second to load

    keep = math.exp(-step / RATE_FILTER)
    return np.asarray(lfilter(np.array([1.0, -1.0]) * (1.0 - keep) / step, [1.0, -keep], force - force[..., :1]))


class RateFilter:
    """The same filter, sample by sample."""

    def __init__(self) -> None:
        """Zero until the second sample."""
        self.rate = 0.0  # [N/s]
        self._force: float | None = None

    def add(self, force: float, dt: float) -> float:
        """Force rate [N/s] after a sample of force [N], `dt` [s] after the previous one."""
        if self._force is not None and dt > 0.0:
            keep = math.exp(-dt / RATE_FILTER)
            self.rate = keep * self.rate + (1.0 - keep) * (force - self._force) / dt
        self._force = force
        return self.rate
