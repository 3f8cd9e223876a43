# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Counters that outlive a reset of the estimator."""

from dataclasses import dataclass

from vsa_common.types import ResetReason


@dataclass
class Counters:
    """Resets with the last reason, and rejected samples."""

    resets: int = 0
    reset_reason: ResetReason = ResetReason.NONE
    force_rejected: int = 0
    deflection_rejected: int = 0

    def count_reset(self, reason: ResetReason) -> None:
        """Count a reset."""
        self.resets += 1
        self.reset_reason = reason

    def count_rejected(self, force: bool = False, deflection: bool = False) -> None:
        """Count rejected samples of force and deflection."""
        self.force_rejected += force
        self.deflection_rejected += deflection
