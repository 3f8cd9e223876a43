# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Travel in which an elastic law is known, and the speed up to which a cubic damper is."""

import math
from collections.abc import Iterable

from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.damper import known_speed
from vsa_estimator.force_law.state import C_D1, C_D2
from vsa_estimator.tuning.fault_detection import EXTRAPOLATION_MARGIN

EVERYWHERE = -math.inf, math.inf  # limits of the deflection [m]
Limits = tuple[float, float, float]  # two of the deflection [m] and one of the speed [m/s]


@compiled
def known_limits(mean: Array, covariance: Array, limits: Limits) -> Limits:
    """`limits` with the speed up to which the damper of the coefficients (7,), (7, 7) is known."""
    return limits[0], limits[1], known_speed(mean[C_D1], mean[C_D2], covariance[C_D2, C_D2], limits[2])


class Travel:
    """Travel in which the sensors were consistent with a law."""

    def __init__(self) -> None:
        """No travel yet."""
        self._low, self._high = math.inf, -math.inf  # [m]

    @property
    def is_empty(self) -> bool:
        """Whether there is none yet."""
        return self._low > self._high

    def extend(self, deflections: Iterable[float]) -> None:
        """Extend it by deflections [m]."""
        self._low, self._high = min((self._low, *deflections)), max((self._high, *deflections))

    def shift(self, offset: float) -> None:
        """The encoder reads `offset` [m] more from now on."""
        self._low, self._high = self._low + offset, self._high + offset

    def limits(self, k2: float) -> tuple[float, float]:
        """Deflections [m] up to which the law with `k2` [1/m] holds."""
        margin = EXTRAPOLATION_MARGIN / k2
        return self._low - margin, self._high + margin
