"""How old a stamped message is, on a clock that is never set."""

FOLLOWED_NS = 5_000_000  # that much the stamping clock may be slewed between two looks; more is a step


class StampAge:
    """Steady instants of one topic's stamps.

    Stamps are of the ROS clock, and that may be set: what was stamped before, or by a computer whose clock was not
    set, must not turn old by it. After a step the offset between both clocks is the one that puts a stamp nearest.
    """

    def __init__(self) -> None:
        self._offset_ns: int | None = None

    def steady(self, stamp_ns: int, ros_ns: int, now_ns: int) -> int | None:
        """Steady instant [ns] of a stamp, both clocks read together; None for a stamp of zero, which tells nothing."""
        if stamp_ns == 0:
            return None
        offset = ros_ns - now_ns
        used = offset if self._offset_ns is None else self._offset_ns
        if abs(offset - used) < FOLLOWED_NS or abs(ros_ns - stamp_ns) < abs(now_ns - (stamp_ns - used)):
            used = offset
        self._offset_ns = used
        return stamp_ns - used
