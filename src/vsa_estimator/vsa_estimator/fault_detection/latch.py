# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Active faults: each is raised by sensor flags or by the supervisor, and holds for a time after its last detection."""

from vsa_estimator.preprocessing.sensor_flags import SensorFlag
from vsa_estimator.tuning.fault_detection import FAULT_HOLD_TIME

MAX_STAMP_NS = (1 << 63) - 1

FAULT_TEXTS = {
    SensorFlag.FORCE_NOISY: "force sensor noisy: several times the configured noise",
    SensorFlag.ENCODER_NOISY: "encoder noisy: several times the configured noise",
    SensorFlag.BURST: "burst of samples: delayed in transit",
    SensorFlag.ENCODER_FROZEN: "encoder stuck: constant to the last digit",
    SensorFlag.FORCE_STUCK: "force sensor stuck: constant while the encoder moves",
    SensorFlag.ENCODER_STUCK: "encoder stuck: constant while the force changes",
    SensorFlag.FORCE_SATURATED: "force sensor saturated",
    SensorFlag.DEFLECTION_SATURATED: "deflection at its limit",
}

DELAY = FAULT_TEXTS[SensorFlag.BURST]  # of the transmission: no fault of a sensor


class FaultLatch:
    """Active faults by text with the stamp at which each ends."""

    def __init__(self) -> None:
        """No fault."""
        self.force_repeated = 0  # forces equal to the one before
        self._until_ns: dict[str, int] = {}

    def clear(self) -> None:
        """End all faults: stamps went back. The counter stays."""
        self._until_ns.clear()

    def add_flags(self, flagged: int, stamp_ns: int) -> None:
        """Count and raise the faults that the flags of a raw sample stand for."""
        self.force_repeated += bool(flagged & SensorFlag.FORCE_REPEATED.value)
        for flag, text in FAULT_TEXTS.items():
            if flagged & flag.value:
                self.raise_fault(text, stamp_ns)

    def raise_fault(self, text: str, stamp_ns: int) -> None:
        """Activate a fault until FAULT_HOLD_TIME after `stamp_ns` [ns], and drop those that have ended."""
        self._until_ns = {other: until_ns for other, until_ns in self._until_ns.items() if stamp_ns < until_ns}
        self._until_ns[text] = min(stamp_ns + int(FAULT_HOLD_TIME * 1e9), MAX_STAMP_NS)

    @property
    def until_ns(self) -> int:
        """Stamp at which the last fault ends [ns]; 0 if there was none."""
        return max(self._until_ns.values(), default=0)

    @property
    def sensor_fault_until_ns(self) -> int:
        """Stamp at which the last fault of a sensor ends [ns]; 0 if there was none."""
        return max((until_ns for text, until_ns in self._until_ns.items() if text != DELAY), default=0)

    def active_faults(self, stamp_ns: int) -> list[str]:
        """Texts of the faults that are active at an instant [ns]."""
        return [text for text, until_ns in self._until_ns.items() if stamp_ns < until_ns]
