# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Incompatible QoS policies, in a process of its own: their events can end a process (ros2/rclpy#1644)."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.live

SCRIPT = """
import sys
import time

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from vsa_common.ros.parameters import Common
from vsa_common.ros.node import SuiteNode

LASTING = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Listener(SuiteNode):
    def start(self):
        self.subscription = self.create_subscription(String, "input", print, LASTING)
        self.publisher = self.create_publisher(String, "output", 1)

    def stop(self):
        self.destroy_subscription(self.subscription)
        self.destroy_publisher(self.publisher)


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
    publisher = peer.create_publisher(String, "input", 1)
    subscription = peer.create_subscription(String, "output", print, LASTING)
    while not (peer.count_subscribers("input") and peer.count_publishers("output")):
        time.sleep(0.01)
    if "stopping" in sys.argv:
        time.sleep(0.1)  # the events are queued while the node does not spin
    else:
        spin(lambda: len(node._qos_monitor._conflicts) == 2, 20.0)
        print(node._qos_monitor.message)
    node.trigger_deactivate()
    peer.destroy_publisher(publisher)
    peer.destroy_subscription(subscription)
    spin(lambda: not node._qos_monitor._conflicts, 5.0)
    print(node._qos_monitor.message)
"""


def run_script(*arguments):
    environment = os.environ | {"ROS_DOMAIN_ID": "23", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-c", SCRIPT, *arguments]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    return run.stdout.splitlines()


def test_diagnostics_name_the_policy_until_the_other_endpoint_is_destroyed():
    lines = run_script()
    assert len(lines) == 6
    for conflict, after in zip(lines[::2], lines[1::2], strict=True):
        assert sorted(conflict.split("; ")) == [
            "/vsa/input: another node's durability does not fit",
            "/vsa/output: another node's durability does not fit",
        ]
        assert after == ""


def test_an_event_of_a_closed_topic_does_not_end_the_process():
    assert run_script("stopping") == [""] * 3
