# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Processes of a whole suite: start, activation, connection, orderly end."""

import os
import socket
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger
from vsa_common.ros.cdr import read_stamp
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.subprocesses import Group, ProcessError, executable
from vsa_msgs.msg import CaptureCounters, JointImpedance
from vsa_tools.topics import suite_topics

# Time limits are those of a machine under full load.
READY_S = 60.0  # [s] for all processes to be active
ANSWER_S = 20.0  # [s] for a service to answer
RETRY_S = 2.0  # [s] until an unanswered request is repeated: DDS may lose the first answer of a new server
SETTLE_S = 2.5  # [s] for the discovery between other processes, which this process cannot observe
POLL_S = 0.1  # [s] of each spin while waiting for idleness
IDLE_S = 1.5  # [s] without change that count as idle: 15 periods of the driver's counter topic

TRANSITIONS = (  # with the state that each ends in
    (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
    (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
)


@dataclass(frozen=True)
class ProcessSpec:
    """One process of the suite: one node named `name`, or several nodes (`nodes`)."""

    name: str
    package: str
    executable: str
    arguments: tuple[str, ...] = ()
    nice: int = 0
    nodes: tuple[str, ...] = ()

    def command(self, parameters: Path) -> list[str]:
        """Command line with the parameter file."""
        ros = ["--ros-args", "--params-file", str(parameters)]
        ros += [] if self.nodes else ["-r", f"__node:={self.name}"]
        return [executable(self.package, self.executable), *self.arguments, *ros]


class ProcessHarness:
    """The processes of one run and an observer node. Leaving the `with` block ends all of them.

    `arrivals_ns` are stamp and arrival time [ns] of every joint message at the observer node.
    """

    def __init__(self, environment: Mapping[str, str], logs: Path, namespace: str = "/vsa") -> None:
        os.environ.update(environment)
        self.namespace = namespace
        self.group = Group(logs, environment)
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self.node: Node = rclpy.create_node("harness", namespace=namespace)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self.arrivals_ns: list[tuple[int, int]] = []
        self._counters = 0
        self._state_clients: dict[str, Any] = {}
        self._process_of: dict[str, str] = {}  # process by node
        self._matched_readers: dict[str, int] = {}  # number by topic of the driver, from its diagnostics
        counters = "transmission_1/capture_counters"
        self.node.create_subscription(JointImpedance, "joint_impedance", self._on_joint, RELIABLE, raw=True)
        self.node.create_subscription(CaptureCounters, counters, self._on_counters, RELIABLE, raw=True)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, RELIABLE)

    def __enter__(self) -> "ProcessHarness":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            self.group.close(last="recorder")
        finally:
            self.node.destroy_node()
            rclpy.try_shutdown()

    def start(self, processes: Sequence[ProcessSpec], parameters: Path) -> None:
        """Start the processes in parallel."""
        for process in processes:
            self._process_of |= dict.fromkeys(process.nodes or (process.name,), process.name)
            self.group.start(process.name, process.command(parameters), process.nice)

    def start_loops(self, count: int, parameters: Path) -> None:
        """Start `count` busy loops, each of which takes a core; they end with the processes."""
        for number in range(1, count + 1):
            self.group.start(f"busy_{number}", ["sh", "-c", "while :; do :; done", str(parameters)])

    def wait_until_active(self, *names: str) -> None:
        """Return when the nodes `names` are active. Raises ProcessError on an exited process or after READY_S."""
        for name in names:
            active = partial(self._is_in, name, State.PRIMARY_STATE_ACTIVE)
            self._until(active, lambda name=name: f"{name} is not active")  # type: ignore[misc]

    def activate(self, name: str) -> None:
        """Configure and activate a node with `autostart` false. Raises ProcessError on failure."""
        client = self.node.create_client(ChangeState, f"{name}/change_state")
        self._until(client.service_is_ready, lambda: f"{name} does not answer")
        for transition, state in TRANSITIONS:
            answer = self._try_call(client, ChangeState.Request(transition=Transition(id=transition)))
            if answer is None:
                self._until(partial(self._is_in, name, state), lambda: f"{name} does not answer", ANSWER_S)
            elif not answer.success:
                raise ProcessError(f"{name} could not be started:\n{self.group[self._process_of[name]].tail()}")
        self.node.destroy_client(client)

    def wait_until_connected(self, recorded: bool = True) -> None:
        """Return when every published topic has a subscriber; without `recorded`, only the required topics.

        The driver's diagnostics list its matched readers.
        """

        def unconnected() -> list[str]:
            written = [topic for topic in suite_topics(self.namespace) if self.node.count_publishers(topic)]
            required = {f"{self.namespace}/joint_impedance", f"{self.namespace}/transmission_1/force"}
            return [
                topic for topic in required.union(written if recorded else ()) if not self._is_connected(topic, written)
            ]

        def unmatched() -> list[str]:
            matched = self._matched_readers.items()
            return [topic for topic, count in matched if count < self.node.count_subscribers(topic)]

        self._until(lambda: not unconnected(), lambda: f"no publisher or no subscriber: {', '.join(unconnected())}")
        self.spin(SETTLE_S)
        self._until(
            lambda: self._matched_readers != {} and not unmatched(),
            lambda: f"the driver has not matched all readers of {unmatched()}",
        )

    def wait_until_open(self, port: int) -> None:
        """Return when a process listens on this TCP port."""

        def is_open() -> bool:
            with socket.socket() as probe:
                return probe.connect_ex(("127.0.0.1", port)) == 0

        self._until(is_open, lambda: f"no process listens on port {port}")

    def request(self, service: str) -> None:
        """Call an idempotent Trigger service, as `rig_simulator/start`. Raises ProcessError on failure."""
        client = self.node.create_client(Trigger, service)
        self._until(client.service_is_ready, lambda: f"no service {service}")
        end = time.monotonic() + ANSWER_S
        while (answer := self._try_call(client, Trigger.Request())) is None:
            if time.monotonic() > end:
                raise ProcessError(f"after {ANSWER_S:.0f} s: {service} does not answer")
        if not answer.success:
            raise ProcessError(f"{service}: {answer.message}")
        self.node.destroy_client(client)

    def spin(self, seconds: float) -> None:
        """Spin the observer node. Raises ProcessError if a process has exited."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
        self.group.check()

    def spin_until_idle(self, limit: float) -> None:
        """Return when no capture counters arrive for IDLE_S, or after `limit` [s]."""
        self.spin_until_unchanged(lambda: self._counters, limit)

    def spin_until_unchanged(self, progress: Callable[[], object], limit: float) -> None:
        """Return when `progress` is constant for IDLE_S of spinning, or after `limit` [s].

        Spins are counted, not the clock: after a stall of the computer the queued messages are processed first.
        """
        end, unchanged, last = time.monotonic() + limit, 0, progress()
        while unchanged * POLL_S < IDLE_S and time.monotonic() < end:
            self.spin(POLL_S)
            now = progress()
            unchanged, last = (unchanged + 1 if now == last else 0), now

    def _on_joint(self, data: bytes) -> None:
        self.arrivals_ns.append((read_stamp(data), time.time_ns()))

    def _on_counters(self, _: bytes) -> None:
        self._counters += 1

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == f"{self.namespace}/driver: topics":
                readers = ((value.key.partition("readers ")[2], value.value) for value in status.values)
                self._matched_readers = {topic: int(found) for topic, found in readers if topic}

    def _is_connected(self, topic: str, written: Sequence[str]) -> bool:
        return topic in written and self.node.count_subscribers(topic) > 0

    def _is_in(self, name: str, state: int) -> bool:
        if name not in self._state_clients:
            self._state_clients[name] = self.node.create_client(GetState, f"{name}/get_state")
        if not self._state_clients[name].service_is_ready():
            return False
        answer = self._try_call(self._state_clients[name], GetState.Request())
        return answer is not None and bool(answer.current_state.id == state)

    def _try_call(self, client: Any, request: Any) -> Any:
        """The answer, or None after RETRY_S: the answer to a client that is not yet matched can get lost."""
        future = client.call_async(request)
        end = time.monotonic() + RETRY_S
        while not future.done() and time.monotonic() < end:
            self.spin(0.02)
        if future.done():
            return future.result()
        client.remove_pending_request(future)
        return None

    def _until(self, condition: Callable[[], bool], message: Callable[[], str], limit: float = READY_S) -> None:
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise ProcessError(f"after {limit:.0f} s: {message()}")
            self.spin(0.02)
