# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Node: stiffness commands and live estimates in, motor commands out; faults hold the motors."""

import time
from collections import defaultdict
from functools import partial
from typing import TypeVar

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.serialization import deserialize_message
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from vsa_common.ros.node import ERROR, OK, RELIABLE, STEADY, WARN, SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_common.stamps import StampMessage, nanoseconds
from vsa_common.types import Status
from vsa_joint.control.clock_offset import ClockOffset
from vsa_joint.control.identified_spring import identified_spring
from vsa_joint.control.mode import Mode
from vsa_joint.control.records import Inputs, JointMeasurement, Target
from vsa_joint.control.supervisor import Supervisor
from vsa_joint.settings import ControlConfig
from vsa_msgs.msg import EstimatorState, JointImpedance, StiffnessCommand

_T = TypeVar("_T")
CONTROL = "control"  # task of the diagnostics
REPEAT_NS = 1_000_000_000  # [ns] between two statuses of an unchanged mode that waits
_LEVEL = {Mode.IDLE: OK, Mode.ACTIVE: OK, Mode.HOLDING: ERROR, Mode.FEED_FORWARD: WARN, Mode.EXCITING: WARN}


class StiffnessControllerNode(SuiteNode[ControlConfig]):
    """Command both motors for the equilibrium angle and the stiffness of `stiffness_command`.

    The feasibility of each command, and each change of mode with its reason, are published on `~/status` immediately;
    a mode that waits is repeated once a second, with its duration.
    """

    def __init__(self) -> None:
        super().__init__("stiffness_controller", ControlConfig)

    def start(self) -> None:
        self._supervisor = Supervisor(self.config)
        self._inputs = Inputs()
        self._published_mode: tuple[Mode, str, str] | None = None
        self._published_ns = 0
        self._pending: dict[str, tuple[bytes, int]] = {}  # newest message of each topic, and its arrival [ns]
        self._offsets: defaultdict[str, ClockOffset] = defaultdict(ClockOffset)
        self._commands = self.create_publisher(JointState, "motor_commands", RELIABLE)
        self._status = self.create_publisher(DiagnosticStatus, "~/status", RELIABLE)
        self._message = JointState()  # names and frame_id are those of motor_states
        fast = ((JointImpedance, "joint_impedance"), (JointState, "joint_states"), (JointState, "motor_states"))
        self._inputs_subscribed = [
            self.create_subscription(kind, name, partial(self._on_raw, name), RELIABLE, raw=True) for kind, name in fast
        ]
        self._inputs_subscribed += [
            self.create_subscription(
                EstimatorState, f"transmission_{index + 1}/estimator_state", partial(self._on_state, index), RELIABLE
            )
            for index in (0, 1)
        ]
        self._inputs_subscribed.append(
            self.create_subscription(StiffnessCommand, "stiffness_command", self._on_command, RELIABLE)
        )
        self._timer = self._create_timer(self.config)

    def stop(self) -> None:
        self.destroy_timer(self._timer)
        for subscription in self._inputs_subscribed:
            self.destroy_subscription(subscription)
        self.destroy_publisher(self._commands)
        self.destroy_publisher(self._status)

    def reconfigure(self, config: ControlConfig) -> None:
        self._supervisor.reconfigure(config)
        self.destroy_timer(self._timer)
        self._timer = self._create_timer(config)

    def _create_timer(self, config: ControlConfig) -> Timer:
        return self.create_timer(1.0 / config.rate, self._on_timer, clock=STEADY)

    def health(self) -> Tasks:
        supervisor = self._supervisor
        values = self._mode_values() | {"refused": supervisor.refused}
        if supervisor.target is not None:
            values["stiffness"], values["equilibrium"] = supervisor.target.stiffness, supervisor.target.equilibrium
        feasibility = supervisor.feasibility
        if feasibility is not None:
            values["command_accepted"], values["command_reason"] = feasibility.accepted, feasibility.text
        if feasibility is not None and feasibility.reachable is not None:
            reachable = feasibility.reachable
            values["reachable"] = f"{reachable.stiffness_min:.3g} to {reachable.stiffness_max:.3g} N m/rad"
            values["predicted_error"] = f"{feasibility.predicted_error:.3g}"
        values["exciting"] = supervisor.control.exciting
        level, text = _LEVEL[supervisor.mode], supervisor.reason or supervisor.mode.name.lower()
        if level != OK:
            name, duration = values["mode"], values["mode_duration_s"]
            text = f"{name} for {duration} s: {text}; waits for {supervisor.waits_for}"
        if feasibility is not None and feasibility.text:  # the last command was refused, or accepted with a warning
            refusal = feasibility.text if feasibility.accepted else f"command refused: {feasibility.text}"
            level, text = max(level, WARN), refusal if level == OK else f"{text}; {refusal}"
        return {CONTROL: (level, text, values)}

    @property
    def tasks(self) -> tuple[str, ...]:
        return (CONTROL,)

    @property
    def activity(self) -> str:
        return f"motor commands at {self.config.rate:g} Hz after the first stiffness_command"

    def _on_raw(self, name: str, data: bytes) -> None:
        self._pending[name] = (data, time.monotonic_ns())

    def _on_state(self, index: int, message: EstimatorState) -> None:
        inputs = self._inputs
        self._record_stamp(f"transmission_{index + 1}/estimator_state", message.header.stamp)
        inputs.springs = _replaced(inputs.springs, index, identified_spring(message))
        inputs.springs_ns = _replaced(inputs.springs_ns, index, time.monotonic_ns())
        inputs.estimator_faults = _replaced(inputs.estimator_faults, index, message.reason)
        inputs.sensor_faults = _replaced(inputs.sensor_faults, index, message.sensor_fault)

    def _on_command(self, message: StiffnessCommand) -> None:
        self._decode_pending()
        target = Target(message.equilibrium_angle, message.stiffness)
        feasibility = self._supervisor.command(target, self._inputs, time.monotonic_ns())
        level = WARN if feasibility.text else OK
        self._publish_status(level, feasibility.text or "accepted", target, feasibility.accepted)

    def _on_timer(self) -> None:
        self._decode_pending()
        supervisor = self._supervisor
        motors = supervisor.step(self._inputs, time.monotonic_ns())
        if motors is not None:
            self._message.header.stamp = self.get_clock().now().to_msg()
            self._message.position = list(motors)
            self._commands.publish(self._message)
        mode, reason = supervisor.mode, supervisor.reason
        state, now_ns = (mode, reason, supervisor.waits_for), time.monotonic_ns()
        changed = state != self._published_mode
        if changed or (_LEVEL[mode] != OK and now_ns - self._published_ns >= REPEAT_NS):
            self._published_mode, self._published_ns = state, now_ns
            self._publish_status(_LEVEL[mode], reason or mode.name.lower())
        if changed:
            self.publish_health()

    def _mode_values(self) -> dict[str, object]:
        """Mode, its duration, its reason, and what it waits for."""
        supervisor = self._supervisor
        values: dict[str, object] = {
            "mode": supervisor.mode.name.lower(),
            "mode_duration_s": f"{supervisor.duration(time.monotonic_ns()):.1f}",
            "reason": supervisor.reason,
            "waits_for": supervisor.waits_for,
        }
        if supervisor.mode in (Mode.FEED_FORWARD, Mode.EXCITING):
            values["law_error"] = f"{supervisor.law_error:.3g}"
        return values

    def _decode_pending(self) -> None:
        """Decode the newest message of each topic since the previous call."""
        inputs = self._inputs
        for name, (data, arrival) in self._pending.items():
            if name == "joint_impedance":
                joint = deserialize_message(data, JointImpedance)
                self._record_stamp(name, joint.header.stamp)
                inputs.joint, inputs.joint_ns = _joint_measurement(joint), arrival
                continue
            state = deserialize_message(data, JointState)
            position = state.position
            self._record_stamp(name, state.header.stamp)
            if name == "joint_states" and len(position) >= 1:
                inputs.angle, inputs.angle_ns = position[0], arrival
            elif name == "motor_states" and len(position) >= 2:
                inputs.motors, inputs.motors_ns = (position[0], position[1]), arrival
                self._message.name, self._message.header.frame_id = state.name[:2], state.header.frame_id
        self._pending.clear()

    def _record_stamp(self, name: str, stamp: StampMessage) -> None:
        """Record the instant of measurement; a message without a stamp has the age of its arrival."""
        ros_ns, now_ns = self.get_clock().now().nanoseconds, time.monotonic_ns()
        instant = self._offsets[name].update(nanoseconds(stamp), ros_ns, now_ns)
        if instant is None:
            self._inputs.measured_ns.pop(name, None)
        else:
            self._inputs.measured_ns[name] = instant

    def _publish_status(self, level: int, text: str, target: Target | None = None, accepted: bool = True) -> None:
        supervisor = self._supervisor
        status = DiagnosticStatus(level=bytes([level]), name=self.get_fully_qualified_name(), message=text)
        values = {"stamp_ns": self.get_clock().now().nanoseconds} | self._mode_values()
        if target is not None:
            values |= {"stiffness": target.stiffness, "equilibrium_angle": target.equilibrium, "accepted": accepted}
        feasibility = supervisor.feasibility
        if feasibility is not None and feasibility.reachable is not None:
            reachable = feasibility.reachable
            values |= {"stiffness_min": reachable.stiffness_min, "stiffness_max": reachable.stiffness_max}
        status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        self._status.publish(status)


def _replaced(pair: tuple[_T, _T], index: int, value: _T) -> tuple[_T, _T]:
    return (value, pair[1]) if index == 0 else (pair[0], value)


def _joint_measurement(message: JointImpedance) -> JointMeasurement:
    return JointMeasurement(
        stiffness=message.stiffness,
        stiffness_valid=message.stiffness_valid,
        damping=message.damping,
        damping_valid=message.damping_valid,
        tension=(message.tension[0], message.tension[1]),
        force_valid=message.force_valid,
        status=min(message.status, max(Status)),
        reason=message.reason,
    )


def main() -> int:
    """Entry point."""
    return run(StiffnessControllerNode)
