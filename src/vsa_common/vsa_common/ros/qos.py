# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Incompatible QoS policies: publishers and subscriptions of a node that receive no data for that reason.

By comparison of the endpoints and not by rclpy's QoS events: an event that is still queued for a topic that a
transition has closed ends the process (ros2/rclpy#1644).
"""

from itertools import product

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo
from vsa_common.ros.diagnostics import OK, WARN, Health

POLICIES = "reliability", "durability", "deadline", "liveliness", "liveliness_lease_duration"


def _qos_conflict(policy: str, publisher: TopicEndpointInfo, subscription: TopicEndpointInfo) -> bool:
    """Whether this policy alone prevents the connection of publisher and subscription."""
    ends = publisher.qos_profile, subscription.qos_profile
    alone = (QoSProfile(depth=1, **{policy: getattr(profile, policy)}) for profile in ends)
    return qos_check_compatible(*alone)[0] == QoSCompatibility.ERROR


class QosMonitor:
    """Compares the policies of a node's endpoints with those of the other nodes, one endpoint for each call."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._conflicts: dict[Publisher | Subscription, str] = {}  # policies that prevent a connection
        self._index = 0

    def check_next(self) -> bool:
        """Compare the next endpoint; whether it has a conflict that was not reported before."""
        endpoints: list[Publisher | Subscription] = [*self._node.publishers, *self._node.subscriptions]
        self._index = (self._index + 1) % len(endpoints)
        checked = endpoints[self._index]
        before = self._conflicts
        self._conflicts = {one: before[one] for one in endpoints if one in before and one is not checked}
        policies = self._policies_in_conflict(checked)
        if policies:
            self._conflicts[checked] = policies
        return bool(policies) and before.get(checked) != policies

    @property
    def message(self) -> str:
        """Text for the diagnostics; empty without a conflict."""
        return "; ".join(
            f"{one.topic_name}: another node's {policies} does not fit" for one, policies in self._conflicts.items()
        )

    def health(self) -> Health:
        """Diagnostics of the topics: conflicts, and the number of readers that each publisher has."""
        values = {f"readers {one.topic_name}": one.get_subscription_count() for one in self._node.publishers}
        return (WARN, self.message, values) if self._conflicts else (OK, "compatible", values)

    def _policies_in_conflict(self, endpoint: Publisher | Subscription) -> str:
        topic = endpoint.topic_name
        if isinstance(endpoint, Publisher):
            connected = self._node.count_subscribers(topic) <= endpoint.get_subscription_count()
        else:
            connected = self._node.count_publishers(topic) <= endpoint.get_publisher_count()
        if connected:
            return ""
        own = self._node.get_name(), self._node.get_namespace()
        publishers = self._node.get_publishers_info_by_topic(topic)
        pairs = list(product(publishers, self._node.get_subscriptions_info_by_topic(topic)))
        ours = [pair for pair in pairs if own in ((end.node_name, end.node_namespace) for end in pair)]
        conflicts = (policy for policy in POLICIES if any(_qos_conflict(policy, *pair) for pair in ours))
        return ", ".join(conflicts).replace("_", " ")
