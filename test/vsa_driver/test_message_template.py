import pytest
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from vsa_driver.message_template import Prepared

FINITE = st.floats(allow_nan=False)
STAMP_NS = st.integers(0, (2**31 - 1) * 1_000_000_000 + 999_999_999)


@settings(deadline=None)
@given(STAMP_NS, FINITE, FINITE, st.sampled_from(["", "m", "transmission_1", "a longer name of a frame"]))
def test_a_filled_message_is_the_one_that_rclpy_reads(stamp_ns, one, two, frame):
    message = JointState(header=Header(frame_id=frame), name=["motor_1", "motor_2"], position=[1.5e-200, 2.5e-200])
    read = deserialize_message(Prepared(message, [1.5e-200, 2.5e-200]).fill(stamp_ns, one, two), JointState)
    assert (read.header.stamp.sec, read.header.stamp.nanosec) == divmod(stamp_ns, 1_000_000_000)
    assert (list(read.position), list(read.name), read.header.frame_id) == ([one, two], ["motor_1", "motor_2"], frame)


def test_what_is_not_filled_stays_as_it_was_and_earlier_bytes_are_not_touched():
    message = WrenchStamped(header=Header(frame_id="joint"), wrench=Wrench(torque=Vector3(x=3.0, z=1.5e-200)))
    prepared = Prepared(message, [1.5e-200])
    first, second = prepared.fill(5, -1.0), prepared.fill(6, 2.0)
    torques = [deserialize_message(data, WrenchStamped).wrench.torque for data in (first, second)]
    assert [(torque.x, torque.z) for torque in torques] == [(3.0, -1.0), (3.0, 2.0)]


def test_a_number_that_is_not_unique_in_the_message_is_refused():
    with pytest.raises(ValueError, match="once"):
        Prepared(JointState(name=["a"], position=[0.0]), [7.0])
    with pytest.raises(ValueError, match="once"):
        Prepared(JointState(name=["a", "b"], position=[7.0, 7.0]), [7.0])
