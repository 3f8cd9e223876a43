# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Messages serialized once and rendered in place, at half the cost of a message object."""

import struct
from collections.abc import Sequence
from typing import Any

from rclpy.serialization import serialize_message
from vsa_common.stamps import NANOSECONDS

_STAMP = struct.Struct("=iI")
_NUMBER = struct.Struct("=d")
_STAMP_OFFSET = 4  # after the encapsulation; the header is the first field of every stamped message


class MessageTemplate:
    """The bytes (CDR) of a stamped message of which only the stamp and some numbers change.

    `placeholders` are the values in `message` that `render` replaces; each must be unique in it.
    """

    def __init__(self, message: Any, placeholders: Sequence[float]) -> None:
        self._data = bytearray(serialize_message(message))
        self._offsets = [self._offset_of(placeholder) for placeholder in placeholders]

    def render(self, stamp_ns: int, *numbers: float) -> bytes:
        """The serialized message with this stamp [ns] and these numbers in place of the placeholders."""
        _STAMP.pack_into(self._data, _STAMP_OFFSET, *divmod(stamp_ns, NANOSECONDS))
        for offset, number in zip(self._offsets, numbers, strict=True):
            _NUMBER.pack_into(self._data, offset, number)
        return bytes(self._data)

    def _offset_of(self, placeholder: float) -> int:
        pattern = _NUMBER.pack(placeholder)
        if self._data.count(pattern) != 1:
            raise ValueError(f"placeholder {placeholder!r} must be in the message once")
        return self._data.index(pattern)
