# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recording of a run by a subscriber outside the suite: joint messages with arrival, sample counters, diagnostics."""

import time
from collections.abc import Sequence
from functools import partial

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from vsa_bench.harness.deployment import COMPOSED, Case
from vsa_bench.harness.score import JointRecord
from vsa_common.ros.cdr import Reader, read_counters, read_stamp
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import NANOSECONDS
from vsa_msgs.msg import CaptureCounters, JointImpedance

SIDES = ("transmission_1", "transmission_2")
_STAMPS = Reader({"header": "std_msgs/Header", "transmission_stamp": "builtin_interfaces/Time[2]"})


class Observer:
    """Subscribes to every joint of a case by `node`, and stores serialized messages: they are read after the run."""

    def __init__(self, node: Node, case: Case) -> None:
        self._node = node
        self._case = case
        self._joints: dict[str, list[tuple[bytes, int]]] = {name: [] for name in case.namespaces}
        self._counters: dict[str, tuple[list[bytes], ...]] = {name: ([], []) for name in case.namespaces}
        self._diagnostics: dict[str, tuple[str, dict[str, str]]] = {}
        subscribe = node.create_subscription
        self._subscriptions = []
        for namespace in case.namespaces:
            callback, topic = partial(self._on_joint, namespace), f"/{namespace}/joint_impedance"
            self._subscriptions.append(subscribe(JointImpedance, topic, callback, RELIABLE, raw=True))
            for i, side in enumerate(SIDES):
                callback, topic = partial(self._on_counters, namespace, i), f"/{namespace}/{side}/capture_counters"
                self._subscriptions.append(subscribe(CaptureCounters, topic, callback, RELIABLE, raw=True))
        subscribe(DiagnosticArray, "/diagnostics", self._on_diagnostics, 100)

    def unconnected(self) -> list[str]:
        """Topics of the suite without a publisher or without a subscriber, or without a publisher discovered here."""
        topics = ["joint_impedance", *(f"{side}/capture_counters" for side in SIDES)]
        if self._case.mode != COMPOSED:
            topics += [f"{side}/{topic}" for side in SIDES for topic in ("force", "encoder", "impedance")]
        names = [f"/{namespace}/{topic}" for namespace in self._case.namespaces for topic in topics]
        node = self._node
        unmatched = [name for name in names if not (node.count_publishers(name) and node.count_subscribers(name))]
        return unmatched + [one.topic_name for one in self._subscriptions if not one.get_publisher_count()]

    def done(self) -> bool:
        """Whether every rig has sent its last sample."""
        return all(self._rig(namespace)[0] == "done" for namespace in self._case.namespaces)

    def progress(self) -> tuple[int, ...]:
        """Number of counter batches received from each side, and the stamp of each joint's last message [ns]."""
        batches = [len(side) for sides in self._counters.values() for side in sides]
        return *batches, *(read_stamp(joint[-1][0]) for joint in self._joints.values() if joint)

    def sent(self, namespace: str) -> int:
        """Samples that a rig has sent."""
        return int(self._rig(namespace)[1].get("samples", 0))

    def joint_record(self, namespace: str) -> JointRecord:
        """All messages of one joint."""
        joints = [(*_stamps(data), arrival_ns) for data, arrival_ns in self._joints[namespace]]
        first, second = (_numbers(batches) for batches in self._counters[namespace])
        return JointRecord(self.sent(namespace), np.array(joints, np.int64).reshape(-1, 3), first, second)

    def _rig(self, namespace: str) -> tuple[str, dict[str, str]]:
        return self._diagnostics.get(f"/{namespace}/rig_simulator: simulation", ("", {}))

    def _on_joint(self, namespace: str, data: bytes) -> None:
        self._joints[namespace].append((data, time.time_ns()))

    def _on_counters(self, namespace: str, side: int, data: bytes) -> None:
        self._counters[namespace][side].append(data)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._diagnostics[status.name] = (status.message, {value.key: value.value for value in status.values})


def _stamps(data: bytes) -> tuple[int, int]:
    first_s, first_ns, second_s, second_ns = _STAMPS.read(data)[1]
    return first_s * NANOSECONDS + first_ns, second_s * NANOSECONDS + second_ns


def _numbers(batches: Sequence[bytes]) -> dict[int, int]:
    """Number of each sample by its capture stamp [ns]."""
    numbers: dict[int, int] = {}
    for data in batches:
        numbers.update(zip(*read_counters(data), strict=True))
    return numbers
