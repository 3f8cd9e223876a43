# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Serialized messages: equal to those of rclpy's own serialization, in either byte order."""

import math
import struct
from array import array
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from vsa_common.ros.cdr import (
    TORQUE_Z,
    Reader,
    Writer,
    read_counters,
    read_position,
    read_positions,
    read_stamp,
    read_wrench,
    read_wrenches,
    write_counters,
)
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance

STAMP = Time(sec=1_700_000_123, nanosec=987_654_321)
STAMP_NS = 1_700_000_123_987_654_321
MESSAGES = Path(__file__).parents[3] / "src/vsa_msgs/msg"
SINGLE = [name for name, kind in TransmissionImpedance.get_fields_and_field_types().items() if name != "header"]


def reader(kind):
    return Reader(kind.get_fields_and_field_types())


def values_of(message, texts=True):
    """Every value but the header's, arrays and stamps flattened.

    As read: a sequence of numbers is a tuple. As written (not `texts`): without strings, with the length of sequences.
    """
    row = []
    for name in list(message.get_fields_and_field_types())[1:]:
        value = getattr(message, name)
        if isinstance(value, str | list) and not (value and isinstance(value[0], Time)):
            row += [value] if texts else []
            continue
        if isinstance(value, array):
            row += [tuple(value)] if texts else [len(value), *value]
            continue
        for one in value if hasattr(value, "__len__") else [value]:
            row += [one.sec, one.nanosec] if isinstance(one, Time) else [one]
    return tuple(row)


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


def state(reason, frame="transmission_1"):
    message = EstimatorState(reason=reason, k2=267.2, observability=["inertia: move", reason], samples_fused=2**40)
    message.header = Header(stamp=STAMP, frame_id=frame)
    message.force_noise_std, message.force_rejected, message.force_repeated = 0.017, 3, 2
    message.elastic_law, message.elastic_law_valid, message.elastic_force = f"law {reason}", True, 21.5
    return message


def wrench(frame):
    force, torque = Vector3(x=-1.5, y=2.0), Vector3(x=7.0, z=0.625)
    return WrenchStamped(header=Header(stamp=STAMP, frame_id=frame), wrench=Wrench(force=force, torque=torque))


def joint_state(names, positions=(0.25, 3.0)):
    header = Header(stamp=STAMP, frame_id="abc")
    return JointState(header=header, name=names, position=list(positions), velocity=[9.0], effort=[7.0])


@pytest.fixture(scope="module")
def both_orders():
    """The bytes of a message in either byte order, by an independent implementation: rosbags."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for file in MESSAGES.glob("*.msg"):
        store.register(get_types_from_msg(file.read_text(), f"vsa_msgs/msg/{file.stem}"))

    def written(message):
        name = "/msg/".join((type(message).__module__.split(".")[0], type(message).__name__))
        data = serialize_message(message)
        decode = getattr(store.get_msgdef(name), "deserialize_cdr_le" if data[1] else "deserialize_cdr_be")
        other, _ = decode(data[4:], 0, store.get_msgdef(name).cls, store)
        orders = [bytes(store.serialize_cdr(other, name, little_endian=little)) for little in (False, True)]
        assert [data[:2] for data in orders] == [b"\0\0", b"\0\1"]
        return orders

    return written


@pytest.mark.parametrize("frame", ["", "a", "transmission_1", "x" * 31])
def test_an_impedance_message_is_written_and_read(frame):
    message = impedance(frame)
    assert reader(TransmissionImpedance).read(serialize_message(message)) == (STAMP_NS, values_of(message))
    blank = TransmissionImpedance(header=Header(frame_id=frame))
    assert deserialize_message(Writer(blank).write(STAMP_NS, values_of(message)), TransmissionImpedance) == message


@pytest.mark.parametrize("reason", ["", "transmission_1 CONVERGING", "è lento"])
def test_a_joint_message_has_its_reason_between_its_numbers(reason):
    message = joint(reason)
    numbers = values_of(message, texts=False)
    writer = Writer(JointImpedance(reason=reason))
    writer.write(0, [0] * len(numbers))
    assert deserialize_message(writer.write(STAMP_NS, numbers), JointImpedance) == message
    assert reader(JointImpedance).read(serialize_message(message)) == (STAMP_NS, values_of(message))


@pytest.mark.parametrize("reason", ["", "why", "waits", "ünobservable"])
def test_texts_do_not_shift_the_numbers_behind_them(reason):
    message, of_state = state(reason), reader(EstimatorState)
    message.elastic_deflection, message.elastic_ln_stiffness = [0.0, 0.01, 0.02], [6.0, 7.0, 7.5]
    stamp_ns, values = of_state.read(serialize_message(message))
    assert (stamp_ns, values) == (STAMP_NS, values_of(message))
    found = dict(zip(of_state.names, values, strict=True))
    assert (found["reason"], found["k2"], found["observability"]) == (reason, 267.2, ["inertia: move", reason])
    assert (found["force_noise_std"], found["samples_fused"], found["force_rejected"]) == (0.017, 2**40, 3)
    blank = EstimatorState(header=Header(frame_id=message.header.frame_id), reason=reason)
    blank.observability, blank.elastic_law = message.observability, message.elastic_law
    blank.elastic_deflection = blank.elastic_ln_stiffness = [0.0] * 3
    written = Writer(blank).write(STAMP_NS, values_of(message, texts=False))
    assert deserialize_message(written, EstimatorState) == message


@pytest.mark.parametrize("knots", [0, 1, 3])
@pytest.mark.parametrize("law", ["", "any", "any spring (87 %)"])
def test_sequences_of_numbers_are_read_in_either_byte_order(both_orders, knots, law):
    message, of_state = state("why"), reader(EstimatorState)
    message.elastic_law, message.elastic_deflection = law, [0.001 * k for k in range(knots)]
    message.elastic_ln_stiffness_covariance = [0.25] * knots**2
    assert of_state.sequences == ("elastic_deflection", "elastic_ln_stiffness", "elastic_ln_stiffness_covariance")
    for data in (serialize_message(message), *both_orders(message)):
        assert of_state.read(data) == (STAMP_NS, values_of(message))


def test_a_sequence_that_is_longer_than_its_message_is_an_error():
    message = state("")
    message.elastic_ln_stiffness_covariance = [0.25] * 4
    with pytest.raises(struct.error):
        reader(EstimatorState).read(serialize_message(message)[:-24])


def test_the_reader_ends_before_a_field_of_an_unsupported_type():
    fields = {"header": "std_msgs/Header", "first": "double", "list": "sequence<float>", "second": "double"}
    assert Reader(fields).names == ("first",)


@pytest.mark.parametrize("frame", ["", "ab", "another/vendor's sensor"])
def test_force_and_torque_are_read_from_a_wrench_of_any_frame(frame):
    data = serialize_message(wrench(frame))
    assert (read_stamp(data), read_wrench(data), read_wrench(data, TORQUE_Z)) == (
        STAMP_NS, (STAMP_NS, -1.5), (STAMP_NS, 0.625),
    )  # fmt: skip


@pytest.mark.parametrize("names", [[], ["a"], ["encoder of the left"], ["a", "bcd", ""]])
def test_a_position_is_read_from_a_joint_state_of_any_names(names):
    assert read_position(serialize_message(joint_state(names))) == (STAMP_NS, 0.25)


def test_the_position_of_a_joint_state_without_positions_is_nan():
    for names in ([], ["rod"]):
        stamp_ns, position = read_position(serialize_message(joint_state(names, ())))
        assert (stamp_ns, math.isnan(position)) == (STAMP_NS, True)


@pytest.mark.parametrize("frame", ["", "transmission_1", "abc"])
@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_batch_of_counters_is_read_in_either_byte_order(both_orders, frame, count):
    message = CaptureCounters(stamp=[STAMP] * count, counter=[2**40 + k for k in range(count)])
    message.header.frame_id = frame
    message.header.stamp = STAMP if count else Time()
    written = write_counters(frame, [STAMP_NS] * count, message.counter) if count else serialize_message(message)
    assert deserialize_message(written, CaptureCounters) == message
    for data in [written, serialize_message(message), *both_orders(message)]:
        assert read_counters(data) == ([STAMP_NS] * count, [2**40 + k for k in range(count)])
    for last in range(16, len(serialize_message(message)) - 1) if count else ():
        with pytest.raises(struct.error):
            read_counters(serialize_message(message)[:last])


def test_either_byte_order_is_read(both_orders):
    for data in both_orders(wrench("ab")):
        assert (read_stamp(data), read_wrench(data)) == (STAMP_NS, (STAMP_NS, -1.5))
        assert read_wrench(data, TORQUE_Z) == (STAMP_NS, 0.625)
    for data in both_orders(joint_state(["a", "bcd"])):
        assert read_position(data) == (STAMP_NS, 0.25)
    for message in (impedance("transmission_1"), joint("è lento"), state("why")):
        for data in both_orders(message):
            assert reader(type(message)).read(data) == (STAMP_NS, values_of(message))


def stamped_alike(message, number, place):
    """The same message with different stamps and numbers."""
    messages = []
    for k in range(5):
        message.header.stamp = Time(sec=k, nanosec=999_999_999 - k)
        place(message, number + k)
        messages.append(serialize_message(message))
    return messages


def set_force(message, number):
    message.wrench.force.x = number


def set_position(message, number):
    message.position[0] = number


def test_many_messages_at_once_are_read_as_each_of_them(both_orders):
    forces = stamped_alike(wrench("ab"), 1.5, set_force)
    positions = stamped_alike(joint_state(["a", "bcd"]), 0.25, set_position)
    mixed_forces = [*forces, *both_orders(wrench("another's")), *both_orders(wrench("ab")), forces[0]]
    mixed_positions = [*positions, *both_orders(joint_state(["a", "xyz"])), serialize_message(joint_state([], ()))]
    for messages, read_one, read_all in (
        (forces, read_wrench, read_wrenches), (mixed_forces, read_wrench, read_wrenches),
        (positions, read_position, read_positions), (mixed_positions, read_position, read_positions),
        (both_orders(joint_state(["a"]))[::-1] * 3, read_position, read_positions),
    ):  # fmt: skip
        stamps, numbers = read_all(messages)
        np.testing.assert_array_equal(stamps, [read_one(message)[0] for message in messages])
        np.testing.assert_array_equal(numbers, [read_one(message)[1] for message in messages])
    for cut in range(len(forces[0]) - 48):
        with pytest.raises((struct.error, IndexError)):
            read_wrenches([forces[0], forces[1][:cut]])


def test_literal_bytes_of_a_big_endian_machine():
    # encapsulation, then stamp and an empty frame_id: sec, nanosec, length 1, its end, padding, six doubles
    data = bytes.fromhex("00000000 6553f17b 3ade68b1 00000001 00000000") + struct.pack(">6d", -1.5, 0, 0, 0, 0, 0.5)
    assert deserialize_message(data, WrenchStamped).wrench.force.x == -1.5
    assert (read_wrench(data), read_wrench(data, TORQUE_Z)) == ((STAMP_NS, -1.5), (STAMP_NS, 0.5))


@pytest.mark.parametrize(
    "message", [impedance("transmission_1"), joint("why"), state("why")], ids=lambda m: type(m).__name__
)
def test_a_truncated_message_raises_an_error(message):
    whole = serialize_message(message)
    of_kind, last = reader(type(message)), len(whole)
    while last > 16:
        last -= 1
        try:
            assert of_kind.read(whole[:last])[1] == values_of(message)
        except struct.error:
            break
    unread = 8 * list(message.get_fields_and_field_types().values()).count("sequence<double>")  # zero lengths, aligned
    assert last >= len(whole) - 4 - unread  # only padding may be absent
    for length in range(2, last):
        with pytest.raises(struct.error):
            of_kind.read(whole[:length])
