"""What a subscriber outside the suite hears: joint messages with their arrival, numbers of the samples, health."""

import time
from collections.abc import Sequence
from functools import partial

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from vsa_bench.harness.deployment import COMPOSED, Case
from vsa_bench.harness.score import Heard
from vsa_common.ros.cdr import Reader, read_counters, read_stamp
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import NANOSECONDS
from vsa_msgs.msg import CaptureCounters, JointImpedance

SIDES = ("transmission_1", "transmission_2")
_STAMPS = Reader({"header": "std_msgs/Header", "transmission_stamp": "builtin_interfaces/Time[2]"})


class Observer:
    """Listens to every joint of a case from `node`, and keeps bytes: they are read when the run is over."""

    def __init__(self, node: Node, case: Case) -> None:
        self._node = node
        self._case = case
        self._joints: dict[str, list[tuple[bytes, int]]] = {space: [] for space in case.namespaces}
        self._counters: dict[str, tuple[list[bytes], ...]] = {space: ([], []) for space in case.namespaces}
        self._health: dict[str, tuple[str, dict[str, str]]] = {}
        subscribe = node.create_subscription
        self._ears = []
        for space in case.namespaces:
            hear = partial(self._on_joint, space)
            self._ears.append(subscribe(JointImpedance, f"/{space}/joint_impedance", hear, RELIABLE, raw=True))
            for i, side in enumerate(SIDES):
                hear, topic = partial(self._on_counters, space, i), f"/{space}/{side}/capture_counters"
                self._ears.append(subscribe(CaptureCounters, topic, hear, RELIABLE, raw=True))
        subscribe(DiagnosticArray, "/diagnostics", self._on_health, 100)

    def unconnected(self) -> list[str]:
        """Topics of the suite that nobody writes or nobody reads yet, or that are not heard here."""
        topics = ["joint_impedance", *(f"{side}/capture_counters" for side in SIDES)]
        if self._case.mode != COMPOSED:
            topics += [f"{side}/{topic}" for side in SIDES for topic in ("force", "encoder", "impedance")]
        names = [f"/{space}/{topic}" for space in self._case.namespaces for topic in topics]
        node = self._node
        alone = [name for name in names if not (node.count_publishers(name) and node.count_subscribers(name))]
        return alone + [ear.topic_name for ear in self._ears if not ear.get_publisher_count()]

    def done(self) -> bool:
        """Whether every rig has sent its last sample."""
        return all(self._rig(space)[0] == "done" for space in self._case.namespaces)

    def progress(self) -> tuple[int, ...]:
        """How much has come of the drivers, and the stamps that the joints have got to."""
        batches = [len(side) for sides in self._counters.values() for side in sides]
        return *batches, *(read_stamp(joint[-1][0]) for joint in self._joints.values() if joint)

    def sent(self, space: str) -> int:
        """Samples that a rig has sent."""
        return int(self._rig(space)[1].get("samples", 0))

    def heard(self, space: str) -> Heard:
        """Everything about one joint."""
        joints = [(*_stamps(data), arrival_ns) for data, arrival_ns in self._joints[space]]
        numbers = [_numbers(batches) for batches in self._counters[space]]
        return Heard(self.sent(space), np.array(joints, np.int64).reshape(-1, 3), numbers[0], numbers[1])

    def _rig(self, space: str) -> tuple[str, dict[str, str]]:
        return self._health.get(f"/{space}/rig_simulator", ("", {}))

    def _on_joint(self, space: str, data: bytes) -> None:
        self._joints[space].append((data, time.time_ns()))

    def _on_counters(self, space: str, side: int, data: bytes) -> None:
        self._counters[space][side].append(data)

    def _on_health(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._health[status.name] = (status.message, {value.key: value.value for value in status.values})


def _stamps(data: bytes) -> tuple[int, int]:
    first_s, first_ns, second_s, second_ns = _STAMPS.read(data)[1]
    return first_s * NANOSECONDS + first_ns, second_s * NANOSECONDS + second_ns


def _numbers(batches: Sequence[bytes]) -> dict[int, int]:
    """Number of each sample by its capture stamp."""
    numbers: dict[int, int] = {}
    for data in batches:
        numbers.update(zip(*read_counters(data), strict=True))
    return numbers
