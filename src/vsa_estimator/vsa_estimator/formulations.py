# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The filter of the parameter `formulation`, and what both formulations offer."""

from typing import Protocol

from vsa_common.types import Array, Integers, ResetReason
from vsa_estimator.filter.records import Record
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.settings import EstimatorConfig


class TransmissionEstimator(Protocol):
    """Estimator of one transmission."""

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Estimate at a sample ([ns], [N], [m]); None if it was dropped."""
        ...

    def add_many(self, stamp_ns: Integers, force: Array, deflection: Array) -> Record:
        """`add` each sample of arrays (n,): (n,) ROW, NaN for dropped samples."""
        ...

    def count_lost(self, lost: int) -> None:
        """The driver counts the samples that are lost: `lost` since the last sample."""
        ...

    def finish_pending(self) -> bool:
        """Do one part of the deferred work of the last sample; whether there was any."""
        ...

    def state(self) -> State:
        """State and diagnostics."""
        ...

    def predict_to(self, stamp_ns: int) -> Estimate | None:
        """Estimate at an instant [ns] without a sample; None before the first sample."""
        ...

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Apply the tunable parameters of another configuration; the estimate stays."""
        ...

    def reset(self, reason: ResetReason = ResetReason.REQUESTED) -> None:
        """Drop all state but configuration and counters."""
        ...


def create_estimator(config: EstimatorConfig) -> TransmissionEstimator:
    """A new estimator of the configured formulation."""
    if config.formulation == "force_rate":
        from vsa_estimator.force_rate.estimator import ForceRateEstimator

        return ForceRateEstimator(config)
    from vsa_estimator.estimator import Estimator

    return Estimator(config)
