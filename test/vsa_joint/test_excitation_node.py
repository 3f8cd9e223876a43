# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The excitation node without a ROS graph: the rate of its commands, and those of other nodes."""

from collections import deque
from copy import deepcopy
from dataclasses import replace
from types import SimpleNamespace

import pytest
from rclpy.time import Time
from sensor_msgs.msg import JointState
from vsa_joint.excitation.settings import ExcitationConfig
from vsa_joint.excitation.tuning import OWN_COMMANDS
from vsa_joint.excitation_node import ExcitationNode


class Node(ExcitationNode):
    """Records the periods of its timers [s] and its commands; its ROS clock stands still, as a simulated one may."""

    def __init__(self):
        self.timers_made, self.destroyed, self.sent = [], [], []
        self._timer = self.create_timer(0.01, None)
        self._own_stamps, self._foreign_ns = deque(maxlen=OWN_COMMANDS), None
        self._message, self._commands = (
            JointState(),
            SimpleNamespace(publish=lambda one: self.sent.append(deepcopy(one))),
        )

    def get_clock(self):
        return SimpleNamespace(now=lambda: Time(seconds=5))

    def create_timer(self, period, *_, **__):
        self.timers_made.append(period)
        return period

    def destroy_timer(self, timer):
        self.destroyed.append(timer)


def test_a_changed_rate_is_that_of_the_next_commands():
    node = Node()
    node.reconfigure(replace(ExcitationConfig(), rate=250.0))
    assert node.timers_made[-1] == pytest.approx(0.004)
    assert node.destroyed == node.timers_made[:-1]


def test_commands_with_one_stamp_are_all_own_and_one_more_is_of_another_node():
    node = Node()
    for k in range(3):
        node._command((0.1 * k, 0.2))
    for echo in node.sent:
        node._on_command(echo)
    assert node._foreign_ns is None
    node._on_command(node.sent[0])
    assert node._foreign_ns is not None


def test_commands_whose_echoes_are_lost_take_no_more_memory_than_a_limit():
    node = Node()
    for _ in range(3 * OWN_COMMANDS):
        node._command((0.0, 0.0))
    assert len(node._own_stamps) == OWN_COMMANDS
    node._on_command(node.sent[-1])
    assert node._foreign_ns is None
