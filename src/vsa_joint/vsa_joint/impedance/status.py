"""Status and reset reasons on the wire, as in TransmissionImpedance.msg."""

from enum import IntEnum


class Status(IntEnum):
    """How an estimate is doing."""

    INITIALIZING = 0
    CONVERGING = 1
    VALID = 2
    DEGRADED = 3
    STALE = 4
    FAULT = 5


class ResetReason(IntEnum):
    """Why an estimator last started over."""

    NONE = 0
    REQUESTED = 1
    TIME_JUMP = 2
    GAP = 3
    INNOVATION = 4
    DEFLECTION = 5
