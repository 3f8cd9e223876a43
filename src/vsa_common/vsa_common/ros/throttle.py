"""A topic once more, slower, for who only looks: what a viewer costs is then no matter of the sensors' rate."""

from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from vsa_common.ros.node import RELIABLE

SUFFIX = "_throttle"  # as topic_tools names it
PERIOD_NS = 20_000_000  # one message for each of these spans of the stamps


class ThrottledPublisher:
    """Publisher of TOPIC and, less often, of TOPIC_throttle: the same bytes."""

    def __init__(self, node: Node, kind: Any, topic: str) -> None:
        """Reliable, both."""
        self.publishers: tuple[Publisher, Publisher] = (
            node.create_publisher(kind, topic, RELIABLE),
            node.create_publisher(kind, topic + SUFFIX, RELIABLE),
        )
        self._span, self._news = -1, None

    def publish(self, stamp_ns: int, data: bytes, news: Any = None) -> None:
        """Publish; viewers get the first message of each span, and every one whose `news` differ."""
        everybody, viewers = self.publishers
        everybody.publish(data)
        span = stamp_ns // PERIOD_NS
        if span != self._span or news != self._news:
            self._span, self._news = span, news
            viewers.publish(data)
