# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""All values of a stamped message: written into a template, read by field."""

import struct
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from vsa_common.ros.cdr.layout import CODES, HEAD, LENGTH, NATIVE, ORDERS, STAMP_LENGTH, layouts
from vsa_common.stamps import NANOSECONDS

_TEXTS = ("string", "sequence<string>")
_NUMBERS = {f"sequence<{kind}>": code for kind, code in CODES.items() if len(code) == 1}


class Writer:
    """Serializes a stamped message: the strings are those of a template, the numbers are passed to `write`."""

    def __init__(self, message: Any) -> None:
        """`message` is the template, a ROS message that begins with std_msgs/Header, with sequences of full length."""
        self._data = bytearray([0, NATIVE, 0, 0])  # plain CDR
        self._runs: list[tuple[struct.Struct, int, int, int]] = []  # layout, offset [byte], first number, end
        count = 0
        for is_text, parts in groupby(_parts(message), lambda part: isinstance(part, bytes | list)):
            if is_text:
                for text in parts:
                    self._data += bytes(-len(self._data) % 4) + LENGTH[NATIVE].pack(len(text))
                    self._data += text if isinstance(text, bytes) else b""
                continue
            codes = "".join(parts)
            layout = layouts(codes)[NATIVE][len(self._data) % 8]
            self._runs.append((layout, len(self._data), count, count + len(codes)))
            self._data += bytes(layout.size)
            count += len(codes)

    def write(self, stamp_ns: int, numbers: Sequence[Any]) -> bytes:
        """The message with this stamp [ns] and `numbers`: all of the message but the header's, in its order.

        A sequence of numbers has its length before its elements.
        """
        values = (*divmod(stamp_ns, NANOSECONDS), *numbers)
        for layout, offset, first, last in self._runs:
            layout.pack_into(self._data, offset, *values[first:last])
        return bytes(self._data)


class Reader:
    """Reads the fields of a stamped message, up to the first of another type than number, string or sequence of them.

    `sequences` are the names of the sequences of numbers, whose values are tuples.

    >>> reader = Reader({"header": "std_msgs/Header", "force": "double", "force_valid": "boolean", "reason": "string"})
    >>> reader.names
    ('force', 'force_valid', 'reason')
    """

    def __init__(self, fields: Mapping[str, str]) -> None:
        """`fields`: rosidl type by name; the first is the header."""
        self.names: tuple[str, ...] = ()
        self.sequences: tuple[str, ...] = ()
        self._pieces: list[tuple[tuple[list[struct.Struct], ...], str]] = []  # numbers, type of the field after them
        codes = ""
        for name, kind in list(fields.items())[1:]:
            base, _, count = kind.rstrip("]").partition("[")
            if kind in _TEXTS or kind in _NUMBERS:
                self.names += (name,)
                self.sequences += (name,) if kind in _NUMBERS else ()
                self._pieces.append((layouts(codes), kind))
                codes = ""
            elif base in CODES and (count.isdigit() or "[" not in kind):
                found = CODES[base] * int(count or 1)
                self.names += (name,) if len(found) == 1 else tuple(f"{name}_{i + 1}" for i in range(len(found)))
                codes += found
            else:
                break
        self._pieces.append((layouts(codes), ""))

    def read(self, data: bytes) -> tuple[int, tuple[Any, ...]]:
        """Stamp [ns] and the values in the order of `names`. Raises struct.error for a message that is too short."""
        order = data[1] & 1
        seconds, nanoseconds, length = STAMP_LENGTH[order].unpack_from(data, HEAD)
        at = HEAD + 12 + length
        values: tuple[Any, ...] = ()
        for by_order, kind in self._pieces:
            layout = by_order[order][at % 8]
            values += layout.unpack_from(data, at)
            if kind:
                found, at = _read_piece(kind, data, at + layout.size, order)
                values += (found,)
        return seconds * NANOSECONDS + nanoseconds, values


def _read_piece(kind: str, data: bytes, at: int, order: int) -> tuple[Any, int]:
    """A string or sequence that begins at or after `at`, and the offset of its end."""
    if kind in _NUMBERS:
        return _numbers(data, at, order, _NUMBERS[kind])
    return _text(data, at, order) if kind == "string" else _texts(data, at, order)


def _numbers(data: bytes, at: int, order: int, code: str) -> tuple[tuple[Any, ...], int]:
    """A sequence of numbers likewise."""
    at += -at % 4 + 4
    layout = struct.Struct(f"{ORDERS[order]}{LENGTH[order].unpack_from(data, at - 4)[0]}{code}")
    if layout.size:
        at += (HEAD - at) % struct.calcsize(f"={code}")
    return layout.unpack_from(data, at), at + layout.size


def _text(data: bytes, at: int, order: int) -> tuple[str, int]:
    """A string that begins at or after `at`, and the offset of its end."""
    begin = at + -at % 4 + 4
    end = begin + LENGTH[order].unpack_from(data, begin - 4)[0]
    if end > len(data):
        raise struct.error(f"a string of {end - begin} bytes where {len(data) - begin} are left")
    return data[begin:end].rstrip(b"\0").decode(errors="replace"), end


def _texts(data: bytes, at: int, order: int) -> tuple[list[str], int]:
    """A sequence of strings likewise."""
    at += -at % 4 + 4
    found = []
    for _ in range(LENGTH[order].unpack_from(data, at - 4)[0]):
        text, at = _text(data, at, order)
        found.append(text)
    return found, at


def _parts(message: Any) -> Iterator[Any]:
    """Parts of a message in the order of the wire: numbers as their codes, strings as their bytes.

    A sequence begins with its length: one of strings as itself, one of numbers as the code of the length.
    """
    for name, kind in message.get_fields_and_field_types().items():
        base, _, count = kind.rstrip("]").partition("[")
        value = getattr(message, name)
        if kind.startswith("sequence<"):
            base, count = kind[len("sequence<") : -1], "any"
            yield value if base == "string" else CODES["uint32"]
        for one in value if count else [value]:
            if base == "string":
                yield one.encode() + b"\0"
            elif base in CODES:
                yield from CODES[base]
            else:
                yield from _parts(one)
