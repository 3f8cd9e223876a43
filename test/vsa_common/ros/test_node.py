# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Base class of the nodes: transitions, log, diagnostics and QoS overrides, with a second node that observes them."""

import gc
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Log
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import ReliabilityPolicy
from std_msgs.msg import String
from vsa_common.config.configuration import ConfigurationError, quantity, string
from vsa_common.ros.node import ERROR, OK, RELIABLE, WARN, StartRefused, SuiteNode

DOMAIN = 20 + (os.getpid() + 40) % 80
ENVIRONMENT = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@dataclass(frozen=True)
class Example:
    device: str = string("", "file that must exist")
    gain: float = quantity(1.0, "", 0.0, 10.0, "gain")


class ExampleNode(SuiteNode):
    """Needs the file `device`."""

    def __init__(self):
        super().__init__("example", Example)
        self.level = OK

    def configure(self):
        with open(self.config.device):
            pass

    def start(self):
        if self.config.gain > 5.0:
            raise ConfigurationError("gain too high")
        self.publisher = self.create_publisher(String, "text", RELIABLE)

    def stop(self):
        self.destroy_publisher(self.publisher)

    def health(self):
        return {"device": (self.level, "text", {"count": 1}), "output": (OK, "active", {})}

    @property
    def tasks(self):
        return "device", "output"

    @property
    def activity(self):
        return self.config.device


class Observer:
    """Receives log and diagnostics of the node under test, and spins both."""

    def __init__(self):
        self.node = rclpy.create_node("observer")
        self.executor = EventsExecutor()
        self.executor.add_node(self.node)
        self.log, self.statuses, self.arrays = [], {}, 0
        self.node.create_subscription(Log, "/rosout", self.log.append, 100)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.on_diagnostics, 100)

    def on_diagnostics(self, array):
        self.arrays += 1
        self.statuses |= {status.name: status for status in array.status}

    def until(self, condition, timeout=20.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, self.lines()
            self.executor.spin_once(timeout_sec=0.01)

    def lines(self):
        return [f"{bytes([line.level])[0] // 10} {line.msg}" for line in self.log if line.name == "vsa.example"]

    def level(self, task):
        status = self.statuses.get(f"/vsa/example: {task}")
        return None if status is None else ord(status.level)


@pytest.fixture
def start(monkeypatch):
    observers, nodes = [], []
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")

    def start(*parameters):
        arguments = ["example", "--ros-args", *(word for one in parameters for word in ("-p", one))]
        monkeypatch.setattr(sys, "argv", arguments)
        rclpy.init(args=arguments, domain_id=DOMAIN)
        observers.append(Observer())
        nodes.append(ExampleNode())
        observers[0].executor.add_node(nodes[0])
        return nodes[0], observers[0]

    start.observers = observers
    yield start
    for node in nodes:
        node.close()
        node.destroy_node()
    gc.collect()  # rcl finds /rosout's publisher by the node's name: a node released later would remove its successor's
    rclpy.try_shutdown()


def test_each_transition_is_one_line_and_a_change_of_level_too(start, tmp_path):
    device = tmp_path / "device"
    device.touch()
    node, seen = start(f"device:={device}")
    node.trigger_configure()
    node.trigger_activate()
    seen.until(lambda: seen.level("device") == OK)
    node.level = ERROR
    seen.until(lambda: seen.level("device") == ERROR)
    node.level = OK
    seen.until(lambda: "2 device: text" in seen.lines())
    node.trigger_deactivate()
    node.trigger_cleanup()
    expected = [
        "2 configured", f"2 active: {device}", "4 device: text", "2 device: text", "2 inactive", "2 unconfigured",
    ]  # fmt: skip
    seen.until(lambda: len(seen.lines()) >= len(expected))
    assert seen.lines() == expected


def test_a_status_has_the_name_node_task_the_hardware_and_its_own_values(start, tmp_path):
    (tmp_path / "device").touch()
    node, seen = start(f"device:={tmp_path}/device")
    node.autostart()
    seen.until(lambda: seen.level("device") == OK)
    assert set(seen.statuses) == {f"/vsa/example: {task}" for task in ("device", "output", "topics")}
    assert {status.hardware_id for status in seen.statuses.values()} == {"vsa"}
    status = seen.statuses["/vsa/example: device"]
    assert [(pair.key, pair.value) for pair in status.values] == [("count", "1")]


def test_a_failed_configuration_and_a_failed_activation_are_errors_until_they_succeed(start, tmp_path):
    device = tmp_path / "device"
    node, seen = start(f"device:={device}", "autostart:=false", "gain:=9.0")
    node.trigger_configure()
    seen.until(lambda: seen.level("device") == ERROR)
    assert "No such file" in seen.statuses["/vsa/example: device"].message
    assert seen.level("output") == OK
    device.touch()
    node.trigger_configure()
    seen.until(lambda: seen.level("device") == OK)
    assert seen.statuses["/vsa/example: device"].message == "inactive"
    node.trigger_activate()
    seen.until(lambda: seen.level("device") == ERROR)
    assert seen.statuses["/vsa/example: device"].message == "gain too high"
    assert node.set_parameters_atomically([Parameter("gain", value=2.0)]).successful
    node.trigger_activate()
    seen.until(lambda: seen.level("device") == OK)


@pytest.mark.parametrize(
    ("parameters", "text"),
    [(("gain:=99.0",), "gain = 99.0: must be within"), (("device:=/nowhere",), "No such file")],
)
def test_a_node_that_cannot_start_has_its_reason_in_rosout(start, parameters, text):
    with pytest.raises(StartRefused, match=text):
        start(*parameters)[0].autostart()
    seen = start.observers[0]
    seen.until(lambda: any(text in line for line in seen.lines()))
    assert next(line for line in seen.lines() if text in line)[0] in "45"  # ERROR or FATAL


def test_qos_overrides_change_the_policies(start, tmp_path):
    (tmp_path / "device").touch()
    override = "qos_overrides./vsa/text.publisher"
    node, seen = start(f"device:={tmp_path}/device", f"{override}.reliability:=best_effort", f"{override}.depth:=7")
    for _ in range(2):  # again after a deactivation
        node.trigger_configure() if not node.active else node.trigger_deactivate()
        node.trigger_activate()
        (publisher,) = (one for one in node.publishers if one.topic_name == "/vsa/text")
        assert (publisher.qos_profile.reliability, publisher.qos_profile.depth) == (ReliabilityPolicy.BEST_EFFORT, 7)
    seen.until(lambda: seen.node.get_publishers_info_by_topic("/vsa/text"))
    (info,) = seen.node.get_publishers_info_by_topic("/vsa/text")
    assert info.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT
    assert (RELIABLE.reliability, RELIABLE.depth) == (ReliabilityPolicy.RELIABLE, 1000)  # of all other topics


def test_an_unexpected_error_in_a_transition_is_reported_with_its_type(start, tmp_path):
    (tmp_path / "device").touch()
    node, seen = start(f"device:={tmp_path}/device", "qos_overrides./vsa/text.publisher.reliability:=best_efort")
    with pytest.raises(StartRefused, match=r"Error\(.*best_efort"):
        node.autostart()
    seen.until(lambda: any("best_efort" in line for line in seen.lines()))
    seen.until(lambda: seen.level("device") == ERROR)
    assert "best_efort" in seen.statuses["/vsa/example: device"].message


PROCESS = """
import sys
from test_node import ExampleNode
from vsa_common.ros.process import run
sys.exit(run(ExampleNode))
"""


@pytest.mark.live
def test_repeated_signals_do_not_change_the_exit_code(tmp_path):
    (tmp_path / "device").touch()
    environment = ENVIRONMENT | {"PYTHONPATH": f"{os.path.dirname(__file__)}:{os.environ.get('PYTHONPATH', '')}"}
    command = [sys.executable, "-c", PROCESS, "--ros-args", "-p", f"device:={tmp_path}/device"]
    processes = [subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) for _ in range(4)]
    try:
        for process in processes:
            while "active" not in process.stderr.readline():
                assert process.poll() is None
        while any(process.poll() is None for process in processes):
            for process in processes:
                process.send_signal(signal.SIGINT)
            time.sleep(0.001)
        assert [process.returncode for process in processes] == [0, 0, 0, 0]
    finally:
        for process in processes:
            process.kill()


def test_levels_are_those_of_the_message():
    assert (OK, WARN, ERROR) == (0, 1, 2)
