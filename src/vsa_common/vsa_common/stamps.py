# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Time stamps: integer nanoseconds inside, builtin_interfaces/Time on the wire."""

from typing import Protocol

NANOSECONDS = 1_000_000_000


class StampMessage(Protocol):
    """Fields of builtin_interfaces/Time."""

    sec: int
    nanosec: int


def nanoseconds(stamp: StampMessage) -> int:
    """Time since the epoch of a message stamp [ns]."""
    return stamp.sec * NANOSECONDS + stamp.nanosec


def set_stamp(stamp: StampMessage, stamp_ns: int) -> None:
    """Write `stamp_ns` [ns] into a message stamp."""
    stamp.sec, stamp.nanosec = divmod(stamp_ns, NANOSECONDS)
