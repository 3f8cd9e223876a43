# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The throttled topic: one message of each interval, and every change of state."""

from types import SimpleNamespace

from vsa_common.ros.throttle import PERIOD_NS, ThrottledPublisher


class Node:
    def __init__(self):
        self.published = {}

    def create_publisher(self, _, topic, __):
        published = self.published[topic] = []
        return SimpleNamespace(publish=published.append)


def test_the_throttled_topic_has_one_message_of_each_interval():
    node = Node()
    topic = ThrottledPublisher(node, object, "angle")
    for k in range(100):
        topic.publish(10**18 + k * PERIOD_NS // 10, k)
    assert node.published["angle"] == list(range(100))
    assert node.published["angle_throttle"] == list(range(0, 100, 10))


def test_a_change_of_state_is_published_at_once():
    node = Node()
    topic = ThrottledPublisher(node, object, "impedance")
    for k, status in enumerate("aaabbaaaaa"):
        topic.publish(10**18 + k, k, status)
    assert node.published["impedance_throttle"] == [0, 3, 5]
