"""Bytes written and read by hand mean what they mean to rclpy's own serialization."""

import math
import struct
import sys

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from vsa_common.cdr import Reader, Writer, read_position, read_wrench
from vsa_msgs.msg import JointImpedance, TransmissionImpedance

STAMP = Time(sec=1_700_000_123, nanosec=987_654_321)
STAMP_NS = 1_700_000_123_987_654_321
SINGLE = [name for name, kind in TransmissionImpedance.get_fields_and_field_types().items() if name != "header"]


def numbers_of(message):
    """Every number but the header's, arrays and stamps in one row."""
    row = []
    for name in list(message.get_fields_and_field_types())[1:]:
        value = getattr(message, name)
        if isinstance(value, str):
            continue
        for one in value if hasattr(value, "__len__") else [value]:
            row += [one.sec, one.nanosec] if isinstance(one, Time) else [one]
    return row


def impedance(frame):
    message = TransmissionImpedance(header=Header(stamp=STAMP, frame_id=frame))
    for i, name in enumerate(SINGLE):
        kind = type(getattr(message, name))
        setattr(message, name, i % 2 == 0 if kind is bool else kind(i + 1) if kind is int else (i + 1) * 1.25e-3)
    return message


def joint(reason):
    message = JointImpedance(reason=reason, reset_count=70_000, reset_reason=3, status=2, reflection=1)
    message.header.stamp = STAMP
    message.transmission_stamp = [STAMP, Time(sec=5, nanosec=6)]
    message.stiffness, message.inertia, message.stiffness_max = 3.25, -1e-300, 1e9
    message.tension, message.tension_variance = [1.5, 2.5], [0.25, 0.125]
    message.damping_valid = message.stiffness_range_valid = True
    message.transmission_status = [2, 4]
    return message


@pytest.mark.parametrize("frame", ["", "a", "transmission_1", "x" * 31])
def test_an_impedance_is_written_and_read_number_by_number(frame):
    message = impedance(frame)
    data = serialize_message(message)
    assert Reader(TransmissionImpedance).read(data) == (STAMP_NS, tuple(numbers_of(message)))
    blank = TransmissionImpedance(header=Header(frame_id=frame))
    assert deserialize_message(Writer(blank).write(STAMP_NS, numbers_of(message)), TransmissionImpedance) == message


@pytest.mark.parametrize("reason", ["", "transmission_1 CONVERGING", "è lento"])
def test_a_joint_message_keeps_its_reason_between_its_numbers(reason):
    message = joint(reason)
    writer = Writer(JointImpedance(reason=reason))
    writer.write(0, [0] * len(numbers_of(message)))
    assert deserialize_message(writer.write(STAMP_NS, numbers_of(message)), JointImpedance) == message


@pytest.mark.parametrize("frame", ["", "ab", "somebody/else's sensor"])
def test_a_force_is_read_from_anybodys_wrench(frame):
    message = WrenchStamped(header=Header(stamp=STAMP, frame_id=frame), wrench=Wrench(force=Vector3(x=-1.5, y=2.0)))
    assert read_wrench(serialize_message(message), WrenchStamped) == (STAMP_NS, -1.5)


@pytest.mark.parametrize("names", [[], ["a"], ["encoder of the left"], ["a", "bcd", ""]])
def test_a_position_is_read_from_anybodys_joint_state(names):
    message = JointState(header=Header(stamp=STAMP, frame_id="abc"), name=names, position=[0.25, 3.0], effort=[7.0])
    assert read_position(serialize_message(message), JointState) == (STAMP_NS, 0.25)


def test_a_joint_state_without_positions_reads_as_no_number():
    stamp_ns, position = read_position(serialize_message(JointState(header=Header(stamp=STAMP))), JointState)
    assert (stamp_ns, math.isnan(position)) == (STAMP_NS, True)


@pytest.mark.skipif(sys.byteorder == "big", reason="swaps to big-endian")
def test_bytes_of_a_machine_of_the_other_byte_order_are_understood():
    # encapsulation, then stamp and an empty frame_id: sec, nanosec, length 1, its end, padding, six doubles
    swapped = bytes([0, 0, 0, 0]) + b"".join(
        [(1_700_000_123).to_bytes(4, "big"), (987_654_321).to_bytes(4, "big"), (1).to_bytes(4, "big"), bytes(4)]
    )
    swapped += struct.pack(">6d", -1.5, 0, 0, 0, 0, 0)
    assert deserialize_message(swapped, WrenchStamped).wrench.force.x == -1.5
    assert read_wrench(swapped, WrenchStamped) == (STAMP_NS, -1.5)
