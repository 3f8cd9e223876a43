"""Node: the impedance of both transmissions in, the impedance of the joint out."""

import time
from functools import partial
from typing import Any

from rclpy.subscription import Subscription
from vsa_common.node import ERROR, OK, RELIABLE, STALE, WARN, Health, SuiteNode, run
from vsa_common.stamps import nanoseconds, set_stamp
from vsa_joint.configuration import CONSISTENT, JointConfig
from vsa_joint.fusion import JointEstimate, JointFusion, Side
from vsa_joint.propagation import Rod
from vsa_joint.springs import Spring, learned_spring, reachable
from vsa_joint.status import Status
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance

RANGE_PERIOD_NS = 100_000_000
_LEVEL = {Status.VALID: OK, Status.STALE: STALE, Status.FAULT: ERROR}


class JointNode(SuiteNode[JointConfig]):
    """Publish `joint_impedance` for every pair of transmission estimates, and when they stop."""

    def __init__(self, name: str = "joint", namespace: str = "vsa") -> None:
        super().__init__(name, JointConfig, namespace)

    def start(self) -> None:
        self._fusion = JointFusion(self.config)
        self._joint = self.config.joint
        self._message = JointImpedance()
        self._message.reflection = (
            JointImpedance.CONSISTENT if self.config.reflection == CONSISTENT else JointImpedance.PAPER
        )
        self._publisher = self.create_publisher(JointImpedance, "joint_impedance", RELIABLE)
        self._springs: list[Spring | None] = [None, None]
        self._range_ns = 0
        self._inputs = self.listen()
        self._inputs += [
            self.create_subscription(
                EstimatorState, f"transmission_{side + 1}/estimator_state", partial(self._on_state, side), RELIABLE
            )
            for side in (0, 1)
        ]
        self._watch = self.create_timer(self.config.status_period, self._on_watch, clock=self.steady)

    def listen(self) -> list[Subscription]:
        """Subscribe to both sides; whoever calls `take` overrides this."""
        return [
            self.create_subscription(
                TransmissionImpedance, f"transmission_{side + 1}/impedance", partial(self._on_side, side), RELIABLE
            )
            for side in (0, 1)
        ]

    def stop(self) -> None:
        self.destroy_timer(self._watch)
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        self.destroy_publisher(self._publisher)

    def health(self) -> Health:
        if not self.active:
            return super().health()
        last, counts = self._fusion.newest, self._fusion.counts
        values: dict[str, object] = {
            "status": Status(last.status).name,
            "pairs": counts.pairs,
            "unpaired": counts.unpaired,
            "dropped": counts.dropped,
            "resets": last.reset_count,
            "valid_frequency_hz": f"{last.valid_frequency:.3g}",
        }
        level, message = _LEVEL.get(Status(last.status), WARN), last.reason or "active"
        if level == OK and last.maxwell_exceeds_mass:
            level = WARN
            message = (
                f"damper and tendon in series outweigh the rods' mass: inertia holds only below "
                f"{last.valid_frequency:.2g} Hz, use the response above"
            )
        return level, message, values

    def take(self, side: int, sample: Side) -> None:
        """Pair one estimate of side 0 or 1, and publish where that makes a pair; nothing while inactive."""
        with self.lock:
            if not self.active:
                return
            estimate = self._fusion.add(side, sample, time.monotonic_ns())
            if estimate is not None:
                self._publish(estimate)

    def _on_side(self, side: int, message: TransmissionImpedance) -> None:
        self.take(side, side_of(message, nanoseconds(message.header.stamp)))

    def _on_state(self, side: int, message: EstimatorState) -> None:
        self._springs[side] = learned_spring(message) if message.k2_valid else None
        now_ns = time.monotonic_ns()
        if now_ns - self._range_ns > RANGE_PERIOD_NS:
            self._range_ns = now_ns
            self._find_range()

    def _find_range(self) -> None:
        """Stiffness within reach under the present load, into the message."""
        (first, second), newest, found = self._springs, self._fusion.newest, None
        if first is not None and second is not None and newest.force_valid:
            found = reachable(-newest.motion_torque, (first, second), self._joint, self.config)
        with self.lock:
            self._message.stiffness_range_valid = found is not None
            if found is not None:
                self._message.stiffness_min, self._message.stiffness_max = found.stiffness_min, found.stiffness_max

    def _on_watch(self) -> None:
        with self.lock:
            estimate = self._fusion.check(time.monotonic_ns())
            if estimate is not None:
                self._message.stiffness_range_valid = False
                self._publish(estimate)

    def _publish(self, estimate: JointEstimate) -> None:
        fill(self._message, estimate)
        self._publisher.publish(self._message)


def side_of(message: Any, stamp_ns: int) -> Side:
    """What the fusion takes from a TransmissionImpedance, or from anything whose fields are named so."""
    return Side(
        stamp_ns,
        message.force,
        message.force_variance,
        message.force_valid,
        Rod(
            message.stiffness,
            message.damping,
            message.inertia,
            message.stiffness_variance,
            message.damping_variance,
            message.inertia_variance,
            message.stiffness_damping_covariance,
            message.stiffness_inertia_covariance,
            message.damping_inertia_covariance,
        ),
        message.stiffness_valid,
        message.damping_valid,
        message.inertia_valid,
        min(message.status, Status.FAULT),
        message.reset_count,
        message.reset_reason,
    )


def fill(message: JointImpedance, estimate: JointEstimate) -> None:
    """Write an estimate into a message that is used again for every pair."""
    set_stamp(message.header.stamp, estimate.stamp_ns)
    set_stamp(message.transmission_stamp[0], estimate.transmission_stamp_ns[0])
    set_stamp(message.transmission_stamp[1], estimate.transmission_stamp_ns[1])
    for name in _SAME:
        setattr(message, name, getattr(estimate, name))


_OTHERWISE = ("stamp_ns", "transmission_stamp_ns", "maxwell_exceeds_mass")
_SAME = tuple(name for name in JointEstimate.__dataclass_fields__ if name not in _OTHERWISE)


def main() -> int:
    """Entry point."""
    return run(JointNode)
