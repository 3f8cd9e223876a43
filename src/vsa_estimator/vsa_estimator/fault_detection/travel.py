# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Travel in which an elastic law is known."""

import math
from collections.abc import Iterable

from vsa_estimator.tuning.fault_detection import EXTRAPOLATION_MARGIN

EVERYWHERE = -math.inf, math.inf  # limits of the deflection [m]


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
