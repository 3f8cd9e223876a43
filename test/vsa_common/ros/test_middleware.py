# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The Fast DDS profile of the suite: no shared memory, in which a killed writer blocks its readers."""

import os
import subprocess
import sys

import pytest
from vsa_common.ros.process import tune_middleware

pytestmark = pytest.mark.live

PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
LISTENER = """
import rclpy
from std_msgs.msg import String
from vsa_common.ros.process import tune_middleware
tune_middleware()
rclpy.init()
node, received = rclpy.create_node("listener"), []
node.create_subscription(String, "texts", received.append, 10)
while not received:
    rclpy.spin_once(node, timeout_sec=0.1)
print("/dev/shm/fastrtps" in open("/proc/self/maps").read())
"""
SPEAKER = """
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("speaker")
publisher = node.create_publisher(String, "texts", 10)
node.create_timer(0.05, lambda: publisher.publish(String(data="word")))
rclpy.spin(node)
"""


def test_a_process_of_the_suite_receives_from_any_local_process_without_shared_memory():
    environment = os.environ | {"ROS_DOMAIN_ID": str(20 + (os.getpid() + 70) % 80), RANGE: "LOCALHOST"}
    environment.pop(PROFILE, None)
    speaker = subprocess.Popen([sys.executable, "-c", SPEAKER], env=environment)
    try:
        listener = [sys.executable, "-c", LISTENER]
        received = subprocess.run(listener, env=environment, capture_output=True, text=True, timeout=60, check=True)
    finally:
        speaker.kill()
        speaker.wait()
    assert received.stdout.split() == ["False"]


def test_a_profile_or_static_peers_of_the_user_take_precedence(monkeypatch):
    monkeypatch.setenv(RANGE, "LOCALHOST")
    monkeypatch.setenv(PROFILE, "mine.xml")
    tune_middleware()
    assert os.environ[PROFILE] == "mine.xml"
    assert os.environ[RANGE] == "LOCALHOST"
    monkeypatch.delenv(PROFILE)
    monkeypatch.setenv("ROS_STATIC_PEERS", "127.0.0.2")
    tune_middleware()
    assert os.environ[RANGE] == "LOCALHOST"
