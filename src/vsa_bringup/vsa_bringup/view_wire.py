"""Numbers straight from the bytes of a message: many times cheaper than building the message."""

import struct
from collections.abc import Mapping
from functools import lru_cache

from vsa_common.stamps import NANOSECONDS

_SIZES = {"double": ("d", 8), "boolean": ("?", 1), "uint8": ("B", 1), "uint32": ("I", 4), "uint64": ("Q", 8)}
_PARTS = {"builtin_interfaces/Time": ["uint32", "uint32"]}
_ENCAPSULATION = 4  # bytes before CDR begins to count its alignment


class Wire:
    """Reads the stamp and the leading fixed-size fields of a message that begins with std_msgs/Header.

    >>> wire = Wire({"header": "std_msgs/Header", "force": "double", "force_valid": "boolean"})
    >>> wire.names
    ('force', 'force_valid')
    """

    def __init__(self, fields: Mapping[str, str]) -> None:
        self.names: tuple[str, ...] = ()
        self._kinds: tuple[str, ...] = ()
        for name, kind in list(fields.items())[1:]:
            base, _, count = kind.rstrip("]").partition("[")
            if (base not in _SIZES and base not in _PARTS) or ("[" in kind and not count.isdigit()):
                break  # a string or a sequence: where things are from here on depends on it
            parts = _PARTS.get(base, [base]) * int(count or 1)
            self.names += (name,) if len(parts) == 1 else tuple(f"{name}_{i + 1}" for i in range(len(parts)))
            self._kinds += tuple(parts)

    def read(self, data: bytes) -> tuple[int, tuple[float, ...]]:
        """Stamp [ns] and the values in the order of `names`. Raises struct.error for a message that is too short."""
        order = "<" if data[1] & 1 else ">"
        sec, nanosec, length = struct.unpack_from(order + "iII", data, _ENCAPSULATION)
        layout = _layout(self._kinds, order, (12 + length) % 8)
        return sec * NANOSECONDS + nanosec, layout.unpack_from(data, _ENCAPSULATION + 12 + length)


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
