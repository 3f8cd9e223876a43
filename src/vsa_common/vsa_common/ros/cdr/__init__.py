# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Messages as serialized bytes (CDR), without message objects. Input: values, or bytes. Output: bytes, or values.

Permitted imports: vsa_common.stamps, numpy

Reads both byte orders, so that recordings of any machine are readable without rclpy; writes the native order.
"""

from vsa_common.ros.cdr.messages import Reader, Writer
from vsa_common.ros.cdr.values import (
    FORCE_X,
    TORQUE_Z,
    read_counters,
    read_position,
    read_positions,
    read_stamp,
    read_wrench,
    read_wrenches,
    write_counters,
)

__all__ = [
    "FORCE_X",
    "TORQUE_Z",
    "Reader",
    "Writer",
    "read_counters",
    "read_position",
    "read_positions",
    "read_stamp",
    "read_wrench",
    "read_wrenches",
    "write_counters",
]
