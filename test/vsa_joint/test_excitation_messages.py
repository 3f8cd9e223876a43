# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import pytest
from vsa_joint.excitation.settings import ExcitationConfig
from vsa_joint.excitation_messages import goal_of
from vsa_msgs.action import Excite

CONFIG = ExcitationConfig(travel=0.003, speed=0.004, duration=30.0, force_max=100.0)


@pytest.mark.parametrize(("asked", "allowed"), [(0.0, 30.0), (12.0, 12.0), (30.0, 30.0), (600.0, 30.0)])
def test_no_duration_exceeds_the_parameter(asked, allowed):
    assert goal_of(Excite.Goal(duration=asked), CONFIG).duration == allowed


def test_no_travel_speed_or_tension_exceeds_the_parameters():
    goal = goal_of(Excite.Goal(travel=1.0, speed=1.0, tension=500.0), CONFIG)
    assert (goal.travel, goal.speed, goal.force_max) == (0.003, 0.004, 100.0)
