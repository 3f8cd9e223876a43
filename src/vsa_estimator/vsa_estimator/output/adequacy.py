# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Adequacy of the force law: whether it explains the force, and where in deflection or velocity it does not."""

import math

import numpy as np
from vsa_common.types import Array
from vsa_estimator.tuning.fault_detection import CONSISTENT_SHARE, MAX_SCALE
from vsa_estimator.tuning.output import (
    ADEQUACY_MEMORY,
    DEFLECTION_BIN,
    LOCATION_SIGNIFICANCE,
    LOCATION_VISITS,
    STATED_ERROR,
    VELOCITY_BIN,
)

BINS = 32  # of each axis; the outer ones have all that is beyond them
AXES = ("deflections", "mm"), ("velocities", "mm/s")


class Adequacy:
    """Lack of fit of the published law: its unexplained force, and the mean residual by deflection and by velocity.

    The unexplained force is the root mean square of mean residuals beyond their stated error. A law is inadequate while
    it is so large that it hides a fault of a sensor.
    """

    def __init__(self, k2: float, peak_speed: float) -> None:
        """`k2` [1/m] and v* [m/s] of the start values scale the bins."""
        self._widths = DEFLECTION_BIN / k2, VELOCITY_BIN * peak_speed
        self.restart()

    def restart(self) -> None:
        """Drop the residuals: the law is another one."""
        self._square = 0.0  # mean square of the unexplained force [N^2]
        self._visit = np.zeros((len(AXES), BINS, 2))  # of each bin: rows of the present visit, sum of residuals [N]
        self._visits = np.zeros((len(AXES), BINS, 3))  # visits, their means [N], and squares of them [N^2]
        self._centre = math.nan  # of the deflections [m]
        self.is_inadequate = False

    def add(self, window: tuple[float, float, float], residual: Array, deflection: Array, velocity: Array) -> None:
        """Add a window: magnitude of its mean residual [N], its stated std [N], share in motion; and its rows (n,).

        A visit of a bin ends with a window without a row in it; its mean is one sample: residuals are correlated.
        """
        magnitude, std, in_motion = window
        excess = max(magnitude - STATED_ERROR * std, 0.0)
        self._square += in_motion / ADEQUACY_MEMORY * (excess * excess - self._square)
        self.is_inadequate = self._unexplained > MAX_SCALE * (CONSISTENT_SHARE if self.is_inadequate else 1.0)
        if not residual.size:
            return
        if math.isnan(self._centre):
            self._centre = float(deflection[0])
        for axis, values in enumerate((deflection - self._centre, velocity)):
            places = np.clip(np.floor(values / self._widths[axis]).astype(int) + BINS // 2, 0, BINS - 1)
            rows = np.stack([np.bincount(places, weights, BINS) for weights in (None, residual)], axis=1)
            visit = self._visit[axis]
            ended = (visit[:, 0] > 0.0) & (rows[:, 0] == 0.0)
            means = visit[ended, 1] / visit[ended, 0]
            new = np.stack([np.ones_like(means), means, means**2], axis=1)
            self._visits[axis, ended] += new - self._visits[axis, ended] / LOCATION_VISITS
            visit += rows
            visit[ended] = 0.0

    @property
    def _unexplained(self) -> float:
        """Force that the law does not explain [N]."""
        return math.sqrt(self._square)

    def describe(self) -> str:
        """What the law does not explain, and where; empty for an adequate law."""
        if not self.is_inadequate:
            return ""
        return f"model inadequate: {self._unexplained:.1g} N of the force unexplained, {self._location()}"

    def _location(self) -> str:
        """The bin with the greatest significant mean residual."""
        visits = np.maximum(self._visits[..., 0], 1.0)
        mean, square = self._visits[..., 1] / visits, self._visits[..., 2] / visits
        error = np.sqrt(np.maximum(square - mean**2, 0.0) / visits)
        significant = (visits > 0.1 * LOCATION_VISITS) & (np.abs(mean) > LOCATION_SIGNIFICANCE * error)
        if not significant.any():
            return "at no particular deflection or velocity"
        axis, place = np.unravel_index(np.argmax(np.where(significant, np.abs(mean), 0.0)), mean.shape)
        (name, unit), width = AXES[axis], self._widths[axis]
        low = (int(place) - BINS // 2) * width + (0.0 if axis else self._centre)
        return f"most at {name} of {1e3 * low:.3g} to {1e3 * (low + width):.3g} {unit}"
