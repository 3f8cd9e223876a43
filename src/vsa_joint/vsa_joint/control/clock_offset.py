# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stamps of the ROS clock on the steady clock, through steps and slew of the ROS clock."""

from vsa_joint.tuning import MAX_SLEW_NS


class ClockOffset:
    """Offset between the ROS clock and the steady clock for the stamps of one topic.

    A step of the ROS clock leaves two candidates, the offset before and after it, because stamps of before the step or
    of another host keep the former; the one with the smaller age applies.
    """

    def __init__(self) -> None:
        self._offset_ns: int | None = None

    def update(self, stamp_ns: int, ros_ns: int, now_ns: int) -> int | None:
        """Follow the clocks and convert a stamp to the steady clock [ns]; None for a stamp of zero.

        `ros_ns` and `now_ns` are the readings of the ROS clock and of the steady clock at the same instant.
        """
        if stamp_ns == 0:
            return None
        offset = ros_ns - now_ns
        used = offset if self._offset_ns is None else self._offset_ns
        if abs(offset - used) < MAX_SLEW_NS or abs(ros_ns - stamp_ns) < abs(now_ns - (stamp_ns - used)):
            used = offset
        self._offset_ns = used
        return stamp_ns - used
