# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Node: the action Excite. Moves the motors until the wanted quantities of both transmissions are known."""

import time
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.serialization import deserialize_message
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from vsa_common.ros.node import OK, RELIABLE, STEADY, SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_common.stamps import nanoseconds
from vsa_joint.excitation.design import Design, choose_motion
from vsa_joint.excitation.inputs import Inputs, measure
from vsa_joint.excitation.procedure import ExcitationRefused, Procedure
from vsa_joint.excitation.sample_rate import SampleRate
from vsa_joint.excitation.settings import ExcitationConfig
from vsa_joint.excitation.tuning import FEEDBACK_PERIOD_NS, OWN_COMMANDS, START_TIMEOUT_NS, YIELD_NS
from vsa_joint.excitation_messages import goal_of, message_of
from vsa_msgs.action import Excite
from vsa_msgs.msg import EstimatorState, TransmissionImpedance

EXCITATION = "excitation"  # task of the diagnostics


class ExcitationNode(SuiteNode[ExcitationConfig]):
    """Action server of `~/excite`: co-contraction of both transmissions along D-optimal motions.

    One goal at a time; refused while another node, such as the stiffness controller, commands the motors.
    """

    def __init__(self) -> None:
        super().__init__("excitation", ExcitationConfig)

    def start(self) -> None:
        self._inputs, self._rates = Inputs(), (SampleRate(), SampleRate())
        self._goal: Any = None  # handle of the goal in work
        self._goal_ns = self._feedback_ns = 0
        self._procedure: Procedure | None = None
        self._design: Future[Design] | None = None
        self._pool = ThreadPoolExecutor(1, "design")
        self._own_stamps: deque[int] = deque(maxlen=OWN_COMMANDS)  # of commands whose echo is to come
        self._foreign_ns: int | None = None  # last motor command of another node
        self._message = JointState()  # names and frame_id are those of motor_states
        self._motor_states: bytes | None = None  # newest message
        self._commands = self.create_publisher(JointState, "motor_commands", RELIABLE)
        subscribe = partial(self.create_subscription, qos_profile=RELIABLE)
        self._subscriptions_of_run = [
            subscribe(JointState, "motor_states", self._on_motors, raw=True),
            subscribe(JointState, "motor_commands", self._on_command),
            subscribe(JointState, "joint_states_throttle", self._on_angle),
        ]
        for index in (0, 1):
            name, on_impedance = f"transmission_{index + 1}", partial(self._on_impedance, index)
            self._subscriptions_of_run += [
                subscribe(TransmissionImpedance, f"{name}/impedance_throttle", on_impedance),
                subscribe(EstimatorState, f"{name}/estimator_state", partial(self._on_state, index)),
            ]
        self._server = ActionServer(
            self, Excite, "~/excite", execute_callback=lambda _: Excite.Result(),
            handle_accepted_callback=self._on_goal, cancel_callback=lambda _: CancelResponse.ACCEPT,
        )  # fmt: skip
        self._timer = self._create_timer(self.config)

    def stop(self) -> None:
        self.destroy_timer(self._timer)
        self._server.destroy()
        self._pool.shutdown(wait=False, cancel_futures=True)
        for subscription in self._subscriptions_of_run:
            self.destroy_subscription(subscription)
        self.destroy_publisher(self._commands)

    def reconfigure(self, config: ExcitationConfig) -> None:
        self.destroy_timer(self._timer)
        self._timer = self._create_timer(config)

    def health(self) -> Tasks:
        procedure = self._procedure
        if procedure is None:
            return {EXCITATION: (OK, "idle", {})}
        known = [one for one in procedure.known.estimates if one.known_after is not None]
        text = f"exciting: {len(known)} of {len(procedure.known.estimates)} quantities known"
        return {EXCITATION: (OK, text, {"motion": procedure.motion, "goal": ", ".join(procedure.goal.quantities)})}

    @property
    def tasks(self) -> tuple[str, ...]:
        return (EXCITATION,)

    @property
    def activity(self) -> str:
        return f"motor commands at {self.config.rate:g} Hz during a goal of {self.get_name()}/excite"

    def _create_timer(self, config: ExcitationConfig) -> Timer:
        return self.create_timer(1.0 / config.rate, self._on_timer, clock=STEADY)

    # Inputs.

    def _on_motors(self, data: bytes) -> None:
        self._motor_states, self._inputs.motors_ns = data, time.monotonic_ns()

    def _on_angle(self, message: JointState) -> None:
        if message.position:
            self._inputs.angle, self._inputs.angle_ns = message.position[0], time.monotonic_ns()

    def _on_impedance(self, index: int, message: TransmissionImpedance) -> None:
        measurements = self._inputs.measurements
        measurements[index] = measure(message, measurements[index], time.monotonic_ns())

    def _on_state(self, index: int, message: EstimatorState) -> None:
        inputs = self._inputs
        inputs.states[index], inputs.states_ns[index] = message, time.monotonic_ns()
        inputs.sample_rates[index] = self._rates[index].update(nanoseconds(message.header.stamp), message.samples_fused)

    def _on_command(self, message: JointState) -> None:
        try:
            self._own_stamps.remove(nanoseconds(message.header.stamp))
        except ValueError:
            self._foreign_ns = time.monotonic_ns()

    def _decode_motors(self) -> None:
        if self._motor_states is None:
            return
        state = deserialize_message(self._motor_states, JointState)
        self._motor_states = None
        if len(state.position) >= 2:
            self._inputs.motors = state.position[0], state.position[1]
            self._message.name, self._message.header.frame_id = state.name[:2], state.header.frame_id

    # The goal. It stays ACCEPTED until its end: an execute callback that awaits would occupy the executor.

    def _on_goal(self, handle: Any) -> None:
        if self._goal is not None:
            self._finish(handle, None, "refused: another excitation is running")
            return
        self._goal, self._goal_ns = handle, time.monotonic_ns()

    def _on_timer(self) -> None:
        if self._goal is None:
            return
        self._decode_motors()
        now = time.monotonic_ns()
        try:
            if self._procedure is None:
                self._try_start(now)
            else:
                self._step(self._procedure, now)
        except ExcitationRefused as refusal:
            self._end(f"refused: {refusal}" if self._procedure is None else f"stopped: {refusal}")

    def _try_start(self, now: int) -> None:
        """Start the run as soon as all inputs are present. Raises ExcitationRefused."""
        if self._goal.is_cancel_requested:
            raise ExcitationRefused("canceled")
        if self._foreign_ns is not None and now - self._foreign_ns < YIELD_NS:
            raise ExcitationRefused(self._foreign_text())
        try:
            self._procedure = Procedure(self.config, goal_of(self._goal.request, self.config), self._inputs, now)
        except ExcitationRefused:
            if now - self._goal_ns > START_TIMEOUT_NS:
                raise

    def _step(self, procedure: Procedure, now: int) -> None:
        if self._goal.is_cancel_requested:
            procedure.end("canceled", now)
        elif self._foreign_ns is not None and self._foreign_ns > self._goal_ns:
            procedure.end(f"stopped ({self._foreign_text()})", now)
        else:
            self._update_design(procedure, now)
            self._command(procedure.step(self._inputs, now))
        if procedure.outcome is not None:
            self._end(procedure.outcome.message)
        elif now - self._feedback_ns > FEEDBACK_PERIOD_NS:
            self._feedback_ns = now
            self._goal.publish_feedback(self._feedback(procedure, now))

    def _update_design(self, procedure: Procedure, now: int) -> None:
        """Solve the design that is due in another thread; the motion continues meanwhile."""
        if self._design is None:
            task = procedure.task(self._inputs, now)
            self._design = None if task is None else self._pool.submit(choose_motion, task)
        elif self._design.done():
            design, self._design = self._design, None
            try:
                motion = design.result().motion
            except ValueError as error:
                raise ExcitationRefused(str(error)) from error
            procedure.begin_segment(motion, now)
            self.get_logger().info(f"motion: {motion}")

    def _command(self, motors: tuple[float, float]) -> None:
        stamp = self.get_clock().now()
        self._own_stamps.append(stamp.nanoseconds)
        self._message.header.stamp, self._message.position = stamp.to_msg(), list(motors)
        self._commands.publish(self._message)

    def _end(self, text: str) -> None:
        handle, procedure = self._goal, self._procedure
        self._goal = self._procedure = self._design = None
        self.get_logger().info(text)
        self._finish(handle, procedure, text)

    def _finish(self, handle: Any, procedure: Procedure | None, text: str) -> None:
        """Send the result: succeeded, canceled or aborted."""
        success = procedure is not None and procedure.outcome is not None and procedure.outcome.success
        result = Excite.Result(success=success, message=text)
        if procedure is not None:
            result.elapsed = procedure.elapsed(time.monotonic_ns())
            result.quantities = [message_of(one) for one in procedure.known.estimates]

        def conclude(goal: Any) -> Excite.Result:
            end = goal.succeed if success else goal.canceled if goal.is_cancel_requested else goal.abort
            end()
            return result

        handle.execute(conclude)

    def _feedback(self, procedure: Procedure, now: int) -> Excite.Feedback:
        elapsed = procedure.elapsed(now)
        return Excite.Feedback(
            elapsed=elapsed,
            remaining=max(procedure.goal.duration - elapsed, 0.0),
            motion=str(procedure.motion),
            quantities=[message_of(one) for one in procedure.known.estimates],
        )

    def _foreign_text(self) -> str:
        topic = self._commands.topic_name
        others = {end.node_name for end in self.get_publishers_info_by_topic(topic)} - {self.get_name()}
        return f"{' or '.join(sorted(others)) or 'another node'} commands the motors"


def main() -> int:
    """Entry point."""
    return run(ExcitationNode)


if __name__ == "__main__":
    raise SystemExit(main())
