# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Node: CAN frames to force and encoder of each transmission; motor commands to the bus."""

import gc
import sys
import time
from collections.abc import Callable

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
from vsa_common.config.joints import joints
from vsa_common.ros.node import SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_driver.acquisition.calibration import TareError
from vsa_driver.acquisition.channel import JointSample, Measurement, MotorSample
from vsa_driver.acquisition.clock import CaptureClock
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.acquisition.router import Router
from vsa_driver.can.bus import BusError, Frame, open_bus
from vsa_driver.can.frames import FrameError
from vsa_driver.can.link import BusLink
from vsa_driver.health import DriverHealth, tasks
from vsa_driver.motors.motor import CommandRefused, MotorGate, MotorLimits
from vsa_driver.settings import DriverSettings, MotorSettings
from vsa_driver.topics import RigTopics, TransmissionTopics
from vsa_driver.tuning import LOG_PERIOD_S, THREAD_SWITCH_S

# The newest command only; best effort matches reliable publishers too.
COMMANDS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class DriverNode(SuiteNode[DriverSettings]):
    """Publish the samples of the rig, and pass commands to the motors once armed.

    One thread reads the bus and publishes; all other work is in the executor's thread. With `single_threaded` the
    caller reads the bus by `link.step`.
    """

    def __init__(self, name: str = "driver", namespace: str = "vsa", single_threaded: bool = False) -> None:
        super().__init__(name, DriverSettings, namespace)
        self.on_idle: Callable[[int], None] | None = None  # callback of `BusLink`; a subclass sets it before `start`
        self._single_threaded = single_threaded
        self._former_router: Router | None = None  # of the last activation

    def configure(self) -> None:
        """Read the DBC file, check mapping and calibration, and open the bus once."""
        Router(load_frames(self.config.dbc), self.config)
        open_bus(self.config.bus).close()

    def start(self) -> None:
        config, motors = self.config, self.config.motors
        self._router = Router(load_frames(config.dbc), config)
        if self._former_router is not None:
            for name in self._router.keep_tares(self._former_router):
                self.get_logger().warning(f"{name}: tare discarded, as its parameters have changed")
        self._motors = list(motors.names)
        self._gate = MotorGate(_limits(motors), len(self._motors))
        self._capture_clock = CaptureClock()
        self._last_seen_ns = dict.fromkeys(self._router.transmissions, 0)
        self._holding = False
        self._max_delay_ns = 0
        prefix = config.frame_prefix
        self._topics = {name: TransmissionTopics(self, name, prefix) for name in self._router.transmissions}
        self._rig = RigTopics(self, config.joint.name, self._motors, prefix)
        pause_s = self.common.realtime.rest
        self.link = BusLink(config.bus, self._on_frame, self._on_down, on_idle=self.on_idle, coalescing_s=pause_s)
        self._health_monitor = DriverHealth(self._router, self.link, self._gate)
        try:
            self.link.open(self._single_threaded)
        except BusError:
            self._destroy_publishers()
            raise
        self._commands = self.create_subscription(JointState, "motor_commands", self._on_command, COMMANDS)
        self._own_services = [
            self.create_service(SetBool, "~/arm", self._on_arm),
            self.create_service(Trigger, "~/tare", self._on_tare),
        ]
        self._own_timers = self._create_timers(config)
        gc.freeze()  # objects that exist now are permanent; collecting them would delay samples

    def stop(self) -> None:
        self._gate.disarm("stopped")
        self.link.close()
        self._former_router = self._router
        self._flush()
        self._destroy_timers()
        for service in self._own_services:
            self.destroy_service(service)
        self.destroy_subscription(self._commands)
        self._destroy_publishers()

    def reconfigure(self, config: DriverSettings) -> None:
        self._gate.set_limits(_limits(config.motors))
        self._router.set_limits(config)
        self._destroy_timers()
        self._own_timers = self._create_timers(config)

    def health(self) -> Tasks:
        max_delay_ns, self._max_delay_ns = self._max_delay_ns, 0
        return self._health_monitor.assess(self._timed_out(), max_delay_ns, self._holding)

    @property
    def tasks(self) -> tuple[str, ...]:
        return tasks(self.config.transmissions)

    @property
    def hardware_id(self) -> str:
        return f"{self.config.bus.interface} {self.config.bus.channel}"

    @property
    def activity(self) -> str:
        commands = f"motor commands at {self.config.motors.command_rate:g} Hz" if self._router.commands else "no motors"
        return f"CAN bus {self.hardware_id}, {' and '.join(self.config.transmissions)}, {commands}"

    # In the thread that reads the bus.

    def _on_frame(self, frame: Frame) -> None:
        now_ns, steady_ns = time.time_ns(), time.monotonic_ns()
        stamp_ns = self._capture_clock.to_epoch(frame.timestamp, now_ns, steady_ns)
        for sample in self._router.add(frame, stamp_ns):
            if isinstance(sample, Measurement):
                self._last_seen_ns[sample.transmission] = steady_ns
                self._max_delay_ns = max(self._max_delay_ns, now_ns - stamp_ns)
                self.on_sample(sample)
            elif isinstance(sample, JointSample):
                self._rig.publish_joint(sample)
            elif isinstance(sample, MotorSample):
                self._gate.update_position(sample.positions, steady_ns * 1e-9)
                self._holding = sample.holding
                self._rig.publish_motors(sample)

    def on_sample(self, sample: Measurement) -> None:
        """Publish one sample of a transmission; a subclass may process it first."""
        self._topics[sample.transmission].publish(sample)

    def _on_down(self, reason: str) -> None:
        if self._gate.armed:
            self._gate.disarm("the bus failed")
            self.get_logger().error(f"motors disarmed: {reason}", throttle_duration_sec=LOG_PERIOD_S)

    # In the executor's thread.

    def _on_command(self, message: JointState) -> None:
        try:
            named = dict(zip(message.name, message.position, strict=False))
            if len(message.name) != len(message.position) or not named.keys() >= set(self._motors):
                self._gate.refuse(f"a position for each of {', '.join(self._motors)} was expected")
            self._gate.command([named[name] for name in self._motors], time.monotonic())
        except CommandRefused as error:
            self.get_logger().warning(f"motor command refused: {error}", throttle_duration_sec=LOG_PERIOD_S)

    def _send_command(self) -> None:
        positions = self._gate.step(time.monotonic())
        commands = self._router.commands
        if positions is None or commands is None:
            return
        try:
            message = commands.source.message
            self.link.send(message.id, commands.encode(positions), message.extended, message.fd)
        except (BusError, FrameError) as error:
            self._gate.disarm(str(error))
            self.get_logger().error(f"command not sent, motors disarmed: {error}", throttle_duration_sec=LOG_PERIOD_S)

    def _on_arm(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        try:
            if not request.data:
                self._gate.disarm("disarmed by the service")
            elif self._router.commands is None or not self.link.up:
                raise CommandRefused(self.link.reason or "no command signals are mapped")
            else:
                self._gate.arm(time.monotonic())
            response.success, response.message = True, self._gate.state
            self.get_logger().info(f"motors {self._gate.state}")
        except CommandRefused as error:
            response.success, response.message = False, str(error)
        return response

    def _on_tare(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        timed_out = self._timed_out()
        if timed_out:
            response.message = f"no samples of {' and '.join(timed_out)}"
            return response
        try:
            offsets = self._router.take_tares().items()
            response.message = ", ".join(f"{name} {offset:+.4f} N" for name, offset in offsets)
            response.success = True
            self.get_logger().info(f"tare: {response.message}")
        except TareError as error:
            response.message = str(error)
        return response

    def _flush(self) -> None:
        for topics in self._topics.values():
            topics.flush()

    def _timed_out(self) -> list[str]:
        oldest_ns = time.monotonic_ns() - int(self.config.silence * 1e9)
        return [name for name, seen_ns in self._last_seen_ns.items() if seen_ns < oldest_ns]

    def _create_timers(self, config: DriverSettings) -> list[Timer]:
        return [
            self.create_timer(1.0 / config.counters_rate, self._flush, clock=self.steady),
            self.create_timer(1.0 / config.motors.command_rate, self._send_command, clock=self.steady),
        ]

    def _destroy_timers(self) -> None:
        for timer in self._own_timers:
            self.destroy_timer(timer)

    def _destroy_publishers(self) -> None:
        for publisher in [*self._rig.publishers, *(p for topics in self._topics.values() for p in topics.publishers)]:
            self.destroy_publisher(publisher)


def _limits(motors: MotorSettings) -> MotorLimits:
    return MotorLimits(motors.position_min, motors.position_max, motors.speed_max, motors.command_timeout)


def main() -> int:
    """Entry point."""
    sys.setswitchinterval(THREAD_SWITCH_S)
    return run(lambda: [DriverNode(namespace=joint) for joint in joints(sys.argv)], description=__doc__)


if __name__ == "__main__":
    sys.exit(main())
