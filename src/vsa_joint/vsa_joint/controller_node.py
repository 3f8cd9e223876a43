"""Node: stiffness commands and live estimates in, motor commands out; safe when anything stops."""

import time
from collections import defaultdict
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from vsa_common.ros.node import ERROR, OK, RELIABLE, STEADY, WARN, Health, SuiteNode
from vsa_common.ros.process import run
from vsa_common.stamps import StampMessage, nanoseconds
from vsa_joint.control.clock_offset import StampAge
from vsa_joint.control.controller import Target
from vsa_joint.control.springs import learned_spring
from vsa_joint.control.supervisor import Inputs, JointMeasurement, Mode, Supervisor
from vsa_joint.settings import ControlConfig
from vsa_msgs.msg import EstimatorState, JointImpedance, StiffnessCommand

_LEVEL = {Mode.IDLE: OK, Mode.ACTIVE: OK, Mode.HOLDING: ERROR}


class StiffnessControllerNode(SuiteNode[ControlConfig]):
    """Command both motors so that the joint rests where, and is as stiff as, `stiffness_command` says.

    Each command's verdict, and each hold with its reason, goes out on `~/status` at once.
    """

    def __init__(self) -> None:
        super().__init__("stiffness_controller", ControlConfig)

    def start(self) -> None:
        self._supervisor = Supervisor(self.config)
        self._inputs = Inputs()
        self._told: tuple[Mode, str] | None = None
        self._raw: dict[str, tuple[bytes, int]] = {}
        self._ages: defaultdict[str, StampAge] = defaultdict(StampAge)
        self._commands = self.create_publisher(JointState, "motor_commands", RELIABLE)
        self._status = self.create_publisher(DiagnosticStatus, "~/status", RELIABLE)
        self._message = JointState(name=["motor_1", "motor_2"])
        fast = ((JointImpedance, "joint_impedance"), (JointState, "joint_states"), (JointState, "motor_states"))
        self._subscriptions_made = [
            self.create_subscription(kind, name, partial(self._keep, name), RELIABLE, raw=True) for kind, name in fast
        ]
        self._subscriptions_made += [
            self.create_subscription(
                EstimatorState, f"transmission_{side + 1}/estimator_state", partial(self._on_state, side), RELIABLE
            )
            for side in (0, 1)
        ]
        self._subscriptions_made.append(
            self.create_subscription(StiffnessCommand, "stiffness_command", self._on_command, RELIABLE)
        )
        self._ticks = self.create_timer(1.0 / self.config.rate, self._on_tick, clock=STEADY)

    def stop(self) -> None:
        self.destroy_timer(self._ticks)
        for subscription in self._subscriptions_made:
            self.destroy_subscription(subscription)
        self.destroy_publisher(self._commands)
        self.destroy_publisher(self._status)

    def health(self) -> Health:
        if not self.active:
            return super().health()
        supervisor = self._supervisor
        values: dict[str, object] = {"mode": supervisor.mode.value, "refused": supervisor.refused}
        if supervisor.target is not None:
            values["stiffness"], values["equilibrium"] = supervisor.target.stiffness, supervisor.target.equilibrium
        judgement = supervisor.judgement
        if judgement is not None and judgement.within is not None:
            within = judgement.within
            values["reachable"] = f"{within.stiffness_min:.3g} to {within.stiffness_max:.3g} N m/rad"
            values["predicted_error"] = f"{judgement.predicted_error:.3g}"
        values["exciting"] = supervisor.control.exciting
        level = _LEVEL[supervisor.mode]
        return WARN if level == OK and supervisor.reason else level, supervisor.reason or "active", values

    def _keep(self, name: str, data: bytes) -> None:
        self._raw[name] = (data, time.monotonic_ns())

    def _stamped(self, name: str, stamp: StampMessage) -> None:
        """Note when a message was measured, by its stamp; one without a stamp is as old as its arrival."""
        ros_ns, now_ns = self.get_clock().now().nanoseconds, time.monotonic_ns()
        instant = self._ages[name].steady(nanoseconds(stamp), ros_ns, now_ns)
        if instant is None:
            self._inputs.measured_ns.pop(name, None)
        else:
            self._inputs.measured_ns[name] = instant

    def _on_state(self, side: int, message: EstimatorState) -> None:
        self._stamped(f"transmission_{side + 1}/estimator_state", message.header.stamp)
        springs, arrivals = list(self._inputs.springs), list(self._inputs.springs_ns)
        springs[side], arrivals[side] = learned_spring(message), time.monotonic_ns()
        complaints = list(self._inputs.complaints)
        complaints[side] = message.reason
        self._inputs.springs, self._inputs.springs_ns = (springs[0], springs[1]), (arrivals[0], arrivals[1])
        self._inputs.complaints = (complaints[0], complaints[1])

    def _on_command(self, message: StiffnessCommand) -> None:
        self._read()
        target = Target(message.equilibrium_angle, message.stiffness)
        judgement = self._supervisor.command(target, self._inputs, time.monotonic_ns())
        self._tell(WARN if judgement.text else OK, judgement.text or "accepted", target, judgement.accepted)

    def _on_tick(self) -> None:
        self._read()
        supervisor = self._supervisor
        motors = supervisor.step(self._inputs, time.monotonic_ns())
        if motors is not None:
            self._message.header.stamp = self.get_clock().now().to_msg()
            self._message.position = list(motors)
            self._commands.publish(self._message)
        now = (supervisor.mode, supervisor.reason)
        if now != self._told:
            changed, self._told = self._told is None or self._told[0] is not now[0], now
            self._tell(_LEVEL[now[0]], now[1] or now[0].value)
            if changed and now[0] is Mode.HOLDING:
                self.get_logger().error(f"motors held: {now[1]}", throttle_duration_sec=1.0)

    def _read(self) -> None:
        """Decode what came since the last time, the newest of each only."""
        inputs = self._inputs
        for name, (data, arrival) in self._raw.items():
            if name == "joint_impedance":
                joint = deserialize_message(data, JointImpedance)
                self._stamped(name, joint.header.stamp)
                inputs.joint, inputs.joint_ns = _joint_now(joint), arrival
                continue
            state = deserialize_message(data, JointState)
            position = state.position
            self._stamped(name, state.header.stamp)
            if name == "joint_states" and len(position) >= 1:
                inputs.angle, inputs.angle_ns = position[0], arrival
            elif name == "motor_states" and len(position) >= 2:
                inputs.motors, inputs.motors_ns = (position[0], position[1]), arrival
        self._raw.clear()

    def _tell(self, level: int, text: str, target: Target | None = None, accepted: bool = True) -> None:
        supervisor = self._supervisor
        status = DiagnosticStatus(level=bytes([level]), name=self.get_fully_qualified_name(), message=text)
        values: dict[str, object] = {"stamp_ns": self.get_clock().now().nanoseconds, "mode": supervisor.mode.value}
        if target is not None:
            values |= {"stiffness": target.stiffness, "equilibrium_angle": target.equilibrium, "accepted": accepted}
        if supervisor.judgement is not None and supervisor.judgement.within is not None:
            within = supervisor.judgement.within
            values |= {"stiffness_min": within.stiffness_min, "stiffness_max": within.stiffness_max}
        status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        self._status.publish(status)


def _joint_now(message: JointImpedance) -> JointMeasurement:
    return JointMeasurement(
        message.stiffness,
        message.stiffness_valid,
        message.damping,
        message.damping_valid,
        (message.tension[0], message.tension[1]),
        message.force_valid,
        min(message.status, 5),
        message.reason,
    )


def main() -> int:
    """Entry point."""
    return run(StiffnessControllerNode)
