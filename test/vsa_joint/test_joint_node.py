# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The reachable stiffness of the joint node without a ROS graph; the steady clock is that of the test."""

import math
from types import SimpleNamespace

import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.node import JointNode
from vsa_joint.settings import JointConfig

MS = 1_000_000
SPRINGS = (
    ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    ExponentialSpring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)


class Node(JointNode):
    """With both springs and 25 N of tension in each tendon."""

    config = JointConfig()

    def __init__(self):
        self._joint, self._motor_map = self.config.joint, MotorMap(self.config)
        self._motors, self._motors_ns = b"", 0

    def reachable(self):
        return self._reachable(SPRINGS, SimpleNamespace(motion_torque=0.0, tension=(25.0, 25.0)))


@pytest.fixture
def clock(monkeypatch):
    now = SimpleNamespace(ns=10_000 * MS)
    monkeypatch.setattr("vsa_joint.node.time", SimpleNamespace(monotonic_ns=lambda: now.ns))
    return now


def test_the_reachable_stiffness_is_not_valid_while_measured_motors_are_silent(clock):
    node = Node()
    message = serialize_message(JointState(name=["motor_1", "motor_2"], position=[2.6, 2.2]))
    node._on_motors(message)
    assert node.reachable() is not None
    clock.ns += 50 * MS
    assert node.reachable() is not None
    clock.ns += 100 * MS
    assert node.reachable() is None
    node._on_motors(message)
    assert node.reachable() is not None


def test_without_measured_motors_the_range_is_that_of_springs_and_tendons(clock):
    assert Node().reachable() is not None
