"""Which filter estimates, chosen by the parameter `formulation`."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array, ResetReason
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.settings import EstimatorConfig


class TransmissionEstimator(Protocol):
    """What every formulation offers."""

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Take one paired sample in ([ns], [N], [m]); the estimate at its stamp, None where it was dropped."""
        ...

    def add_many(self, stamp_ns: NDArray[np.int64], force: Array, deflection: Array) -> Array:
        """As many samples at once; a row of `values.ROW` for each, NaN where it was dropped."""
        ...

    def finish_pending(self) -> bool:
        """Do now what the last sample has left to do; whether there was anything."""
        ...

    def state(self) -> State:
        """What is known and how it is doing."""
        ...

    def predict_to(self, stamp_ns: int) -> Estimate | None:
        """Estimate at an instant [ns] without a sample; None before the first sample."""
        ...

    def reset(self, reason: ResetReason = ResetReason.REQUESTED) -> None:
        """Forget everything but the configuration and the counters."""
        ...


def create_estimator(config: EstimatorConfig) -> TransmissionEstimator:
    """The estimator that `config` asks for, in its first state."""
    if config.formulation == "force_rate":
        from vsa_estimator.force_rate.estimator import ForceRateEstimator

        return ForceRateEstimator(config)
    from vsa_estimator.estimator import Estimator

    return Estimator(config)
