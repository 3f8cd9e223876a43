"""Numbers and texts straight from the bytes of a message: many times cheaper than building the message."""

import struct
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from vsa_common.stamps import NANOSECONDS

_SIZES = {"double": ("d", 8), "boolean": ("?", 1), "uint8": ("B", 1), "uint32": ("I", 4), "uint64": ("Q", 8)}
_PARTS = {"builtin_interfaces/Time": ["uint32", "uint32"]}
_TEXTS = ("string", "sequence<string>")
_ENCAPSULATION = 4  # bytes before CDR begins to count its alignment


class Wire:
    """Reads the stamp and the fields of a message that begins with std_msgs/Header, up to the first it cannot.

    >>> wire = Wire({"header": "std_msgs/Header", "force": "double", "force_valid": "boolean", "reason": "string"})
    >>> wire.names
    ('force', 'force_valid', 'reason')
    """

    def __init__(self, fields: Mapping[str, str]) -> None:
        self.names: tuple[str, ...] = ()
        self._pieces: list[tuple[tuple[str, ...], str]] = []  # kinds of fixed size, and the text after them
        kinds: list[str] = []
        for name, kind in list(fields.items())[1:]:
            if kind in _TEXTS:
                self.names += (name,)
                self._pieces.append((tuple(kinds), kind))
                kinds = []
                continue
            base, _, count = kind.rstrip("]").partition("[")
            if (base not in _SIZES and base not in _PARTS) or ("[" in kind and not count.isdigit()):
                break
            parts = _PARTS.get(base, [base]) * int(count or 1)
            self.names += (name,) if len(parts) == 1 else tuple(f"{name}_{i + 1}" for i in range(len(parts)))
            kinds += parts
        self._pieces.append((tuple(kinds), ""))

    def read(self, data: bytes) -> tuple[int, tuple[Any, ...]]:
        """Stamp [ns] and the values in the order of `names`. Raises struct.error for a message that is too short."""
        order = "<" if data[1] & 1 else ">"
        sec, nanosec, length = struct.unpack_from(order + "iII", data, _ENCAPSULATION)
        at = _ENCAPSULATION + 12 + length
        values: tuple[Any, ...] = ()
        for kinds, text in self._pieces:
            layout = _layout(kinds, order, (at - _ENCAPSULATION) % 8)
            values += layout.unpack_from(data, at)
            at += layout.size
            if text:
                found, at = _texts(data, at, order) if text == "sequence<string>" else _text(data, at, order)
                values += (found,)
        return sec * NANOSECONDS + nanosec, values


def _text(data: bytes, at: int, order: str) -> tuple[str, int]:
    """A string and where it ends."""
    begin = at + -at % 4 + 4
    length = struct.unpack_from(order + "I", data, begin - 4)[0]
    return data[begin : begin + length].rstrip(b"\0").decode(errors="replace"), begin + length


def _texts(data: bytes, at: int, order: str) -> tuple[list[str], int]:
    at += -at % 4 + 4
    found = []
    for _ in range(struct.unpack_from(order + "I", data, at - 4)[0]):
        text, at = _text(data, at, order)
        found.append(text)
    return found, at


@lru_cache
def _layout(kinds: tuple[str, ...], order: str, offset: int) -> struct.Struct:
    """The fields with CDR's padding, from a place `offset` beyond a multiple of 8."""
    text, at = order, offset
    for kind in kinds:
        letter, size = _SIZES[kind]
        pad = -at % size
        text += "x" * pad + letter
        at += pad + size
    return struct.Struct(text)
