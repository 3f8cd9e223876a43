# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Size of a fault by its mean parity residuals, and the deflection at which they become small."""

import math
from collections import deque

from vsa_common.types import Array
from vsa_estimator.tuning.fault_detection import CONSISTENT_SHARE


class FaultSize:
    """Size of one fault, and the passage of its residual through zero."""

    def __init__(self, passage: int) -> None:
        """`passage`: evaluations over which the slope of the residual is taken."""
        self.shift = (0.0, 0.0)  # if the fault shifts the force [N], the encoder [m]; 0: unknown
        self._means: deque[tuple[float, float, bool]] = deque(maxlen=passage)  # [N], deflection [m], not small
        self._slope, self._deflection = math.inf, math.nan  # of the mean residual [N/m], where it is small [m]

    def add(self, mean: float, deflection: float, normalized: float, stiffness: float, rejected: bool) -> None:
        """Add a mean residual [N], also over its threshold, at a deflection [m] with the law's `stiffness` [N/m].

        `rejected`: whether deflections were rejected. The largest shift counts. The slope is that before the first
        small mean. It is infinite after a step of the encoder, and where the mean was small at the begin of the
        passage: the residual of another law does not come and go.
        """
        if normalized > 1.0:
            self.shift = max(self.shift, (abs(mean), abs(mean) / stiffness))
        if math.isnan(mean):
            return
        self._means.append((mean, deflection, normalized > CONSISTENT_SHARE))
        if normalized > CONSISTENT_SHARE:
            self._slope, self._deflection = math.inf, math.nan
        elif math.isnan(self._deflection):
            last, position, inconsistent = self._means[0]
            passed = inconsistent and position != deflection and not rejected
            self._slope, self._deflection = (mean - last) / (deflection - position) if passed else math.inf, deflection

    def hidden_slope(self, stiffness: float, deflections: Array, residuals: Array, limit: float) -> float:
        """Difference of the stiffness [N/m] of another law without a residual at the present deflections, or 0.

        The residual of another law passes zero with a slope, the difference of the stiffnesses. Beyond the `stiffness`
        of the checkpoint it is excluded; within, by the log likelihood ratio of residuals [N] (n,) at deflections [m]
        with that slope to none, above the square of `limit` [N].
        """
        if not abs(self._slope) < stiffness:
            return 0.0
        expected = self._slope * (deflections - self._deflection)
        shows = float(expected @ (expected - 2.0 * residuals)) > residuals.size * limit**2
        return 0.0 if shows else abs(self._slope)

    @property
    def deflection(self) -> float:
        """Deflection at which the residual has become small [m]; NaN before."""
        return self._deflection
