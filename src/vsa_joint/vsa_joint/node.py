"""Node: the impedance of both transmissions in, the impedance of the joint out."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from operator import itemgetter
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from vsa_common.ros.cdr import Reader, Writer
from vsa_common.ros.node import ERROR, OK, RELIABLE, STALE, WARN, Health, SuiteNode
from vsa_common.ros.process import run
from vsa_common.ros.throttle import ThrottledPublisher
from vsa_common.stamps import NANOSECONDS
from vsa_common.types import Status
from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.springs import Range, Spring, Springs, learned_spring, reachable
from vsa_joint.impedance.fusion import JointEstimate, JointFusion
from vsa_joint.impedance.pairing import TransmissionEstimate
from vsa_joint.impedance.propagation import ImpedanceEstimate
from vsa_joint.impedance.tension import unloaded_force
from vsa_joint.settings import CONSISTENT, JointConfig
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance

RANGE_PERIOD_NS = 100_000_000
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
_LEVEL = {Status.VALID: OK, Status.STALE: STALE, Status.FAULT: ERROR}


class JointNode(SuiteNode[JointConfig]):
    """Publish `joint_impedance` for every pair of transmission estimates, and when they stop."""

    def __init__(self, name: str = "joint", namespace: str = "vsa") -> None:
        super().__init__(name, JointConfig, namespace)

    def start(self) -> None:
        self._fusion = JointFusion(self.config)
        self._joint = self.config.joint
        self._reflection = JointImpedance.CONSISTENT if self.config.reflection == CONSISTENT else JointImpedance.PAPER
        self._range = (0.0, 0.0, False)  # least and greatest stiffness within reach, and whether that is known
        self._reader = Reader(TransmissionImpedance.get_fields_and_field_types())
        self._reason = ""
        self._writer = Writer(JointImpedance())
        self._impedances = ThrottledPublisher(self, JointImpedance, "joint_impedance")
        self._states: list[bytes | None] = [None, None]
        self._motor_map, self._motors = MotorMap(self.config), b""
        self._range_ns = 0
        self._inputs = self.listen()
        self._inputs += [
            self.create_subscription(
                EstimatorState,
                f"transmission_{side + 1}/estimator_state",
                partial(self._on_state, side),
                RELIABLE,
                raw=True,
            )
            for side in (0, 1)
        ]
        self._inputs.append(self.create_subscription(JointState, "motor_states", self._on_motors, NEWEST, raw=True))
        self._watch = self.create_timer(self.config.status_period, self._on_watch, clock=self.steady)

    def listen(self) -> list[Subscription]:
        """Subscribe to both sides; whoever calls `take` overrides this."""
        return [
            self.create_subscription(
                TransmissionImpedance,
                f"transmission_{side + 1}/impedance",
                partial(self._on_side, side),
                RELIABLE,
                raw=True,
            )
            for side in (0, 1)
        ]

    def stop(self) -> None:
        self.destroy_timer(self._watch)
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        for publisher in self._impedances.publishers:
            self.destroy_publisher(publisher)

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

    def take(self, side: int, sample: TransmissionEstimate) -> None:
        """Pair one estimate of side 0 or 1, and publish where that makes a pair; nothing while inactive."""
        with self.lock:
            if not self.active:
                return
            estimate = self._fusion.add(side, sample, time.monotonic_ns())
            if estimate is not None:
                self._publish(estimate)

    def _on_side(self, side: int, data: bytes) -> None:
        self.take(side, side_of(*self._reader.read(data)))

    def _on_state(self, side: int, data: bytes) -> None:
        self._states[side] = data
        now_ns = time.monotonic_ns()
        if now_ns - self._range_ns > RANGE_PERIOD_NS:
            self._range_ns = now_ns
            self._find_range()

    def _on_motors(self, data: bytes) -> None:
        self._motors = data

    def _find_range(self) -> None:
        """Stiffness within reach at the present angle and load, into the message."""
        (first, second), newest, found = map(_spring, self._states), self._fusion.newest, None
        if first is not None and second is not None and newest.force_valid:
            found = self._within((first, second), newest)
        with self.lock:
            if found is None:
                self._range = (*self._range[:2], False)
            else:
                self._range = (found.stiffness_min, found.stiffness_max, True)

    def _within(self, springs: Springs, newest: JointEstimate) -> Range | None:
        """Stiffness within reach of springs, tendons and, where they are measured, motors."""
        torque = -newest.motion_torque
        found = reachable(torque, springs, self._joint, self.config)
        motors = list(deserialize_message(self._motors, JointState).position) if self._motors else []
        if found is None or len(motors) < len(springs):
            return found
        # the angle stays, so that the motors' zero may be that of a joint at zero
        force = unloaded_force(newest.tension, self.config.radius)
        self._motor_map.fit((motors[0], motors[1]), force, 0.0, springs)
        return self._motor_map.narrowed(found, torque, 0.0, springs)

    def _on_watch(self) -> None:
        with self.lock:
            estimate = self._fusion.check(time.monotonic_ns())
            if estimate is not None:
                self._range = (*self._range[:2], False)
                self._publish(estimate)

    def _publish(self, estimate: JointEstimate) -> None:
        if estimate.reason != self._reason:
            self._reason = estimate.reason
            self._writer = Writer(JointImpedance(reason=estimate.reason))
        data = self._writer.write(estimate.stamp_ns, self._row(estimate))
        self._impedances.publish(estimate.stamp_ns, data, (estimate.status, estimate.stiffness_valid))

    def _row(self, e: JointEstimate) -> tuple[float, ...]:
        """The numbers of a JointImpedance in the order of its fields."""
        first_ns, second_ns = e.transmission_stamp_ns
        return (
            *divmod(first_ns, NANOSECONDS), *divmod(second_ns, NANOSECONDS),
            e.stiffness, e.stiffness_variance, e.stiffness_valid, e.damping, e.damping_variance, e.damping_valid,
            e.inertia, e.inertia_variance, e.inertia_valid, e.valid_frequency, self._reflection,
            *e.tension, *e.tension_variance, e.tension_valid, e.internal_force, e.internal_force_variance,
            e.motion_torque, e.motion_torque_variance, e.co_contraction, e.co_contraction_variance, e.force_valid,
            *self._range, e.status, *e.transmission_status, e.reset_count, e.reset_reason,
        )  # fmt: skip


def _spring(state: bytes | None) -> Spring | None:
    if state is None:
        return None
    message = deserialize_message(state, EstimatorState)
    return learned_spring(message) if message.k2_valid else None


def side_of(stamp_ns: int, impedance: Sequence[float]) -> TransmissionEstimate:
    """What the fusion takes from the numbers of a TransmissionImpedance, in the order of its fields."""
    status = min(_STATUS(impedance), Status.FAULT)
    row = (
        stamp_ns,
        *_FORCE(impedance),
        ImpedanceEstimate(*_ROD(impedance)),
        *_VALID(impedance),
        status,
        *_RESET(impedance),
    )
    return TransmissionEstimate(*row)


def _places(*names: str) -> Callable[[Sequence[float]], Any]:
    fields = list(TransmissionImpedance.get_fields_and_field_types())[1:]
    return itemgetter(*(fields.index(name) for name in names))


_FORCE = _places("force", "force_variance", "force_valid")
_ROD = _places(
    "stiffness", "damping", "inertia", "stiffness_variance", "damping_variance", "inertia_variance",
    "stiffness_damping_covariance", "stiffness_inertia_covariance", "damping_inertia_covariance",
)  # fmt: skip
_VALID = _places("stiffness_valid", "damping_valid", "inertia_valid")
_STATUS = _places("status")
_RESET = _places("reset_count", "reset_reason")


def main() -> int:
    """Entry point."""
    return run(JointNode)
