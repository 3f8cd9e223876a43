# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The recorder as a process: orderly end on signals, readable bag after a crash."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from vsa_common.io import bags
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.subprocesses import executable
from vsa_msgs.msg import CaptureCounters
from vsa_tools.demo.isolation import claim_domain

pytestmark = pytest.mark.live

TOPIC, FOREIGN = "/vsa/motor_commands", "/arm/joint_states"
COUNT = 400


@pytest.fixture(scope="module")
def domain():
    isolated = claim_domain()
    with pytest.MonkeyPatch.context() as patch:
        for name, value in isolated.environment().items():
            patch.setenv(name, value)
        yield isolated


@pytest.fixture(scope="module")
def node(domain):
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    yield rclpy.create_node("publisher")
    rclpy.try_shutdown()


def record(out, *arguments: str) -> subprocess.Popen:
    command = [executable("vsa_tools", "record"), "--out", str(out), *arguments]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ)


def publish(node, topic: str, process: subprocess.Popen, bag: Path) -> None:
    """Publish 0, 1, 2, ... after the first messages (-1) have arrived in the bag."""
    publisher = node.create_publisher(JointState, topic, RELIABLE)
    end = time.monotonic() + 60.0
    initial_size = 0
    while not initial_size or size(bag) < initial_size + 20_000:
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end
        initial_size = initial_size or size(bag)
        publisher.publish(JointState(name=["motor_1"], position=[-1.0]))
        rclpy.spin_once(node, timeout_sec=0.002)
    for k in range(COUNT):
        publisher.publish(JointState(name=["motor_1"], position=[float(k)]))
        time.sleep(0.001)  # the rate of a sensor
    publisher.wait_for_all_acked(Duration(seconds=10))
    time.sleep(0.3)
    node.destroy_publisher(publisher)


def size(bag: Path) -> int:
    return sum(file.stat().st_size for file in bag.glob("*.mcap"))


def counted(bag: Path) -> list[float]:
    return [message.position[0] for _, _, message in bags.read(bag, [TOPIC]) if message.position[0] >= 0.0]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_closes_the_bag_with_every_message_in_it(node, tmp_path, number):
    process = record(tmp_path / "bag")
    publish(node, TOPIC, process, tmp_path / "bag")
    process.send_signal(number)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 0
    assert "0 dropped" in errors
    assert counted(tmp_path / "bag") == [float(k) for k in range(COUNT)]
    assert (tmp_path / "bag" / "metadata.yaml").exists()


def test_forces_that_the_driver_has_published_and_that_do_not_arrive_are_counted(node, tmp_path):
    bag, absent = tmp_path / "bag", 500
    process = record(bag, "--ros-args", "-p", "flush_period:=0.1")
    topic, end, warnings = "/vsa/transmission_1/capture_counters", time.monotonic() + 60.0, []
    counters = node.create_publisher(CaptureCounters, topic, RELIABLE)
    node.create_subscription(DiagnosticArray, "/diagnostics", lambda m: warnings.extend(not_received(m)), RELIABLE)
    while not size(bag) or not next(bags.read(bag, [topic]), None):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end
        counters.publish(CaptureCounters(stamp=[Time(sec=1)], counter=[0]))
        rclpy.spin_once(node, timeout_sec=0.05)
    stamps = [*(Time(sec=10, nanosec=1_000_000 * k) for k in range(absent)), Time(sec=20)]
    counters.publish(CaptureCounters(stamp=stamps, counter=list(range(len(stamps)))))
    while not warnings:
        assert time.monotonic() < end
        rclpy.spin_once(node, timeout_sec=0.1)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert warnings[-1] == str(absent)
    assert f", {absent} forces not received" in errors


def not_received(message):
    """Forces not received, by the warnings of the recorder."""
    found = (status for status in message.status if status.name == "/vsa/recorder: recording")
    return [
        value.value for one in found if one.level != DiagnosticStatus.OK
        for value in one.values if value.key == "forces_not_received"
    ]  # fmt: skip


def test_a_crash_loses_at_most_one_flush_period(node, tmp_path):
    process = record(tmp_path / "bag", "--ros-args", "-p", "flush_period:=0.1")
    publish(node, TOPIC, process, tmp_path / "bag")
    process.kill()
    process.communicate()
    assert counted(tmp_path / "bag") == [float(k) for k in range(COUNT)]


def test_additional_topics_are_recorded_on_request(node, tmp_path):
    process = record(tmp_path / "bag", "--topic", FOREIGN)
    publish(node, FOREIGN, process, tmp_path / "bag")
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=20)
    assert bags.topics(tmp_path / "bag")[FOREIGN].messages >= COUNT / 2


def test_an_existing_folder_is_a_one_line_error(domain, tmp_path):
    process = record(tmp_path)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 1
    assert "exists already" in errors
    assert "Traceback" not in errors
