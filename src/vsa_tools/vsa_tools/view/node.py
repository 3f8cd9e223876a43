"""The live page's ears: the suite's topics, taken in a few microseconds a message and without an executor."""

import os
import re
import time
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from vsa_common.ros.cdr import read_position
from vsa_common.ros.node import STEADY
from vsa_common.ros.throttle import SUFFIX
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance
from vsa_tools.topics import suite_topics
from vsa_tools.view.reason import QUIET, why_no_data
from vsa_tools.view.view_model import Show

DEPTH = 4000  # messages that wait while this computer is busy elsewhere
WATCH = 0.1  # seconds between two looks for silence
_WATCHING = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)  # never holds a controller up
_COUNTING = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)  # what is lost here is no lost frame
_JOINT = re.compile(r"(?P<space>.*)/(joint_impedance|transmission_\d/impedance)")
_KINDS = ("vsa_msgs/msg/JointImpedance", "vsa_msgs/msg/TransmissionImpedance")

Taker = Callable[[bytes, int, float], None]


class Ear:
    """Subscriptions of one joint's topics, emptied by `poll`."""

    def __init__(self, node: Node, space: str) -> None:
        self.space = space
        kinds = (TransmissionImpedance, EstimatorState, JointImpedance)
        self.show = Show(*(kind.get_fields_and_field_types() for kind in kinds))
        self._node = node
        self._takers: dict[str, tuple[Any, Taker]] = {}
        self._watched = 0.0
        self._throttled: list[tuple[Any, str, Any]] = [
            (JointImpedance, "joint_impedance", self.show.joint.take_impedance),
            (JointState, "joint_states", self._take_angle),
        ]
        self._listen(DiagnosticArray, "/diagnostics", self._take_diagnostics)
        for name in self.show.sides:
            self._listen_to_side(name)

    def poll(self) -> None:
        """Take everything that has arrived."""
        now = 1e-9 * STEADY.now().nanoseconds
        for subscription, take in self._takers.values():
            with subscription.handle:
                while (found := subscription.handle.take_message(subscription.msg_type, True)) is not None:
                    take(found[0], found[1]["received_timestamp"], now)
        if now - self._watched > WATCH:
            self._watched = now
            self._look_for_slower_topics()
            self.show.watch(now, time.time_ns())

    def words(self) -> dict[str, Any]:
        """As Show.words, now, with the reasons where nothing comes."""
        now = 1e-9 * STEADY.now().nanoseconds
        words = self.show.words(now)
        ages = self.show.ages(now)
        status = {part: words[part]["status"] for part in ages}
        if any(word in QUIET for word in status.values()):
            domain = os.environ.get("ROS_DOMAIN_ID", "0")
            words["no_data"] = why_no_data(self.space, domain, status, ages, self._published())
        return words

    def _published(self) -> set[str]:
        """The joint's topics that somebody publishes, relative to its namespace."""
        names = (topic for topic in suite_topics(self.space) if topic.startswith(f"{self.space}/"))
        return {topic.removeprefix(f"{self.space}/") for topic in names if self._node.count_publishers(topic)}

    def _listen_to_side(self, name: str) -> None:
        side = self.show.sides[name]
        self._throttled.append(
            (TransmissionImpedance, f"{name}/impedance", lambda data, _, now: side.take_impedance(data, now))
        )
        self._listen(EstimatorState, f"{name}/estimator_state", lambda data, *_: side.take_state(data))
        self._listen(CaptureCounters, f"{name}/capture_counters", lambda data, *_: side.take_counters(data), _COUNTING)

    def _listen(self, kind: Any, topic: str, take: Any, qos: QoSProfile = _WATCHING) -> None:
        name = topic if topic.startswith("/") else f"{self.space}/{topic}"
        self._takers[topic] = self._node.create_subscription(kind, name, print, qos, raw=True), take

    def _look_for_slower_topics(self) -> None:
        """Listen at a viewer's pace where somebody publishes so; to the whole topic of an older bag, say."""
        for kind, topic, take in self._throttled:
            slower = topic + SUFFIX
            for one, other in ((slower, topic), (topic, slower)):
                if self._node.count_publishers(f"{self.space}/{one}"):
                    if one not in self._takers:
                        self._listen(kind, one, take)
                    if other in self._takers:
                        self._node.destroy_subscription(self._takers.pop(other)[0])
                    break

    def _take_angle(self, data: bytes, *_: object) -> None:
        self.show.joint.angle = read_position(data)[1]

    def _take_diagnostics(self, data: bytes, received_ns: int, _: float) -> None:
        self.show.take_diagnostics(deserialize_message(data, DiagnosticArray), received_ns, f"{self.space}/")


class Ears:
    """The joints of this machine; each is listened to from when a page first asks for it."""

    def __init__(self, namespace: str) -> None:
        self._node = Node("view", namespace=namespace)
        self.space = self._node.get_namespace().rstrip("/")
        self._ears = {self.space: Ear(self._node, self.space)}

    def joints(self) -> list[str]:
        """Namespaces of the joints that publish, and of the one that was asked for."""
        found = {self.space}
        for topic, kinds in self._node.get_topic_names_and_types():
            match = _JOINT.fullmatch(topic)
            if match and kinds[0] in _KINDS:
                found.add(match["space"])
        return sorted(found)

    def ear(self, space: str) -> Ear:
        """The ear at the joint `space`. Raises LookupError for one that does not exist."""
        if space not in self._ears:
            if space not in self.joints():
                raise LookupError(f"no joint {space}")
            self._ears[space] = Ear(self._node, space)
        return self._ears[space]

    def poll(self) -> None:
        """Take everything that has arrived."""
        for ear in list(self._ears.values()):
            ear.poll()

    def close(self) -> None:
        """Stop listening."""
        self._node.destroy_node()
