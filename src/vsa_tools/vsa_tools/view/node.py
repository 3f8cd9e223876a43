# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Subscriptions of the live page: polled without an executor, a few microseconds per message."""

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
from vsa_tools.view.no_data import NO_DATA, no_data_reasons
from vsa_tools.view.view_model import ViewModel

DEPTH = 4000  # messages of a queue: a stall of 4 s at 1 kHz
CHECK_PERIOD_S = 0.1  # [s] between two checks for timeouts and throttled topics
_BEST_EFFORT = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)  # no back-pressure on publishers
_RELIABLE = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)  # a lost message would count as lost frames
_JOINT = re.compile(r"(?P<namespace>.*)/(joint_impedance|transmission_\d/impedance)")
_KINDS = ("vsa_msgs/msg/JointImpedance", "vsa_msgs/msg/TransmissionImpedance")

Handler = Callable[[bytes, int, float], None]


class Subscriber:
    """Subscriptions of one joint's topics; `poll` processes their messages."""

    def __init__(self, node: Node, namespace: str) -> None:
        self.namespace = namespace
        kinds = (TransmissionImpedance, EstimatorState, JointImpedance)
        self.model = ViewModel(*(kind.get_fields_and_field_types() for kind in kinds))
        self._node = node
        self._handlers: dict[str, tuple[Any, Handler]] = {}
        self._checked = 0.0
        self._throttled_topics: list[tuple[Any, str, Any]] = [
            (JointImpedance, "joint_impedance", self.model.joint.add_impedance),
            (JointState, "joint_states", self._add_angle),
        ]
        self._subscribe(DiagnosticArray, "/diagnostics", self._add_diagnostics)
        for name in self.model.transmissions:
            self._subscribe_transmission(name)

    def poll(self) -> None:
        """Process all messages that have arrived."""
        now = 1e-9 * STEADY.now().nanoseconds
        for subscription, handler in self._handlers.values():
            with subscription.handle:
                while (message := subscription.handle.take_message(subscription.msg_type, True)) is not None:
                    handler(message[0], message[1]["received_timestamp"], now)
        if now - self._checked > CHECK_PERIOD_S:
            self._checked = now
            self._select_throttled_topics()
            self.model.check_timeouts(now, time.time_ns())

    def to_json(self) -> dict[str, Any]:
        """As ViewModel.to_json, with the reasons for missing data."""
        now = 1e-9 * STEADY.now().nanoseconds
        state = self.model.to_json(now)
        ages = self.model.ages(now)
        status = {source: state[source]["status"] for source in ages}
        if any(label in NO_DATA for label in status.values()):
            domain = os.environ.get("ROS_DOMAIN_ID", "0")
            state["no_data"] = no_data_reasons(self.namespace, domain, status, ages, self._published())
        return state

    def _published(self) -> set[str]:
        """The joint's topics that have a publisher, relative to its namespace."""
        names = (topic for topic in suite_topics(self.namespace) if topic.startswith(f"{self.namespace}/"))
        return {topic.removeprefix(f"{self.namespace}/") for topic in names if self._node.count_publishers(topic)}

    def _subscribe_transmission(self, name: str) -> None:
        section = self.model.transmissions[name]
        self._throttled_topics.append(
            (TransmissionImpedance, f"{name}/impedance", lambda data, _, now: section.add_impedance(data, now))
        )
        self._subscribe(EstimatorState, f"{name}/estimator_state", lambda data, *_: section.add_state(data))
        self._subscribe(
            CaptureCounters, f"{name}/capture_counters", lambda data, *_: section.add_counters(data), _RELIABLE
        )

    def _subscribe(self, kind: Any, topic: str, handler: Any, qos: QoSProfile = _BEST_EFFORT) -> None:
        name = topic if topic.startswith("/") else f"{self.namespace}/{topic}"
        self._handlers[topic] = self._node.create_subscription(kind, name, print, qos, raw=True), handler

    def _select_throttled_topics(self) -> None:
        """Subscribe to the throttled topic if it has a publisher, else to the full one, as of an older bag."""
        for kind, topic, handler in self._throttled_topics:
            throttled = topic + SUFFIX
            for used, unused in ((throttled, topic), (topic, throttled)):
                if self._node.count_publishers(f"{self.namespace}/{used}"):
                    if used not in self._handlers:
                        self._subscribe(kind, used, handler)
                    if unused in self._handlers:
                        self._node.destroy_subscription(self._handlers.pop(unused)[0])
                    break

    def _add_angle(self, data: bytes, _: int, now: float) -> None:
        self.model.joint.set_angle(read_position(data)[1], now)

    def _add_diagnostics(self, data: bytes, received_ns: int, now: float) -> None:
        message = deserialize_message(data, DiagnosticArray)
        self.model.add_diagnostics(message, received_ns, now, f"{self.namespace}/")


class Subscribers:
    """The joints of this ROS domain; the subscription to a joint starts with its first page."""

    def __init__(self, namespace: str) -> None:
        self._node = Node("view", namespace=namespace)
        self.namespace = self._node.get_namespace().rstrip("/")
        self._subscribers = {self.namespace: Subscriber(self._node, self.namespace)}

    def joints(self) -> list[str]:
        """Namespaces of the joints with a publisher, and the one of the command line."""
        namespaces = {self.namespace}
        for topic, kinds in self._node.get_topic_names_and_types():
            match = _JOINT.fullmatch(topic)
            if match and kinds[0] in _KINDS:
                namespaces.add(match["namespace"])
        return sorted(namespaces)

    def source(self, namespace: str) -> Subscriber:
        """The subscriber of the joint `namespace`. Raises LookupError for an unknown one."""
        if namespace not in self._subscribers:
            if namespace not in self.joints():
                raise LookupError(f"no joint {namespace}")
            self._subscribers[namespace] = Subscriber(self._node, namespace)
        return self._subscribers[namespace]

    def poll(self) -> None:
        """Process all messages that have arrived."""
        for subscriber in list(self._subscribers.values()):
            subscriber.poll()

    def close(self) -> None:
        """End all subscriptions."""
        self._node.destroy_node()
