# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Isolation of a constant shift of one sensor among the parity residuals of some seconds."""

from typing import NamedTuple

import numpy as np
from vsa_common.types import Array, Booleans
from vsa_estimator.force_law.elastic import deflection_shift
from vsa_estimator.tuning.fault_detection import ISOLATION_TIME, LIKELIHOOD_MARGIN, MIN_COVERAGE

Residuals = tuple[Array, Array, Array, Booleans, Array, Array]  # see `residual.residuals`


class SensorShift(NamedTuple):
    """A constant shift of one sensor that explains an inconsistency; the other one is zero."""

    force: float  # [N]
    deflection: float  # [m]
    std: float  # of the one that is not zero

    @property
    def variances(self) -> tuple[float, float]:
        """Of the shift of the encoder [m^2] and of the force sensor [N^2]."""
        variance = self.std * self.std
        return (0.0, variance) if self.force else (variance, 0.0)


NO_SHIFT = SensorShift(0.0, 0.0, 0.0)


def isolate_recent(recent: Residuals, k2: float, limit: float) -> SensorShift | None:
    """`isolate` by the moving rows of recent residuals, if they are of ISOLATION_TIME and most of them move."""
    time, residual, sigma, moving, *_ = recent
    if not time.size or time[-1] - time[0] < ISOLATION_TIME or moving.mean() < MIN_COVERAGE:
        return None
    return isolate(residual[moving], sigma[moving], k2, limit)


def isolate(residual: Array, sigma: Array, k2: float, limit: float) -> SensorShift | None:
    """The hypothesis that leaves a ripple below `limit` [N], and LIKELIHOOD_MARGIN times less than its rival.

    A force offset leaves a constant residual [N] (n,), an encoder offset one in proportion to the stiffness [N/m] (n,).
    Another transmission leaves both, with any factors: a shift that it explains LIKELIHOOD_MARGIN times better is none.
    `k2` [1/m].
    """
    offset = float(residual.mean())
    slope = float(residual @ sigma / (sigma @ sigma))  # -(1 - exp(-k2 dx)) / k2
    width = max(1, residual.size // 10)
    by_force, by_deflection = (_ripple(rest, width) for rest in (residual - offset, residual - slope * sigma))
    change = sigma - sigma.mean()
    share = float(residual @ change / (change @ change + 1e-300))
    limit = min(limit, LIKELIHOOD_MARGIN * _ripple(residual - offset - share * change, width))
    if by_force < limit and by_force * LIKELIHOOD_MARGIN < by_deflection:
        return SensorShift(offset, 0.0, by_force)
    if by_deflection < limit and by_deflection * LIKELIHOOD_MARGIN < by_force and 1.0 + k2 * slope > 0.0:
        shift = deflection_shift(k2, slope)
        return SensorShift(0.0, shift, by_deflection / float(np.sqrt(np.mean(sigma**2))))
    return None


def _ripple(values: Array, width: int) -> float:
    """Root mean square of running means over `width` values [unit of the values]."""
    return float(np.sqrt(np.mean(np.convolve(values, np.full(width, 1.0 / width), "valid") ** 2)))
