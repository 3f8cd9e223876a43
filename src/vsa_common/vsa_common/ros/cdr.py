"""The one door to bytes as DDS carries them and bags keep them (CDR): a struct in place of a message object.

Reads both byte orders, so that nobody needs rclpy for a message from a machine of the other one; writes this machine's.
"""

import math
import struct
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.stamps import NANOSECONDS

Columns = tuple[NDArray[np.int64], NDArray[np.float64]]

FORCE_X, TORQUE_Z = 0, 5  # places among the numbers of a Wrench

_HEAD = 4  # encapsulation: two bytes of kind, two of options; alignment counts from its end
_CODES = {
    "double": "d", "boolean": "?", "uint8": "B", "octet": "B", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
    "builtin_interfaces/Time": "iI",
}  # fmt: skip
_TEXTS = ("string", "sequence<string>")
_ORDERS = ("big", "little")  # the lowest bit of the kind
_NATIVE = _ORDERS.index(sys.byteorder)


def _both(codes: str) -> tuple[struct.Struct, struct.Struct]:
    """The numbers `codes` without padding, in either byte order."""
    return struct.Struct(f">{codes}"), struct.Struct(f"<{codes}")


_STAMP, _STAMP_LENGTH, _LENGTH, _DOUBLE = _both("iI"), _both("iII"), _both("I"), _both("d")


class Writer:
    """Bytes of a stamped message whose strings stay as they are in `message`; its numbers go in, in their order."""

    def __init__(self, message: Any) -> None:
        self._data = bytearray([0, _NATIVE, 0, 0])  # plain CDR
        self._runs: list[tuple[struct.Struct, int, int, int]] = []  # layout, offset, which numbers of all
        count = 0
        for is_text, parts in groupby(_parts(message), lambda part: isinstance(part, bytes | list)):
            if is_text:
                for text in parts:
                    self._data += bytes(-len(self._data) % 4) + _LENGTH[_NATIVE].pack(len(text))
                    self._data += text if isinstance(text, bytes) else b""
                continue
            codes = "".join(parts)
            layout = _layouts(codes)[_NATIVE][len(self._data) % 8]
            self._runs.append((layout, len(self._data), count, count + len(codes)))
            self._data += bytes(layout.size)
            count += len(codes)

    def write(self, stamp_ns: int, numbers: Sequence[Any]) -> bytes:
        """The message with this stamp [ns] and these numbers: every one but the header's."""
        values = (*divmod(stamp_ns, NANOSECONDS), *numbers)
        for layout, offset, first, last in self._runs:
            layout.pack_into(self._data, offset, *values[first:last])
        return bytes(self._data)


class Reader:
    """Reads the fields of a stamped message, numbers and texts, in their order, up to the first that it cannot.

    >>> reader = Reader({"header": "std_msgs/Header", "force": "double", "force_valid": "boolean", "reason": "string"})
    >>> reader.names
    ('force', 'force_valid', 'reason')
    """

    def __init__(self, fields: Mapping[str, str]) -> None:
        self.names: tuple[str, ...] = ()
        self._pieces: list[tuple[tuple[list[struct.Struct], ...], str]] = []  # numbers, and the text after them
        codes = ""
        for name, kind in list(fields.items())[1:]:
            base, _, count = kind.rstrip("]").partition("[")
            if kind in _TEXTS:
                self.names += (name,)
                self._pieces.append((_layouts(codes), kind))
                codes = ""
            elif base in _CODES and (count.isdigit() or "[" not in kind):
                found = _CODES[base] * int(count or 1)
                self.names += (name,) if len(found) == 1 else tuple(f"{name}_{i + 1}" for i in range(len(found)))
                codes += found
            else:
                break
        self._pieces.append((_layouts(codes), ""))

    def read(self, data: bytes) -> tuple[int, tuple[Any, ...]]:
        """Stamp [ns] and the values in the order of `names`. Raises struct.error for a message that is too short."""
        order = data[1] & 1
        seconds, nanoseconds, length = _STAMP_LENGTH[order].unpack_from(data, _HEAD)
        at = _HEAD + 12 + length
        values: tuple[Any, ...] = ()
        for layouts, text in self._pieces:
            layout = layouts[order][at % 8]
            values += layout.unpack_from(data, at)
            if text:
                read = _text if text == "string" else _texts
                found, at = read(data, at + layout.size, order)
                values += (found,)
        return seconds * NANOSECONDS + nanoseconds, values


def read_stamp(data: bytes) -> int:
    """Stamp [ns] of a message that begins with std_msgs/Header."""
    seconds, nanoseconds = _STAMP[data[1] & 1].unpack_from(data, _HEAD)
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
    (count,) = _LENGTH[order].unpack_from(data, at)
    parts = struct.unpack_from(f"{'><'[order]}{2 * count}I", data, at + 4)
    stamps = [seconds * NANOSECONDS + nanoseconds for seconds, nanoseconds in zip(parts[::2], parts[1::2], strict=True)]
    at += 4 + 8 * count
    (count,) = _LENGTH[order].unpack_from(data, at)
    at += 4
    counters = struct.unpack_from(f"{'><'[order]}{count}Q", data, at + (_HEAD - at) % 8) if count else ()
    return stamps, list(counters)


def write_counters(frame: str, stamps: Sequence[int], counters: Sequence[int]) -> bytes:
    """A vsa_msgs/CaptureCounters with these stamps [ns], the last of which is its own, and counters."""
    name, count = frame.encode() + b"\0", len(stamps)
    parts = [part for stamp_ns in stamps for part in divmod(stamp_ns, NANOSECONDS)]
    data = bytes([0, _NATIVE, 0, 0]) + struct.pack("=iII", *parts[-2:], len(name)) + name
    data += bytes(-len(data) % 4) + struct.pack(f"={1 + 2 * count}II", count, *parts, count)
    return data + bytes((_HEAD - len(data)) % 8) + struct.pack(f"={count}Q", *counters)


def _first_number(data: bytes) -> int:
    """Where the first double after a std_msgs/Header is."""
    at = _HEAD + 12 + _LENGTH[data[1] & 1].unpack_from(data, _HEAD + 8)[0]
    return int(at + (_HEAD - at) % 8)


def _first_position(data: bytes) -> int:
    """Where the first position of a sensor_msgs/JointState is; 0 where it has none."""
    order = data[1] & 1
    unpack_length = _LENGTH[order].unpack_from
    at = _after_header(data, order)
    (names,) = unpack_length(data, at)
    at += 4
    for _ in range(names):
        at += 4 + unpack_length(data, at)[0]
        at += -at % 4
    (positions,) = unpack_length(data, at)
    at += 4
    return at + (_HEAD - at) % 8 if positions else 0


def _stamped(data: bytes, at: int) -> tuple[int, float]:
    """Stamp [ns] and the double there, NaN for a place of 0."""
    return read_stamp(data), _DOUBLE[data[1] & 1].unpack_from(data, at)[0] if at else math.nan


def _all_stamped(messages: Sequence[bytes], place: Callable[[bytes], int]) -> Columns:
    """`_stamped` of each: all at once, where they are the first one with other stamps and numbers."""
    first, at = messages[0], place(messages[0])
    if at and len(first) >= at + 8 and all(len(message) == len(first) for message in messages):
        table = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
        if (table[:, [1, *range(_HEAD + 8, at)]] == table[0, [1, *range(_HEAD + 8, at)]]).all():
            order = "><"[first[1] & 1]
            seconds, nanoseconds, number = (
                np.ascontiguousarray(table[:, begin : begin + int(kind[1])]).view(order + kind)[:, 0]
                for begin, kind in ((_HEAD, "i4"), (_HEAD + 4, "u4"), (at, "f8"))
            )
            return seconds.astype(np.int64) * NANOSECONDS + nanoseconds, number.astype(float)
    stamps, numbers = zip(*(_stamped(message, place(message)) for message in messages), strict=True)
    return np.array(stamps, np.int64), np.array(numbers, float)


def _after_header(data: bytes, order: int) -> int:
    """Where the first length after a std_msgs/Header is."""
    at = _HEAD + 12 + _LENGTH[order].unpack_from(data, _HEAD + 8)[0]
    return at + -at % 4


def _text(data: bytes, at: int, order: int) -> tuple[str, int]:
    """A string that begins at or after `at`, and where it ends."""
    begin = at + -at % 4 + 4
    end = begin + _LENGTH[order].unpack_from(data, begin - 4)[0]
    if end > len(data):
        raise struct.error(f"a text of {end - begin} bytes where {len(data) - begin} are left")
    return data[begin:end].rstrip(b"\0").decode(errors="replace"), end


def _texts(data: bytes, at: int, order: int) -> tuple[list[str], int]:
    """A sequence of strings likewise."""
    at += -at % 4 + 4
    found = []
    for _ in range(_LENGTH[order].unpack_from(data, at - 4)[0]):
        text, at = _text(data, at, order)
        found.append(text)
    return found, at


def _parts(message: Any) -> Iterator[Any]:
    """What a message is made of, in the order of the wire: numbers as their codes, strings as their bytes.

    Strings in a sequence come after the sequence itself, of which the wire has the length.
    """
    for name, kind in message.get_fields_and_field_types().items():
        base, _, count = kind.rstrip("]").partition("[")
        value = getattr(message, name)
        if kind == "sequence<string>":
            yield value
            base = "string"
        for one in value if count or isinstance(value, list) else [value]:
            if base == "string":
                yield one.encode() + b"\0"
            elif base in _CODES:
                yield from _CODES[base]
            else:
                yield from _parts(one)


def _layouts(codes: str) -> tuple[list[struct.Struct], ...]:
    """The numbers `codes` with CDR's padding: by byte order, and by where they begin beyond a multiple of 8."""
    return tuple([struct.Struct(order + _padded(codes, begin)) for begin in range(8)] for order in "><")


def _padded(codes: str, at: int) -> str:
    text = ""
    for code in codes:
        size = struct.calcsize(f"={code}")
        pad = (_HEAD - at) % size
        text += "x" * pad + code
        at += pad + size
    return text
