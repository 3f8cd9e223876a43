# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Capture time of a frame on the epoch, for any clock of the adapter."""

import math

from vsa_common.stamps import NANOSECONDS
from vsa_driver.tuning import EPOCH_TOLERANCE_NS, MAX_AHEAD_NS, MAX_CLOCK_DRIFT

_MAX_STAMP_S = 2.0**34  # [s] year 2514; a larger value is no time stamp


class CaptureClock:
    """Maps an adapter's time stamps to the epoch.

    Stamps of the host's clock (socketcan, udp_multicast) pass unchanged. A clock that counts from the adapter's own
    start, or is ahead of the host's, is mapped by the least delay between stamp and arrival, which follows its drift
    and its restarts. No stamp is in the future by more than MAX_AHEAD_NS. A frame without stamp (0) gets the time of
    arrival.
    """

    def __init__(self) -> None:
        self.restarts = 0  # of the adapter's clock
        self._device_ns: int | None = None
        self._offset_ns = math.inf  # steady clock minus adapter's clock, at the least delay

    def to_epoch(self, timestamp: float, now_ns: int, steady_ns: int) -> int:
        """Update the map and return the stamp [ns since the epoch] of a frame stamped `timestamp` [s].

        The frame arrived at `now_ns` [ns since the epoch], `steady_ns` on a monotonic clock.
        """
        if not 0.0 < timestamp < _MAX_STAMP_S:  # also false for NaN
            return now_ns
        seconds = int(timestamp)
        device_ns = seconds * NANOSECONDS + round((timestamp - seconds) * NANOSECONDS)
        max_ahead_ns = MAX_AHEAD_NS if self._device_ns is None else 0  # no alternation between map and clock
        if -max_ahead_ns <= now_ns - device_ns < EPOCH_TOLERANCE_NS:
            self._device_ns, self._offset_ns = None, math.inf
            return device_ns
        return now_ns - steady_ns + self._to_steady(device_ns, steady_ns)

    def _to_steady(self, device_ns: int, steady_ns: int) -> int:
        if self._device_ns is not None:
            if device_ns < self._device_ns:
                self.restarts += 1
                self._offset_ns = math.inf
            else:
                self._offset_ns += MAX_CLOCK_DRIFT * (device_ns - self._device_ns)
        self._device_ns = device_ns
        self._offset_ns = min(self._offset_ns, steady_ns - device_ns)
        return device_ns + int(self._offset_ns)
