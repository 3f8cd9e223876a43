# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Active faults, each raised by sensor flags or by the supervisor and held for a time after; counters of resets."""

from dataclasses import dataclass

from vsa_common.types import ResetReason
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


@dataclass
class Counters:
    """Resets with the last reason, and rejected samples; they outlive a reset of the estimator."""

    resets: int = 0
    reset_reason: ResetReason = ResetReason.NONE
    force_rejected: int = 0
    deflection_rejected: int = 0

    @property
    def last_reset(self) -> tuple[int, ResetReason]:
        """Number and reason of the last reset."""
        return self.resets, self.reset_reason

    def count_reset(self, reason: ResetReason) -> None:
        """Count a reset."""
        self.resets += 1
        self.reset_reason = reason

    def count_rejected(self, force: bool = False, deflection: bool = False) -> None:
        """Count rejected samples of force and deflection."""
        self.force_rejected += force
        self.deflection_rejected += deflection


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
