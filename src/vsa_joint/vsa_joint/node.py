# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Node: impedance of both transmissions in, impedance of the joint out."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from operator import itemgetter
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from vsa_common.ros.cdr import Reader, Writer
from vsa_common.ros.node import ERROR, OK, RELIABLE, WARN, SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_common.ros.throttle import ThrottledPublisher
from vsa_common.stamps import NANOSECONDS
from vsa_common.types import Status
from vsa_joint.control.identified_spring import identified_spring
from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.springs import Spring, Springs
from vsa_joint.control.stiffness_range import StiffnessRange, reachable_range
from vsa_joint.impedance.fusion import JointEstimate, JointFusion
from vsa_joint.impedance.pairing import TransmissionEstimate
from vsa_joint.impedance.propagation import ImpedanceEstimate
from vsa_joint.impedance.tension import unloaded_force
from vsa_joint.settings import CONSISTENT, PAPER, JointConfig
from vsa_joint.tuning import MEASUREMENT_TIMEOUT_NS, RANGE_PERIOD_NS
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance

IMPEDANCE = "impedance"  # task of the diagnostics
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
_REFLECTION = {CONSISTENT: JointImpedance.REFLECTION_CONSISTENT, PAPER: JointImpedance.REFLECTION_PAPER}
_LEVEL = {Status.VALID: OK, Status.STALE: ERROR, Status.FAULT: ERROR}


class JointNode(SuiteNode[JointConfig]):
    """Publish `joint_impedance` for every pair of transmission estimates, and an invalid one at a timeout."""

    def __init__(self, name: str = "joint", namespace: str = "vsa") -> None:
        super().__init__(name, JointConfig, namespace)

    def start(self) -> None:
        self._fusion = JointFusion(self.config)
        self._joint = self.config.joint
        self._reflection = _REFLECTION[self.config.reflection]
        self._range = (0.0, 0.0, False)  # reachable stiffness [N m/rad]: least, greatest, validity
        self._reader = Reader(TransmissionImpedance.get_fields_and_field_types())
        self._header = Header(frame_id=self.config.frame_prefix + self.config.joint_name)
        self._writer_reason = ""
        self._writer = Writer(JointImpedance(header=self._header))
        self._impedances = ThrottledPublisher(self, JointImpedance, "joint_impedance")
        self._states: list[bytes | None] = [None, None]
        self._motor_map, self._motors, self._motors_ns = MotorMap(self.config), b"", 0
        self._range_ns = 0
        self._inputs = self.listen()
        self._inputs += [
            self.create_subscription(
                EstimatorState,
                f"transmission_{index + 1}/estimator_state",
                partial(self._on_state, index),
                RELIABLE,
                raw=True,
            )
            for index in (0, 1)
        ]
        self._inputs.append(self.create_subscription(JointState, "motor_states", self._on_motors, NEWEST, raw=True))
        self._timeout_timer = self._create_timer(self.config)

    def listen(self) -> list[Subscription]:
        """Subscribe to both transmissions; a subclass that calls `take` directly overrides this."""
        return [
            self.create_subscription(
                TransmissionImpedance,
                f"transmission_{index + 1}/impedance",
                partial(self._on_impedance, index),
                RELIABLE,
                raw=True,
            )
            for index in (0, 1)
        ]

    def stop(self) -> None:
        self.destroy_timer(self._timeout_timer)
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        for publisher in self._impedances.publishers:
            self.destroy_publisher(publisher)

    def reconfigure(self, config: JointConfig) -> None:
        self._fusion.reconfigure(config)
        self._motor_map = MotorMap(config)
        self.destroy_timer(self._timeout_timer)
        self._timeout_timer = self._create_timer(config)

    def _create_timer(self, config: JointConfig) -> Timer:
        return self.create_timer(config.status_period, self._on_timeout_check, clock=self.steady)

    def health(self) -> Tasks:
        last, counts = self._fusion.newest, self._fusion.counts
        values: dict[str, object] = {
            "status": Status(last.status).name,
            "pairs": counts.pairs,
            "unpaired": counts.unpaired,
            "dropped": counts.dropped,
            "resets": last.reset_count,
            "valid_frequency_hz": f"{last.valid_frequency:.3g}",
        }
        text = last.reason or "active"
        if last.maxwell_exceeds_mass and not last.reason:  # a property of the rig, no fault
            text = (
                f"active; the Maxwell term of damper and tendon exceeds the mass term: inertia valid only below "
                f"{last.valid_frequency:.2g} Hz, use the frequency response above"
            )
        return {IMPEDANCE: (_LEVEL.get(Status(last.status), WARN), text, values)}

    @property
    def tasks(self) -> tuple[str, ...]:
        return (IMPEDANCE,)

    @property
    def activity(self) -> str:
        return f"transmission_1 and transmission_2, reflection {self.config.reflection}"

    def take(self, index: int, sample: TransmissionEstimate) -> None:
        """Add an estimate of transmission `index` (0, 1); publish if it completes a pair. No effect while inactive."""
        with self.lock:
            if not self.active:
                return
            estimate = self._fusion.add(index, sample, time.monotonic_ns())
            if estimate is not None:
                self._publish(estimate)

    def _on_impedance(self, index: int, data: bytes) -> None:
        self.take(index, transmission_estimate(*self._reader.read(data)))

    def _on_state(self, index: int, data: bytes) -> None:
        self._states[index] = data
        now_ns = time.monotonic_ns()
        if now_ns - self._range_ns > RANGE_PERIOD_NS:
            self._range_ns = now_ns
            self._update_range()

    def _on_motors(self, data: bytes) -> None:
        self._motors, self._motors_ns = data, time.monotonic_ns()

    def _on_timeout_check(self) -> None:
        with self.lock:
            estimate = self._fusion.check(time.monotonic_ns())
            if estimate is not None:
                self._range = (*self._range[:2], False)
                self._publish(estimate)

    def _update_range(self) -> None:
        """Reachable stiffness at the present angle and load, for the message."""
        (first, second), newest, reachable = map(_spring, self._states), self._fusion.newest, None
        if first is not None and second is not None and newest.force_valid:
            reachable = self._reachable((first, second), newest)
        with self.lock:
            if reachable is None:
                self._range = (*self._range[:2], False)
            else:
                self._range = (reachable.stiffness_min, reachable.stiffness_max, True)

    def _reachable(self, springs: Springs, newest: JointEstimate) -> StiffnessRange | None:
        """Reachable stiffness by the limits of springs, tendons and, where they are measured, motors.

        None while measured motors are silent.
        """
        torque = -newest.motion_torque
        reachable = reachable_range(torque, springs, self._joint, self.config)
        motors = list(deserialize_message(self._motors, JointState).position) if self._motors else []
        if reachable is None or len(motors) < len(springs):
            return reachable
        if time.monotonic_ns() - self._motors_ns > MEASUREMENT_TIMEOUT_NS:
            return None
        # at the present angle, so that zero is a valid reference of the angle
        force = unloaded_force(newest.tension, self.config.radius)
        self._motor_map.fit_zero((motors[0], motors[1]), force, 0.0, springs)
        return self._motor_map.clip_to_motors(reachable, torque, 0.0, springs)

    def _publish(self, estimate: JointEstimate) -> None:
        if estimate.reason != self._writer_reason:
            self._writer_reason = estimate.reason
            self._writer = Writer(JointImpedance(header=self._header, reason=estimate.reason))
        data = self._writer.write(estimate.stamp_ns, self._row(estimate))
        self._impedances.publish(estimate.stamp_ns, data, (estimate.status, estimate.stiffness_valid))

    def _row(self, e: JointEstimate) -> tuple[float, ...]:
        """Numeric fields of a JointImpedance in their order."""
        first_ns, second_ns = e.transmission_stamp_ns
        return (
            *divmod(first_ns, NANOSECONDS), *divmod(second_ns, NANOSECONDS),
            e.stiffness, e.stiffness_variance, e.stiffness_valid, e.damping, e.damping_variance, e.damping_valid,
            e.inertia, e.inertia_variance, e.inertia_valid, e.valid_frequency, self._reflection,
            *e.tension, *e.tension_variance, e.tension_valid, e.internal_force, e.internal_force_variance,
            e.motion_torque, e.motion_torque_variance, e.co_contraction, e.co_contraction_variance, e.force_valid,
            *self._range, e.status, *e.transmission_status, e.reset_count, e.reset_reason,
        )  # fmt: skip


def transmission_estimate(stamp_ns: int, fields: Sequence[float]) -> TransmissionEstimate:
    """Input of the fusion from the numeric fields of a TransmissionImpedance, in their order."""
    force, force_variance, force_valid = _FORCE(fields)
    stiffness_valid, damping_valid, inertia_valid = _VALID(fields)
    reset_count, reset_reason = _RESET(fields)
    return TransmissionEstimate(
        stamp_ns=stamp_ns,
        force=force,
        force_variance=force_variance,
        force_valid=force_valid,
        impedance=ImpedanceEstimate(*_IMPEDANCE(fields)),
        stiffness_valid=stiffness_valid,
        damping_valid=damping_valid,
        inertia_valid=inertia_valid,
        status=min(_STATUS(fields), max(Status)),
        reset_count=reset_count,
        reset_reason=reset_reason,
    )


def _spring(state: bytes | None) -> Spring | None:
    if state is None:
        return None
    message = deserialize_message(state, EstimatorState)
    by_knots = len(message.elastic_deflection) > 2 and message.elastic_law_valid
    return identified_spring(message) if message.k2_valid or by_knots else None


def _getter(*names: str) -> Callable[[Sequence[float]], Any]:
    fields = list(TransmissionImpedance.get_fields_and_field_types())[1:]
    return itemgetter(*(fields.index(name) for name in names))


_FORCE = _getter("force", "force_variance", "force_valid")
_IMPEDANCE = _getter(*ImpedanceEstimate._fields)
_VALID = _getter("stiffness_valid", "damping_valid", "inertia_valid")
_STATUS = _getter("status")
_RESET = _getter("reset_count", "reset_reason")


def main() -> int:
    """Entry point."""
    return run(JointNode)
