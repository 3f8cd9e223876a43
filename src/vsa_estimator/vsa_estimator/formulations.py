"""Which filter estimates, chosen by the parameter `formulation`."""

from typing import Protocol

from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.values import Estimate, Reset, State


class TransmissionEstimator(Protocol):
    """What every formulation offers."""

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Take one paired sample in ([ns], [N], [m]); the estimate at its stamp, None where it was dropped."""
        ...

    def state(self) -> State:
        """What is known and how it is doing."""
        ...

    def coast(self, stamp_ns: int) -> Estimate | None:
        """Estimate at an instant [ns] without a sample; None before the first sample."""
        ...

    def reset(self, reason: Reset = Reset.REQUESTED) -> None:
        """Forget everything but the configuration and the counters."""
        ...


def create_estimator(config: EstimatorConfig) -> TransmissionEstimator:
    """The estimator that `config` asks for, in its first state."""
    if config.formulation == "force_rate":
        from vsa_estimator.force_rate import ForceRateEstimator

        return ForceRateEstimator(config)
    from vsa_estimator.estimator import Estimator

    return Estimator(config)
