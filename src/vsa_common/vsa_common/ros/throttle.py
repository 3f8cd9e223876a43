# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A second topic at a reduced rate, so that the cost of a viewer does not depend on the rate of the sensors."""

from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from vsa_common.ros.node import RELIABLE

SUFFIX = "_throttle"  # as topic_tools names it
PERIOD_NS = 20_000_000  # one message for each interval of the stamps: 50 Hz, more than a display needs


class ThrottledPublisher:
    """Publisher of TOPIC and, at a reduced rate, of TOPIC_throttle: the same bytes."""

    def __init__(self, node: Node, kind: Any, topic: str) -> None:
        """Both topics are reliable."""
        self.publishers: tuple[Publisher, Publisher] = (
            node.create_publisher(kind, topic, RELIABLE),
            node.create_publisher(kind, topic + SUFFIX, RELIABLE),
        )
        self._interval, self._state = -1, None

    def publish(self, stamp_ns: int, data: bytes, state: Any = None) -> None:
        """Publish; the throttled topic gets the first message of each interval and each change of `state`."""
        full, throttled = self.publishers
        full.publish(data)
        interval = stamp_ns // PERIOD_NS
        if interval != self._interval or state != self._state:
            self._interval, self._state = interval, state
            throttled.publish(data)
