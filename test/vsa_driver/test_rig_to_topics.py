# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Simulated rig and driver as two processes with a CAN bus between them, against the rig's ground truth."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rclpy.experimental import EventsExecutor
from sensor_msgs.msg import JointState
from services import answer_of
from std_srvs.srv import SetBool, Trigger
from vsa_common.io.tables import read_columns
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import nanoseconds
from vsa_msgs.msg import CaptureCounters

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 40) % 80
RATE_HZ, SAMPLES = 200, 900
BUS = f"bus.options:=['hop_limit=0','port={43000 + os.getpid() % 1000}']"
WRAPS_AT_M = 0.011  # deflection at which the encoder's count wraps, in the middle of the motion
MODULES = {"driver": "vsa_driver.node", "rig_simulator": "vsa_simulator.node"}


def start(name, *parameters):
    arguments = [word for parameter in (BUS, *parameters) for word in ("-p", parameter)]
    environment = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return subprocess.Popen([sys.executable, "-m", MODULES[name], "--ros-args", *arguments], env=environment)


class Subscriber:
    """Subscriber to the samples of both transmissions."""

    def __init__(self):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("subscriber", namespace="vsa", context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.motors = []
        self.samples = {
            name: {"force": {}, "encoder": {}, "sequence": {}} for name in ("transmission_1", "transmission_2")
        }
        for name, received in self.samples.items():
            self.subscribe(
                WrenchStamped, f"{name}/force", lambda m, r=received: r["force"].update({stamp(m): m.wrench.force.x})
            )
            self.subscribe(
                JointState, f"{name}/encoder", lambda m, r=received: r["encoder"].update({stamp(m): m.position[0]})
            )
            self.subscribe(
                CaptureCounters, f"{name}/capture_counters", lambda m, r=received: r["sequence"].update(numbers(m))
            )
        self.subscribe(JointState, "motor_states", lambda m: self.motors.append(list(m.position)))
        self.reporters = set()
        self.subscribe(DiagnosticArray, "/diagnostics", lambda m: self.reporters.update(s.name for s in m.status))

    def subscribe(self, kind, topic, callback):
        self.node.create_subscription(kind, topic, callback, RELIABLE)

    def until(self, condition, timeout=40.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, "timeout"
            self.executor.spin_once(timeout_sec=0.01)

    def call(self, kind, service, request):
        return answer_of(self.node, self.until, kind, service, request)

    def connected(self):
        """Whether the driver has discovered this node: discovery is in order, and /diagnostics is subscribed last."""
        return "/vsa/driver: bus" in self.reporters


def stamp(message):
    return nanoseconds(message.header.stamp)


def numbers(message):
    return {nanoseconds(at): number for at, number in zip(message.stamp, message.counter, strict=True)}


@pytest.fixture
def subscriber(tmp_path):
    _, rig = processes = [
        start("driver", f"transmission_1.encoder_offset:={WRAPS_AT_M}", f"transmission_2.encoder_offset:={WRAPS_AT_M}"),
        start(
            "rig_simulator", f"rate_hz:={RATE_HZ}", f"duration:={SAMPLES / RATE_HZ}", "autostart_clock:=false",
            f"truth_file:={tmp_path / 'truth.csv'}", f"sensors.encoder_start:={65536 - round(WRAPS_AT_M * 1e5)}",
            "profile.kind:=hold",
        ),
    ]  # fmt: skip
    subscriber = Subscriber()

    def end_rig():
        rig.send_signal(signal.SIGINT)
        return rig.wait(10.0)

    subscriber.end_rig = end_rig
    yield subscriber
    for process in processes:
        process.send_signal(signal.SIGINT)
    codes = [process.wait(10.0) for process in processes]
    subscriber.node.destroy_node()
    rclpy.shutdown(context=subscriber.context)
    assert codes == [0, 0]


def test_every_sample_of_the_rig_arrives_with_its_sequence_number_and_armed_motors_follow_commands(
    subscriber, tmp_path
):
    subscriber.until(subscriber.connected)
    assert subscriber.call(Trigger, "rig_simulator/start", Trigger.Request()).success
    subscriber.until(lambda: len(subscriber.motors) > 5)
    at_first = subscriber.motors[-1]
    assert subscriber.call(SetBool, "driver/arm", SetBool.Request(data=True)).success
    commands = subscriber.node.create_publisher(JointState, "motor_commands", RELIABLE)
    goal = [at_first[0] + 0.3, at_first[1] + 0.3]
    begin = time.monotonic()
    while (elapsed := time.monotonic() - begin) < 2.0:
        part = min(elapsed, 1.0)
        now = [first + part * (last - first) for first, last in zip(at_first, goal, strict=True)]
        commands.publish(JointState(name=["motor_2", "motor_1"], position=now[::-1]))
        subscriber.executor.spin_once(timeout_sec=0.01)
    np.testing.assert_allclose(subscriber.motors[-1], goal, atol=2e-3)

    subscriber.until(lambda: all(len(received["sequence"]) == SAMPLES for received in subscriber.samples.values()))
    assert subscriber.end_rig() == 0  # its truth is complete when it has ended
    truth = read_columns(tmp_path / "truth.csv", ["force_1", "force_2", "deflection_1", "deflection_2"])
    for i, received in enumerate(subscriber.samples.values(), 1):
        assert sorted(received["sequence"].values()) == list(range(SAMPLES))
        assert received["force"].keys() == received["encoder"].keys() == received["sequence"].keys()
        order = sorted(received["sequence"], key=received["sequence"].get)
        force_error = np.array([received["force"][at] for at in order]) - truth[f"force_{i}"]
        deflection_error = np.array([received["encoder"][at] for at in order]) - truth[f"deflection_{i}"]
        assert np.ptp(truth[f"deflection_{i}"]) > 5e-4
        assert np.abs(force_error).max() < 6 * 0.017
        assert np.std(force_error) == pytest.approx(0.017, rel=0.15)
        assert np.abs(deflection_error).max() < 6e-5 + 1e-5
    assert np.min(truth["deflection_1"]) < WRAPS_AT_M < np.max(truth["deflection_1"])
