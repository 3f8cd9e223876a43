# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Records every topic of the suite into a rosbag2 recording (MCAP), without deserialization."""

import argparse
import importlib
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.utilities import remove_ros_args
from vsa_common.config.configuration import ConfigurationError, quantity, string
from vsa_common.io.bags import BagError, Recording
from vsa_common.ros.cdr import read_counters, read_stamp
from vsa_common.ros.node import ERROR, OK, STEADY, WARN, Health, SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_common.terminal import Bar, progress
from vsa_tools.record.missed import MissedForces
from vsa_tools.record.spool import Spool
from vsa_tools.topics import suite_topics

RECORDING = "recording"  # task of the diagnostics
DISCOVERY_PERIOD_S = 0.5  # [s] between two searches for the additional topics


@dataclass(frozen=True)
class RecorderConfig:
    """Parameters of the recorder."""

    out: str = string("", "folder of the recording, must not exist; empty: vsa_bag_DATE_TIME here")
    topics: tuple[str, ...] = string(
        ("",), "topics of others to record besides, absolute names; their type is looked up"
    )
    queue_limit: int = quantity(
        100_000, "", 100, 10_000_000, "messages that may wait for the disk; more are dropped", tunable=True
    )
    depth: int = quantity(2000, "", 1, 100_000, "messages of a topic that may wait for this process")
    flush_period: float = quantity(
        1.0, "s", 0.05, 60.0, "a crash costs no more than the last so many seconds", tunable=True
    )
    disk_reserve: int = quantity(
        16_000_000, "byte", 0, 10**12, "free space at which the recording is closed", tunable=True
    )


class RecorderNode(SuiteNode[RecorderConfig]):
    """Records the suite's topics of one namespace; it is active once it subscribes to all of them."""

    def __init__(self, bar: Bar) -> None:
        super().__init__("recorder", RecorderConfig)
        self._bar = bar
        self._started = False

    def start(self) -> None:
        config = self.config
        self._qos = QoSProfile(depth=config.depth, reliability=ReliabilityPolicy.RELIABLE)
        path = Path(config.out or time.strftime("vsa_bag_%Y%m%d_%H%M%S"))
        try:
            self._recording = Recording(path)
        except BagError as error:
            raise ConfigurationError(f"out = {str(path)!r}: {error}") from error
        self.spool = Spool(self._recording, config.queue_limit, config.flush_period, config.disk_reserve)
        self._started = True
        self._reported = self._not_received = 0
        self._missed: dict[str, MissedForces] = {}  # by transmission
        self._missing = {topic for topic in config.topics if topic}
        self._recorded: list[Any] = []
        for topic, type_name in suite_topics(self.get_namespace()).items():
            self._subscribe(topic, type_name, self._callback_of(topic))
        self._own_timers = [self.create_timer(DISCOVERY_PERIOD_S, self._discover, clock=STEADY)]

    def stop(self) -> None:
        self._update_missed()
        for timer in self._own_timers:
            self.destroy_timer(timer)
        for subscription in self._recorded:
            self.destroy_subscription(subscription)
        self.spool.close()

    def reconfigure(self, config: RecorderConfig) -> None:
        self.spool.set_limits(config.queue_limit, config.flush_period, config.disk_reserve)

    def health(self) -> Tasks:
        return {RECORDING: self._health_of_recording()}

    @property
    def tasks(self) -> tuple[str, ...]:
        return (RECORDING,)

    @property
    def activity(self) -> str:
        return f"recording {len(self._recorded)} topics to {self._recording.path}"

    def _health_of_recording(self) -> Health:
        spool = self.spool
        not_received = self._update_missed()
        values = {"messages": spool.written, "dropped": spool.dropped, "longest_queue": spool.longest_queue}
        values["forces_not_received"] = self._not_received
        if spool.failure:
            return ERROR, spool.failure, values
        before, self._reported = self._reported, spool.dropped
        if spool.dropped > before:
            return (
                WARN,
                f"the disk is too slow: {spool.dropped - before} messages dropped in the last second",
                values,
            )
        if not_received:
            return WARN, f"this computer is too slow: {not_received} forces more were not received", values
        return OK, f"recording to {self._recording.path}", values

    def _update_missed(self) -> int:
        """Forces not received that were not counted before; one that arrives late is counted until then."""
        before, self._not_received = self._not_received, sum(one.update() for one in self._missed.values())
        return max(0, self._not_received - before)

    def _subscribe(self, topic: str, type_name: str, callback: Callable[[bytes], None]) -> None:
        self._recording.add(topic, type_name)
        self._recorded.append(self.create_subscription(message_class(type_name), topic, callback, self._qos, raw=True))

    def _callback_of(self, topic: str) -> Callable[[bytes], None]:
        """Callback for a topic of the suite; forces and the driver's list of samples are counted, too."""
        transmission, _, name = topic.rpartition("/")
        counted = {"force": self._on_force, "capture_counters": self._on_counters}.get(name)
        if counted is None:
            return partial(self._on_message, topic)
        return partial(counted, topic, self._missed.setdefault(transmission, MissedForces()))

    def _on_force(self, topic: str, missed: MissedForces, data: bytes) -> None:
        missed.add_force(read_stamp(data))
        self._on_message(topic, data)

    def _on_counters(self, topic: str, missed: MissedForces, data: bytes) -> None:
        missed.add_listed(read_counters(data)[0])
        self._on_message(topic, data)

    def _on_message(self, topic: str, data: bytes) -> None:
        self.spool.put(topic, time.time_ns(), data)

    @property
    def failure(self) -> str:
        """Why the recording ended early; empty where it did not."""
        return self.spool.failure if self._started else ""

    def summary(self) -> str:
        """Messages, path, drops and failure on one line."""
        if not self._started:
            return "ended before the recording began"
        spool = self.spool
        missed = f", {self._not_received} forces not received: this computer is too slow" if self._not_received else ""
        text = f"{spool.written} messages in {self._recording.path}, {spool.dropped} dropped{missed} {spool.failure}"
        return text.rstrip()

    def _discover(self) -> None:
        self._bar.advance(0.0, f"{self.spool.written} messages, {self.spool.dropped} dropped")
        if not self._missing:
            return
        for topic, types in self.get_topic_names_and_types():
            if topic in self._missing:
                self._missing.discard(topic)
                try:
                    self._subscribe(topic, types[0], partial(self._on_message, topic))
                except (BagError, ImportError, AttributeError) as error:
                    self.get_logger().error(f"{topic} is not recorded: {error}")


def message_class(type_name: str) -> type:
    """The Python class of a message type, `geometry_msgs/msg/WrenchStamped`."""
    package, _, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def ros_arguments(arguments: Sequence[str]) -> list[str]:
    """The tool's options as ROS arguments, after those given with --ros-args."""
    parser = argparse.ArgumentParser(prog="record", description=__doc__, epilog="Ctrl-C ends the recording.")
    parser.add_argument("--out", metavar="DIR", default="", help="folder of the recording (vsa_bag_DATE_TIME)")
    parser.add_argument("--namespace", default="", help="namespace of the joint (/vsa)")
    parser.add_argument("--topic", action="append", default=[], help="an additional topic to record; repeatable")
    options = parser.parse_args(remove_ros_args([parser.prog, *arguments])[1:])
    options_as_ros = ["-p", f"out:={_quoted(options.out)}"] if options.out else []
    options_as_ros += ["-p", f"topics:=[{','.join(map(_quoted, options.topic))}]"] if options.topic else []
    options_as_ros += ["-r", f"__ns:=/{options.namespace.strip('/')}"] if options.namespace else []
    given = list(arguments[arguments.index("--ros-args") :]) if "--ros-args" in arguments else []
    return [*given, "--ros-args", *options_as_ros] if options_as_ros else given


def _quoted(text: str) -> str:
    """A text in YAML: rcl would read 20260514 as a number and true as a truth value."""
    return "'" + text.replace("'", "''") + "'"


def main() -> int:
    """Entry point."""
    ros = ros_arguments(sys.argv[1:])
    nodes: list[RecorderNode] = []
    with progress(None, "recording") as bar:

        def create() -> RecorderNode:
            nodes.append(RecorderNode(bar))
            return nodes[0]

        code = run(create, [sys.argv[0], *ros])
    if code:
        return code
    print(f"recorder: {nodes[0].summary()}", file=sys.stderr)
    return 1 if nodes[0].failure else 0


if __name__ == "__main__":
    sys.exit(main())
