# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Single values of the sensor topics: stamp, force, position and counters."""

import math
import struct
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from vsa_common.ros.cdr.layout import DOUBLE, HEAD, LENGTH, NATIVE, ORDERS, STAMP
from vsa_common.stamps import NANOSECONDS

Columns = tuple[NDArray[np.int64], NDArray[np.float64]]

FORCE_X, TORQUE_Z = 0, 5  # index among the numbers of a Wrench


def read_stamp(data: bytes) -> int:
    """Stamp [ns] of a message that begins with std_msgs/Header."""
    seconds, nanoseconds = STAMP[data[1] & 1].unpack_from(data, HEAD)
    return seconds * NANOSECONDS + nanoseconds


def read_wrench(data: bytes, which: int = FORCE_X) -> tuple[int, float]:
    """Stamp [ns] and one number of a geometry_msgs/WrenchStamped: FORCE_X [N] or TORQUE_Z [N m]."""
    return _stamped(data, _first_number(data) + 8 * which)


def read_position(data: bytes) -> tuple[int, float]:
    """Stamp [ns] and the first position of a sensor_msgs/JointState, NaN where it has none."""
    return _stamped(data, _first_position(data))


def read_wrenches(messages: Sequence[bytes]) -> Columns:
    """Stamps [ns] and FORCE_X [N] of messages in the order of the sequence, as `read_wrench` reads each."""
    return _all_stamped(messages, _first_number)


def read_positions(messages: Sequence[bytes]) -> Columns:
    """Stamps [ns] and first positions likewise, as `read_position` reads each."""
    return _all_stamped(messages, _first_position)


def read_counters(data: bytes) -> tuple[list[int], list[int]]:
    """Stamps [ns] and counters of a vsa_msgs/CaptureCounters. Raises struct.error for one that is too short."""
    order = data[1] & 1
    at = _after_header(data, order)
    (count,) = LENGTH[order].unpack_from(data, at)
    parts = struct.unpack_from(f"{ORDERS[order]}{2 * count}I", data, at + 4)
    stamps = [seconds * NANOSECONDS + nanoseconds for seconds, nanoseconds in zip(parts[::2], parts[1::2], strict=True)]
    at += 4 + 8 * count
    (count,) = LENGTH[order].unpack_from(data, at)
    at += 4
    counters = struct.unpack_from(f"{ORDERS[order]}{count}Q", data, at + (HEAD - at) % 8) if count else ()
    return stamps, list(counters)


def write_counters(frame: str, stamps: Sequence[int], counters: Sequence[int]) -> bytes:
    """A vsa_msgs/CaptureCounters with these stamps [ns] and counters; its own stamp is the last of them."""
    name, count = frame.encode() + b"\0", len(stamps)
    parts = [part for stamp_ns in stamps for part in divmod(stamp_ns, NANOSECONDS)]
    data = bytes([0, NATIVE, 0, 0]) + struct.pack("=iII", *parts[-2:], len(name)) + name
    data += bytes(-len(data) % 4) + struct.pack(f"={1 + 2 * count}II", count, *parts, count)
    return data + bytes((HEAD - len(data)) % 8) + struct.pack(f"={count}Q", *counters)


def _stamped(data: bytes, at: int) -> tuple[int, float]:
    """Stamp [ns] and the double at offset `at`, NaN for an offset of 0."""
    return read_stamp(data), DOUBLE[data[1] & 1].unpack_from(data, at)[0] if at else math.nan


def _all_stamped(messages: Sequence[bytes], offset: Callable[[bytes], int]) -> Columns:
    """`_stamped` of each: vectorized where all messages equal the first but for stamp and numbers."""
    first, at = messages[0], offset(messages[0])
    if at and len(first) >= at + 8 and all(len(message) == len(first) for message in messages):
        table = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
        if (table[:, [1, *range(HEAD + 8, at)]] == table[0, [1, *range(HEAD + 8, at)]]).all():
            order = ORDERS[first[1] & 1]
            seconds, nanoseconds, number = (
                np.ascontiguousarray(table[:, begin : begin + int(kind[1])]).view(order + kind)[:, 0]
                for begin, kind in ((HEAD, "i4"), (HEAD + 4, "u4"), (at, "f8"))
            )
            return seconds.astype(np.int64) * NANOSECONDS + nanoseconds, number.astype(float)
    stamps, numbers = zip(*(_stamped(message, offset(message)) for message in messages), strict=True)
    return np.array(stamps, np.int64), np.array(numbers, float)


def _first_number(data: bytes) -> int:
    """Offset of the first double after a std_msgs/Header."""
    at = HEAD + 12 + LENGTH[data[1] & 1].unpack_from(data, HEAD + 8)[0]
    return int(at + (HEAD - at) % 8)


def _first_position(data: bytes) -> int:
    """Offset of the first position of a sensor_msgs/JointState; 0 where it has none."""
    order = data[1] & 1
    unpack_length = LENGTH[order].unpack_from
    at = _after_header(data, order)
    (names,) = unpack_length(data, at)
    at += 4
    for _ in range(names):
        at += 4 + unpack_length(data, at)[0]
        at += -at % 4
    (positions,) = unpack_length(data, at)
    at += 4
    return at + (HEAD - at) % 8 if positions else 0


def _after_header(data: bytes, order: int) -> int:
    """Offset of the first length after a std_msgs/Header."""
    at = HEAD + 12 + LENGTH[order].unpack_from(data, HEAD + 8)[0]
    return at + -at % 4
