# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Fusion of two streams of transmission estimates into one stream of joint estimates; `now_ns` is of a steady clock."""

from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple

from vsa_common.stamps import NANOSECONDS
from vsa_common.types import ResetReason, Status
from vsa_joint.impedance import tension as tendon_tension
from vsa_joint.impedance.pairing import Pairing, TransmissionEstimate
from vsa_joint.impedance.propagation import consistent_branch, paper_branch, reflect_to_joint
from vsa_joint.settings import CONSISTENT, JointConfig
from vsa_joint.tuning import STALE_PERIODS

SEVERITY = (
    Status.VALID, Status.MODEL_INADEQUATE, Status.DEGRADED, Status.CONVERGING, Status.INITIALIZING, Status.STALE,
    Status.FAULT,
)  # fmt: skip


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
    """Counters of the samples of both transmissions."""

    pairs: int = 0
    unpaired: int = 0
    dropped: int = 0  # duplicate, late or not finite


class JointFusion:
    """Pairs the samples of both transmissions and reflects them to the joint."""

    def __init__(self, config: JointConfig) -> None:
        self._config = config
        self._joint, self._std = config.joint, config.std
        self._branch = consistent_branch if config.reflection == CONSISTENT else paper_branch
        self._pairing = Pairing(config.max_skew * NANOSECONDS)
        self._arrival_ns: list[int | None] = [None, None]
        self._paired_ns = 0
        self._reset_counts = (0, 0)
        self._newest = JointEstimate(0, (0, 0))
        self._dropped = 0

    def reconfigure(self, config: JointConfig) -> None:
        """Apply the tunable parameters of another configuration."""
        self._config = config
        self._pairing.set_max_skew(config.max_skew * NANOSECONDS)

    @property
    def counts(self) -> Counts:
        """Counters since the start."""
        return Counts(self._pairing.pairs, self._pairing.unpaired, self._dropped)

    @property
    def newest(self) -> JointEstimate:
        """The newest estimate."""
        return self._newest

    def add(self, index: int, sample: TransmissionEstimate, now_ns: int) -> JointEstimate | None:
        """Add a sample of transmission `index` (0, 1) that arrived at `now_ns`; an estimate if it completes a pair."""
        if not (_is_finite(sample) and self._pairing.add(index, sample)):
            self._dropped += 1
            return None
        self._arrival_ns[index] = now_ns
        pair = self._pairing.pop_pair()
        return None if pair is None else self._update(*pair, now_ns)

    def check(self, now_ns: int) -> JointEstimate | None:
        """Invalidate the estimate after the stale timeout; the invalid estimate with its reason, or None."""
        period = self._pairing.period_ns
        timeout = max(self._config.stale_timeout * NANOSECONDS, STALE_PERIODS * period)
        if self._pairing.pairs and now_ns - self._paired_ns <= timeout:
            return None
        silent = [
            name
            for name, arrival in zip(("transmission_1", "transmission_2"), self._arrival_ns, strict=True)
            if arrival is None or now_ns - arrival > timeout - period  # its last sample may follow the last pair
        ]
        if self._pairing.pairs or None not in self._arrival_ns:
            reason = f"{' and '.join(silent)} silent" if silent else "no stamps within max_skew of each other"
            status = Status.STALE
        else:
            reason, status = f"no sample yet of {' and '.join(silent)}", Status.INITIALIZING
        self._newest = self._newest._replace(
            stiffness_valid=False,
            damping_valid=False,
            inertia_valid=False,
            tension_valid=False,
            force_valid=False,
            status=status,
            reason=reason,
        )
        return self._newest

    def _update(self, first: TransmissionEstimate, second: TransmissionEstimate, now_ns: int) -> JointEstimate:
        self._paired_ns = now_ns
        status, reason = _status(first.status, second.status)
        usable = status not in (Status.INITIALIZING, Status.STALE, Status.FAULT)
        stiffness_valid = usable and first.stiffness_valid and second.stiffness_valid
        damping_valid = stiffness_valid and first.damping_valid and second.damping_valid
        reset_reason = self._update_reset_reason(first, second)
        joint = reflect_to_joint((first.impedance, second.impedance), self._joint, self._std, self._branch)
        self._newest = JointEstimate(
            stamp_ns=max(first.stamp_ns, second.stamp_ns),
            transmission_stamp_ns=(first.stamp_ns, second.stamp_ns),
            stiffness=joint.stiffness,
            stiffness_variance=joint.stiffness_variance,
            stiffness_valid=stiffness_valid,
            damping=joint.damping,
            damping_variance=joint.damping_variance,
            damping_valid=damping_valid,
            inertia=joint.inertia,
            inertia_variance=joint.inertia_variance,
            inertia_valid=damping_valid and first.inertia_valid and second.inertia_valid,
            valid_frequency=joint.valid_frequency,
            status=status,
            transmission_status=(first.status, second.status),
            reason=reason,
            reset_count=first.reset_count + second.reset_count,
            reset_reason=reset_reason,
            maxwell_exceeds_mass=joint.maxwell_term > joint.mass_term,
            **self._tensions(first, second),
        )
        return self._newest

    def _tensions(self, first: TransmissionEstimate, second: TransmissionEstimate) -> dict[str, Any]:
        """Fields of JointEstimate that follow from the forces alone."""
        tension = (0.5 * first.force, 0.5 * second.force)  # F = 2 T
        variance = (0.25 * first.force_variance, 0.25 * second.force_variance)
        valid = first.force_valid and second.force_valid
        parts = tendon_tension.split(tension, variance, self._config.radius, self._config.radius_std)
        return {
            "tension": tension,
            "tension_variance": variance,
            "tension_valid": valid,
            "force_valid": valid,
            **parts._asdict(),
        }

    def _update_reset_reason(self, first: TransmissionEstimate, second: TransmissionEstimate) -> int:
        """Reason of the most recent reset."""
        before, self._reset_counts = self._reset_counts, (first.reset_count, second.reset_count)
        for sample, count in ((first, before[0]), (second, before[1])):
            if sample.reset_count != count:
                return sample.reset_reason
        return self._newest.reset_reason


def _is_finite(sample: TransmissionEstimate) -> bool:
    return isfinite(sum(sample.impedance) + sample.force + sample.force_variance)


def _status(first: int, second: int) -> tuple[int, str]:
    """The more severe status of both transmissions, with the reason."""
    if first == second == Status.VALID:
        return Status.VALID, ""
    parts = [
        f"transmission_{number} {Status(status).name}"
        for number, status in ((1, first), (2, second))
        if status != Status.VALID
    ]
    return max(first, second, key=SEVERITY.index), ", ".join(parts)
