"""Two streams of transmission estimates in, one stream of joint estimates out. Instants of the steady clock come in."""

from dataclasses import dataclass
from math import isfinite
from typing import NamedTuple

from vsa_common.types import ResetReason, Status
from vsa_joint.impedance import tension as forces
from vsa_joint.impedance.pairing import Pairing, TransmissionEstimate
from vsa_joint.impedance.propagation import consistent_branch, paper_branch, reflect
from vsa_joint.settings import CONSISTENT, JointConfig

NANOSECONDS = 1e9
PERIODS = 5.0  # of silence before a side is stale


class JointEstimate(NamedTuple):
    """The joint at one instant, named as in JointImpedance.msg (SI)."""

    stamp_ns: int
    transmission_stamp_ns: tuple[int, int]
    stiffness: float = 0.0
    stiffness_variance: float = 0.0
    stiffness_valid: bool = False
    damping: float = 0.0
    damping_variance: float = 0.0
    damping_valid: bool = False
    inertia: float = 0.0
    inertia_variance: float = 0.0
    inertia_valid: bool = False
    valid_frequency: float = 0.0
    tension: tuple[float, float] = (0.0, 0.0)
    tension_variance: tuple[float, float] = (0.0, 0.0)
    tension_valid: bool = False
    internal_force: float = 0.0
    internal_force_variance: float = 0.0
    motion_torque: float = 0.0
    motion_torque_variance: float = 0.0
    co_contraction: float = 0.0
    co_contraction_variance: float = 0.0
    force_valid: bool = False
    status: int = Status.INITIALIZING
    transmission_status: tuple[int, int] = (Status.INITIALIZING, Status.INITIALIZING)
    reason: str = "no sample yet"
    reset_count: int = 0
    reset_reason: int = ResetReason.NONE
    maxwell_exceeds_mass: bool = False


@dataclass(frozen=True, slots=True)
class Counts:
    """What became of the samples of both sides."""

    pairs: int = 0
    unpaired: int = 0
    dropped: int = 0  # duplicate, late or not finite


class JointFusion:
    """Pairs both sides and reflects them to the joint."""

    def __init__(self, config: JointConfig) -> None:
        self._config = config
        self._joint, self._std = config.joint, config.std
        self._branch = consistent_branch if config.reflection == CONSISTENT else paper_branch
        self._pairing = Pairing(config.max_skew * NANOSECONDS)
        self._arrival_ns: list[int | None] = [None, None]
        self._emitted_ns = 0
        self._resets = (0, 0)
        self._last = JointEstimate(0, (0, 0))
        self._dropped = 0

    @property
    def counts(self) -> Counts:
        """Counters since the start."""
        return Counts(self._pairing.pairs, self._pairing.unpaired, self._dropped)

    @property
    def newest(self) -> JointEstimate:
        """The last estimate that went out."""
        return self._last

    def add(self, side: int, sample: TransmissionEstimate, now_ns: int) -> JointEstimate | None:
        """A sample of side 0 or 1, arrived at `now_ns` of a steady clock; an estimate where it completes a pair."""
        if not (_finite(sample) and self._pairing.take(side, sample)):
            self._dropped += 1
            return None
        self._arrival_ns[side] = now_ns
        pair = self._pairing.next()
        return None if pair is None else self._emit(*pair, now_ns)

    def check(self, now_ns: int) -> JointEstimate | None:
        """An invalid estimate when no pair came for too long, and why; call it every `status_period`."""
        timeout = max(self._config.stale_timeout * NANOSECONDS, PERIODS * self._pairing.period_ns)
        if self._pairing.pairs and now_ns - self._emitted_ns <= timeout:
            return None
        silent = [
            name
            for name, arrival in zip(("transmission_1", "transmission_2"), self._arrival_ns, strict=True)
            if arrival is None or now_ns - arrival > timeout
        ]
        if self._pairing.pairs or None not in self._arrival_ns:
            reason = f"{' and '.join(silent)} silent" if silent else "no stamps within max_skew of each other"
            status = Status.STALE
        else:
            reason, status = f"no sample yet of {' and '.join(silent) or 'either side'}", Status.INITIALIZING
        self._last = self._last._replace(
            stiffness_valid=False,
            damping_valid=False,
            inertia_valid=False,
            tension_valid=False,
            force_valid=False,
            status=status,
            reason=reason,
        )
        return self._last

    def _emit(self, first: TransmissionEstimate, second: TransmissionEstimate, now_ns: int) -> JointEstimate:
        self._emitted_ns = now_ns
        config = self._config
        reflected = reflect((first.rod, second.rod), self._joint, self._std, self._branch)
        tension = (0.5 * first.force, 0.5 * second.force)
        variance = (0.25 * first.force_variance, 0.25 * second.force_variance)
        parts = forces.split(tension, variance, config.radius, config.radius_std)
        status, reason = _status(first.status, second.status)
        usable = status not in (Status.INITIALIZING, Status.STALE, Status.FAULT)
        stiffness_valid = usable and first.stiffness_valid and second.stiffness_valid
        damping_valid = stiffness_valid and first.damping_valid and second.damping_valid
        force_valid = first.force_valid and second.force_valid
        self._last = JointEstimate(
            max(first.stamp_ns, second.stamp_ns),
            (first.stamp_ns, second.stamp_ns),
            reflected.stiffness,
            reflected.stiffness_variance,
            stiffness_valid,
            reflected.damping,
            reflected.damping_variance,
            damping_valid,
            reflected.inertia,
            reflected.inertia_variance,
            damping_valid and first.inertia_valid and second.inertia_valid,
            reflected.valid_frequency,
            tension,
            variance,
            force_valid,
            parts.internal_force,
            parts.internal_force_variance,
            parts.motion_torque,
            parts.motion_torque_variance,
            parts.co_contraction,
            parts.co_contraction_variance,
            force_valid,
            status,
            (first.status, second.status),
            reason,
            first.reset_count + second.reset_count,
            self._reset_reason(first, second),
            reflected.maxwell_term > reflected.mass_term,
        )
        return self._last

    def _reset_reason(self, first: TransmissionEstimate, second: TransmissionEstimate) -> int:
        """Reason of the reset that came last."""
        before, self._resets = self._resets, (first.reset_count, second.reset_count)
        for side, count in ((first, before[0]), (second, before[1])):
            if side.reset_count != count:
                return side.reset_reason
        return self._last.reset_reason


def _finite(sample: TransmissionEstimate) -> bool:
    rod = sample.rod
    total = rod.stiffness + rod.damping + rod.inertia + sample.force + sample.force_variance
    total += rod.stiffness_variance + rod.damping_variance + rod.inertia_variance
    total += rod.stiffness_damping_covariance + rod.stiffness_inertia_covariance + rod.damping_inertia_covariance
    return isfinite(total)


def _status(first: int, second: int) -> tuple[int, str]:
    """The joint is as well as its worse side; and why it is not well."""
    if first == second == Status.VALID:
        return Status.VALID, ""
    order = (Status.VALID, Status.DEGRADED, Status.CONVERGING, Status.INITIALIZING, Status.STALE, Status.FAULT)
    worse = max(first, second, key=order.index)
    parts = [
        f"transmission_{number} {Status(status).name}"
        for number, status in ((1, first), (2, second))
        if status != Status.VALID
    ]
    return worse, ", ".join(parts)
