"""Messages of the hot path as the bytes that DDS carries (CDR): a struct instead of a message object, both ways."""

import importlib
import struct
import sys
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message
from vsa_common.stamps import NANOSECONDS

_HEAD = 4  # encapsulation: two bytes of kind, two of options; alignment counts from its end
_NATIVE = bytes([0, sys.byteorder == "little"])  # plain CDR, in this machine's byte order
_FRAME_AT = _HEAD + 8  # of frame_id, behind the stamp
_CODES = {
    "double": "d", "boolean": "?", "uint8": "B", "octet": "B", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
}  # fmt: skip
_STAMP = struct.Struct("=iI")
_LENGTH = struct.Struct("=I")
_DOUBLE = struct.Struct("=d")


class Writer:
    """Bytes of a stamped message whose strings stay as they are in `message`; its numbers go in, in their order."""

    def __init__(self, message: Any) -> None:
        self._data = bytearray(serialize_message(message))
        self._runs = _runs(self._data, type(message))

    def write(self, stamp_ns: int, numbers: Sequence[Any]) -> bytes:
        """The message with this stamp [ns] and these numbers: every one but the header's."""
        values = (*divmod(stamp_ns, NANOSECONDS), *numbers)
        for run, offset, first, last in self._runs:
            run.pack_into(self._data, offset, *values[first:last])
        return bytes(self._data)


class Reader:
    """The numbers of a stamped message that has no string but its frame_id, from its bytes."""

    def __init__(self, message_class: type) -> None:
        self._class = message_class
        self._runs: dict[int, tuple[struct.Struct, int]] = {}  # by the length of frame_id

    def read(self, data: bytes) -> tuple[int, tuple[Any, ...]]:
        """Stamp [ns] and every number but the header's, in their order."""
        data = _native(data, self._class)
        (length,) = _LENGTH.unpack_from(data, _FRAME_AT)
        if length not in self._runs:
            run, offset, _, _ = _runs(data, self._class)[1]
            self._runs[length] = run, offset
        run, offset = self._runs[length]
        return _stamp(data), run.unpack_from(data, offset)


def read_wrench(data: bytes, message_class: type) -> tuple[int, float]:
    """Stamp [ns] and force.x [N] of a WrenchStamped."""
    data = _native(data, message_class)
    offset = _aligned(_after_string(data, _FRAME_AT), 8)
    return _stamp(data), _DOUBLE.unpack_from(data, offset)[0]


def read_position(data: bytes, message_class: type) -> tuple[int, float]:
    """Stamp [ns] and the first position of a JointState, NaN where it has none."""
    data = _native(data, message_class)
    offset = _aligned(_after_string(data, _FRAME_AT), 4)
    (names,) = _LENGTH.unpack_from(data, offset)
    offset += _LENGTH.size
    for _ in range(names):
        offset = _after_string(data, offset)
    offset = _aligned(offset, 4)
    (positions,) = _LENGTH.unpack_from(data, offset)
    if not positions:
        return _stamp(data), float("nan")
    return _stamp(data), _DOUBLE.unpack_from(data, _aligned(offset + _LENGTH.size, 8))[0]


def _native(data: bytes, message_class: type) -> bytes:
    if data[:2] == _NATIVE:
        return data
    return serialize_message(deserialize_message(data, message_class))  # from a machine of the other byte order


def _stamp(data: bytes) -> int:
    seconds, nanoseconds = _STAMP.unpack_from(data, _HEAD)
    return seconds * NANOSECONDS + nanoseconds


def _aligned(offset: int, size: int) -> int:
    return offset + -(offset - _HEAD) % size


def _after_string(data: bytes | bytearray, offset: int) -> int:
    offset = _aligned(offset, 4)
    (length,) = _LENGTH.unpack_from(data, offset)
    return offset + _LENGTH.size + length


def _runs(data: bytes | bytearray, message_class: type) -> list[tuple[struct.Struct, int, int, int]]:
    """Stretches of numbers between strings: how to pack each, its offset, and which numbers of all it holds."""
    runs, offset, count = [], _HEAD, 0
    for is_string, kinds in groupby(_kinds(message_class), lambda kind: kind == "string"):
        if is_string:
            for _ in kinds:
                offset = _after_string(data, offset)
            continue
        codes = [_CODES[kind] for kind in kinds]
        begin, packing = offset, "="
        for code in codes:
            start = _aligned(offset, struct.calcsize(f"={code}"))
            packing += f"{start - offset}x{code}"
            offset = start + struct.calcsize(f"={code}")
        runs.append((struct.Struct(packing), begin, count, count + len(codes)))
        count += len(codes)
    return runs


def _kinds(message_class: Any) -> Iterator[str]:
    """Primitive type of every number and string of a message, in the order of the wire."""
    for kind in message_class.get_fields_and_field_types().values():
        base, _, size = kind.rstrip("]").partition("[")
        for _ in range(int(size or 1)):
            if "/" in base:
                package, _, name = base.partition("/")
                yield from _kinds(getattr(importlib.import_module(f"{package}.msg"), name))
            else:
                yield base
