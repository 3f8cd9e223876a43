"""Processes of the suite share no memory with others: who is killed while writing there leaves its readers asleep."""

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
node, heard = rclpy.create_node("listener"), []
node.create_subscription(String, "words", heard.append, 10)
while not heard:
    rclpy.spin_once(node, timeout_sec=0.1)
print("/dev/shm/fastrtps" in open("/proc/self/maps").read())
"""
SPEAKER = """
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("speaker")
publisher = node.create_publisher(String, "words", 10)
node.create_timer(0.05, lambda: publisher.publish(String(data="word")))
rclpy.spin(node)
"""


def test_a_process_of_the_suite_hears_a_stranger_on_this_machine_without_shared_memory():
    environment = os.environ | {"ROS_DOMAIN_ID": str(20 + (os.getpid() + 70) % 80), RANGE: "LOCALHOST"}
    environment.pop(PROFILE, None)
    speaker = subprocess.Popen([sys.executable, "-c", SPEAKER], env=environment)
    try:
        listener = [sys.executable, "-c", LISTENER]
        heard = subprocess.run(listener, env=environment, capture_output=True, text=True, timeout=60, check=True)
    finally:
        speaker.kill()
        speaker.wait()
    assert heard.stdout.split() == ["False"]


def test_a_file_of_the_users_own_wins_and_so_do_peers_that_are_named(monkeypatch):
    monkeypatch.setenv(RANGE, "LOCALHOST")
    monkeypatch.setenv(PROFILE, "mine.xml")
    tune_middleware()
    assert os.environ[PROFILE] == "mine.xml"
    assert os.environ[RANGE] == "LOCALHOST"
    monkeypatch.delenv(PROFILE)
    monkeypatch.setenv("ROS_STATIC_PEERS", "127.0.0.2")
    tune_middleware()
    assert os.environ[RANGE] == "LOCALHOST"
