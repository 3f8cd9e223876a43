"""Topics whose policies do not fit, in a process of its own: what a node must outlive there ends one."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.live

MEETING = """
import sys
import time

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from vsa_common.config.declared import Common
from vsa_common.ros.node import SuiteNode

LASTING = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Listener(SuiteNode):
    def start(self):
        self.ears = self.create_subscription(String, "heard", print, LASTING)
        self.mouth = self.create_publisher(String, "said", 1)

    def stop(self):
        self.destroy_subscription(self.ears)
        self.destroy_publisher(self.mouth)


def spin(enough, seconds):
    end = time.monotonic() + seconds
    while not enough() and time.monotonic() < end:
        executor.spin_once(0.02)


rclpy.init()
node, peer = Listener("listener", Common), rclpy.create_node("peer", namespace="vsa")
executor = EventsExecutor()
executor.add_node(node)
node.trigger_configure()
for _ in range(3):
    node.trigger_activate()
    spin(lambda: False, 0.1)
    speaker, deaf = peer.create_publisher(String, "heard", 1), peer.create_subscription(String, "said", print, LASTING)
    while not (peer.count_subscribers("heard") and peer.count_publishers("said")):
        time.sleep(0.01)
    if "stopping" in sys.argv:
        time.sleep(0.1)  # the policies are news to a node that does not spin
    else:
        spin(lambda: len(node._unheard) == 2, 20.0)
        print(node._incompatible())
    node.trigger_deactivate()
    peer.destroy_publisher(speaker)
    peer.destroy_subscription(deaf)
    spin(lambda: not node._unheard, 5.0)
    print(node._incompatible())
"""


def meet(*arguments):
    environment = os.environ | {"ROS_DOMAIN_ID": "23", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-c", MEETING, *arguments]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    return run.stdout.splitlines()


def test_a_node_names_the_policy_and_forgets_who_has_gone():
    said = meet()
    assert len(said) == 6
    for apart, gone in zip(said[::2], said[1::2], strict=True):
        assert sorted(apart.split("; ")) == [
            "/vsa/heard: another node's durability does not fit",
            "/vsa/said: another node's durability does not fit",
        ]
        assert gone == ""


def test_a_node_outlives_news_of_a_topic_that_it_has_closed():
    assert meet("stopping") == [""] * 3
