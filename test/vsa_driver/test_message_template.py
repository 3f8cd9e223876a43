# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import pytest
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from vsa_driver.message_template import MessageTemplate

FINITE = st.floats(allow_nan=False)
STAMP_NS = st.integers(0, (2**31 - 1) * 1_000_000_000 + 999_999_999)


@settings(deadline=None)
@given(STAMP_NS, FINITE, FINITE, st.sampled_from(["", "m", "transmission_1", "a longer name of a frame"]))
def test_rclpy_reads_a_rendered_message(stamp_ns, one, two, frame):
    message = JointState(header=Header(frame_id=frame), name=["motor_1", "motor_2"], position=[1.5e-200, 2.5e-200])
    read = deserialize_message(MessageTemplate(message, [1.5e-200, 2.5e-200]).render(stamp_ns, one, two), JointState)
    assert (read.header.stamp.sec, read.header.stamp.nanosec) == divmod(stamp_ns, 1_000_000_000)
    assert (list(read.position), list(read.name), read.header.frame_id) == ([one, two], ["motor_1", "motor_2"], frame)


def test_rendering_changes_neither_other_fields_nor_earlier_messages():
    message = WrenchStamped(header=Header(frame_id="joint"), wrench=Wrench(torque=Vector3(x=3.0, z=1.5e-200)))
    template = MessageTemplate(message, [1.5e-200])
    first, second = template.render(5, -1.0), template.render(6, 2.0)
    torques = [deserialize_message(data, WrenchStamped).wrench.torque for data in (first, second)]
    assert [(torque.x, torque.z) for torque in torques] == [(3.0, -1.0), (3.0, 2.0)]


def test_a_placeholder_that_is_not_unique_in_the_message_is_refused():
    with pytest.raises(ValueError, match="once"):
        MessageTemplate(JointState(name=["a"], position=[0.0]), [7.0])
    with pytest.raises(ValueError, match="once"):
        MessageTemplate(JointState(name=["a", "b"], position=[7.0, 7.0]), [7.0])
