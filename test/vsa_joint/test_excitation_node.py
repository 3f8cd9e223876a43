# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The excitation node without a ROS graph: the rate of its commands."""

from dataclasses import replace

import pytest
from vsa_joint.excitation.settings import ExcitationConfig
from vsa_joint.excitation_node import ExcitationNode


class Node(ExcitationNode):
    """Records the periods of its timers [s]."""

    def __init__(self):
        self.timers_made, self.destroyed = [], []
        self._timer = self.create_timer(0.01, None)

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
