# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Layout of numbers in CDR: codes of struct, byte orders and alignment."""

import struct
import sys

HEAD = 4  # encapsulation [byte]: two bytes of kind, two of options; alignment counts from its end
CODES = {
    "double": "d", "boolean": "?", "uint8": "B", "octet": "B", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
    "builtin_interfaces/Time": "iI",
}  # fmt: skip
ORDERS = "><"  # struct's byte order by the lowest bit of the encapsulation's kind: big endian, little endian
NATIVE = ("big", "little").index(sys.byteorder)


def both_orders(codes: str) -> tuple[struct.Struct, struct.Struct]:
    """The numbers `codes` without padding, by byte order."""
    return struct.Struct(f">{codes}"), struct.Struct(f"<{codes}")


def layouts(codes: str) -> tuple[list[struct.Struct], ...]:
    """The numbers `codes` with CDR's padding: by byte order, and by their offset modulo 8."""
    return tuple([struct.Struct(order + _padded(codes, begin)) for begin in range(8)] for order in ORDERS)


def _padded(codes: str, at: int) -> str:
    text = ""
    for code in codes:
        size = struct.calcsize(f"={code}")
        pad = (HEAD - at) % size
        text += "x" * pad + code
        at += pad + size
    return text


STAMP, STAMP_LENGTH, LENGTH, DOUBLE = both_orders("iI"), both_orders("iII"), both_orders("I"), both_orders("d")
