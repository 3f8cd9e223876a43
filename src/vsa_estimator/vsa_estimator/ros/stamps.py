# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stamps of sensor messages that are zero or in the future."""

import time

from rclpy.clock import ROSClock

CLOCK_CACHE_NS = 5_000_000  # age of a reading of the ROS clock that is used again: a reading costs 10 us [ns]


class StampCheck:
    """Refuses and counts stamps that are zero or later than the ROS clock by more than a tolerance."""

    def __init__(self, clock: ROSClock, transmission: str, tolerance_ns: int) -> None:
        """`transmission` is the first part of the topic names; `tolerance_ns` [ns]."""
        self.counts = {f"{transmission}/force": 0, f"{transmission}/encoder": 0}  # refused, by topic
        self._clock = clock
        self._transmission = transmission
        self._tolerance_ns = tolerance_ns
        self._accepted_ns = -1
        self._clock_read_ns = self._future_from_ns = 0

    def set_tolerance(self, tolerance_ns: int) -> None:
        """Apply another tolerance [ns]."""
        self._tolerance_ns = tolerance_ns
        self._clock_read_ns = self._future_from_ns = 0

    def refuse(self, stamp_ns: int, sensor: str) -> bool:
        """Whether to refuse a stamp [ns] of the `sensor`, force or encoder; a refused one is counted."""
        if stamp_ns == self._accepted_ns or 0 < stamp_ns <= self._latest_ns(stamp_ns):
            self._accepted_ns = stamp_ns
            return False
        self.counts[f"{self._transmission}/{sensor}"] += 1
        return True

    def _latest_ns(self, stamp_ns: int) -> int:
        """Latest acceptable stamp [ns], by a reading of the ROS clock that is at most CLOCK_CACHE_NS old."""
        steady_ns = time.monotonic_ns()
        if steady_ns - self._clock_read_ns > CLOCK_CACHE_NS or stamp_ns > self._future_from_ns:
            self._clock_read_ns = steady_ns
            self._future_from_ns = self._clock.now().nanoseconds + self._tolerance_ns
        return self._future_from_ns
