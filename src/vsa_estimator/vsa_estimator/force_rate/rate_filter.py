"""Force rate by the paper's first-order filter (section V-B)."""

import math

import numpy as np
from scipy.signal import lfilter
from vsa_common.types import Array

RATE_FILTER = 0.19  # time constant [s] that section VI's 0.017 N and 0.088 N/s imply together


def filtered_rate(force: Array, step: float) -> Array:
    """Force rate [N/s] of an evenly sampled force [N], `step` [s] apart; starts at rest."""
    keep = math.exp(-step / RATE_FILTER)
    return np.asarray(lfilter(np.array([1.0, -1.0]) * (1.0 - keep) / step, [1.0, -keep], force - force[0]))


class RateFilter:
    """The same, sample by sample."""

    def __init__(self) -> None:
        """At rest until the second sample."""
        self.rate = 0.0
        self._force: float | None = None

    def add(self, force: float, dt: float) -> float:
        """Force rate [N/s] after a force [N] that came `dt` [s] after the one before."""
        if self._force is not None and dt > 0.0:
            keep = math.exp(-dt / RATE_FILTER)
            self.rate = keep * self.rate + (1.0 - keep) * (force - self._force) / dt
        self._force = force
        return self.rate
