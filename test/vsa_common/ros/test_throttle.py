"""Viewers get one message of each span, and all that is news."""

from types import SimpleNamespace

from vsa_common.ros.throttle import PERIOD_NS, ThrottledPublisher


class Node:
    def __init__(self):
        self.heard = {}

    def create_publisher(self, _, topic, __):
        heard = self.heard[topic] = []
        return SimpleNamespace(publish=heard.append)


def test_all_get_everything_and_viewers_one_of_each_span():
    node = Node()
    topic = ThrottledPublisher(node, object, "angle")
    for k in range(100):
        topic.publish(10**18 + k * PERIOD_NS // 10, k)
    assert node.heard["angle"] == list(range(100))
    assert node.heard["angle_throttle"] == list(range(0, 100, 10))


def test_news_is_not_held_back():
    node = Node()
    topic = ThrottledPublisher(node, object, "impedance")
    for k, status in enumerate("aaabbaaaaa"):
        topic.publish(10**18 + k, k, status)
    assert node.heard["impedance_throttle"] == [0, 3, 5]
