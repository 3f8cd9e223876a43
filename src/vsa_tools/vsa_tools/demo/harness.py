"""A whole suite on stage: every node a process of its own, brought up, started together, taken down in order."""

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

READY_S = 60.0  # for all processes to be active, on a busy machine
ANSWER_S = 20.0  # for a service to answer, on a busy machine
ASK_AGAIN_S = 2.0  # where no answer came
SETTLE_S = 2.5  # for the last readers and writers to find each other, which only they know, on a busy machine
LISTEN_S = 0.1  # for at a time
SILENCE_S = 1.5  # the driver tells ten times a second which samples it had; a host may stop it meanwhile


@dataclass(frozen=True)
class ProcessSpec:
    """One process of the suite: a node, or several (`nodes`) that keep their own names."""

    name: str
    package: str
    executable: str
    arguments: tuple[str, ...] = ()
    nice: int = 0
    nodes: tuple[str, ...] = ()

    def command(self, parameters: Path) -> list[str]:
        """What to execute."""
        ros = ["--ros-args", "--params-file", str(parameters)]
        ros += [] if self.nodes else ["-r", f"__node:={self.name}"]
        return [executable(self.package, self.executable), *self.arguments, *ros]


class ProcessHarness:
    """The processes of one run and a node of our own among them. Leaving the `with` block ends all of it.

    `arrivals_ns` are stamp and time of arrival of every joint message that our node, a subscriber as any other, got.
    """

    def __init__(self, environment: Mapping[str, str], logs: Path, namespace: str = "/vsa") -> None:
        os.environ.update(environment)
        self.namespace = namespace
        self.group = Group(logs, environment)
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self.node: Node = rclpy.create_node("stage", namespace=namespace)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self.arrivals_ns: list[tuple[int, int]] = []
        self._counters = 0
        self._states: dict[str, Any] = {}
        self._homes: dict[str, str] = {}  # process of each node
        self._readers: dict[str, int] = {}  # how many the driver has found of each of its topics; told while silent
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

    def start(self, parts: Sequence[ProcessSpec], parameters: Path) -> None:
        """Start the processes; they come up side by side."""
        for part in parts:
            self._homes |= dict.fromkeys(part.nodes or (part.name,), part.name)
            self.group.start(part.name, part.command(parameters), part.nice)

    def wait_until_active(self, *names: str) -> None:
        """Return when these nodes are active. Raises ProcessError for one that dies or takes too long."""
        for name in names:
            self._until(partial(self._is_active, name), lambda name=name: f"{name} is not active")  # type: ignore[misc]

    def activate(self, name: str) -> None:
        """Configure and activate a node that waits for it (`autostart` false)."""
        client = self.node.create_client(ChangeState, f"{name}/change_state")
        self._until(client.service_is_ready, lambda: f"{name} does not answer")
        for transition in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
            answer = self._call(client, ChangeState.Request(transition=Transition(id=transition)), name)
            if not answer.success:
                raise ProcessError(f"{name} could not be started:\n{self.group[self._homes[name]].tail()}")
        self.node.destroy_client(client)

    def wait_until_connected(self, recorded: bool = True) -> None:
        """Return when every topic that one of the nodes writes has its readers; only the nodes' if not `recorded`.

        Before the rig starts: while it is silent the driver tells which readers it has found.
        """

        def lonely() -> list[str]:
            written = [topic for topic in suite_topics(self.namespace) if self.node.count_publishers(topic)]
            required = {f"{self.namespace}/joint_impedance", f"{self.namespace}/transmission_1/force"}
            return [
                topic for topic in required.union(written if recorded else ()) if not self._is_connected(topic, written)
            ]

        def unheard() -> list[str]:
            return [topic for topic, found in self._readers.items() if found < self.node.count_subscribers(topic)]

        self._until(lambda: not lonely(), lambda: f"nobody reads or writes {', '.join(lonely())}")
        self.spin(SETTLE_S)
        self._until(lambda: self._readers != {} and not unheard(), lambda: f"the driver lacks readers of {unheard()}")

    def wait_until_open(self, port: int) -> None:
        """Return when a process listens on this TCP port."""

        def is_open() -> bool:
            with socket.socket() as probe:
                return probe.connect_ex(("127.0.0.1", port)) == 0

        self._until(is_open, lambda: f"nobody listens on port {port}")

    def request(self, service: str) -> None:
        """Call a Trigger service that bears being called twice, as `rig_simulator/start`. Raises ProcessError."""
        client = self.node.create_client(Trigger, service)
        self._until(client.service_is_ready, lambda: f"no service {service}")
        end = time.monotonic() + ANSWER_S
        while (answer := self._ask(client, Trigger.Request())) is None:
            if time.monotonic() > end:
                raise ProcessError(f"after {ANSWER_S:.0f} s: {service} does not answer")
        if not answer.success:
            raise ProcessError(f"{service}: {answer.message}")
        self.node.destroy_client(client)

    def spin(self, seconds: float) -> None:
        """Let our own node work. Raises ProcessError if a process died."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
        self.group.check()

    def spin_until_idle(self, limit: float) -> None:
        """Return when the driver has had no sample for a while, or after `limit` [s]."""
        self.spin_until_unchanged(lambda: self._counters, limit)

    def spin_until_unchanged(self, progress: Callable[[], object], limit: float) -> None:
        """Return when what `progress` tells has not changed for SILENCE_S of listening, or after `limit` [s].

        However long the computer stood still meanwhile: what has come by then is heard first.
        """
        end, still, last = time.monotonic() + limit, 0, progress()
        while still * LISTEN_S < SILENCE_S and time.monotonic() < end:
            self.spin(LISTEN_S)
            now = progress()
            still, last = (still + 1 if now == last else 0), now

    def _on_joint(self, data: bytes) -> None:
        self.arrivals_ns.append((read_stamp(data), time.time_ns()))

    def _on_counters(self, _: bytes) -> None:
        self._counters += 1

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == f"{self.namespace}/driver":
                told = ((value.key.partition("readers ")[2], value.value) for value in status.values)
                self._readers = {topic: int(found) for topic, found in told if topic}

    def _is_connected(self, topic: str, written: Sequence[str]) -> bool:
        return topic in written and self.node.count_subscribers(topic) > 0

    def _is_active(self, name: str) -> bool:
        if name not in self._states:
            self._states[name] = self.node.create_client(GetState, f"{name}/get_state")
        if not self._states[name].service_is_ready():
            return False
        answer = self._ask(self._states[name], GetState.Request())
        return answer is not None and bool(answer.current_state.id == State.PRIMARY_STATE_ACTIVE)

    def _ask(self, client: Any, request: Any) -> Any:
        """The answer, or None after a while: one to somebody who has just appeared can get lost."""
        future = client.call_async(request)
        end = time.monotonic() + ASK_AGAIN_S
        while not future.done() and time.monotonic() < end:
            self.spin(0.02)
        if future.done():
            return future.result()
        client.remove_pending_request(future)
        return None

    def _call(self, client: Any, request: Any, name: str, limit: float = ANSWER_S) -> Any:
        future = client.call_async(request)
        self._until(future.done, lambda: f"{name} does not answer", limit)
        return future.result()

    def _until(self, condition: Callable[[], bool], complaint: Callable[[], str], limit: float = READY_S) -> None:
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise ProcessError(f"after {limit:.0f} s: {complaint()}")
            self.spin(0.02)
