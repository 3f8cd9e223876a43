# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Types that several packages share: arrays, status and reset reason."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]


class Status(IntEnum):
    """Status of an estimate; the numbers are those of TransmissionImpedance.msg and JointImpedance.msg."""

    INITIALIZING = 0
    CONVERGING = 1
    VALID = 2
    DEGRADED = 3
    STALE = 4
    FAULT = 5
    MODEL_INADEQUATE = 6


class ResetReason(IntEnum):
    """Reason of the last reset; the numbers are those of TransmissionImpedance.msg."""

    NONE = 0
    REQUESTED = 1
    TIME_JUMP = 2
    GAP = 3
    INNOVATION = 4
    DEFLECTION = 5
