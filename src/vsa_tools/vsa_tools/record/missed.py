# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces of a transmission that the driver has published and the recorder has not received.

The middleware drops the oldest messages of a reader whose queue is full, and reports none of them. The driver lists the
stamps of its samples in `capture_counters`, at a low rate.
"""

from collections import deque
from collections.abc import Sequence

SETTLING_NS = 1_000_000_000  # [ns] after the first list, in which forces of before it may have arrived
MAX_WAITING = 100_000  # received forces without a list: 100 s at 1 kHz


class MissedForces:
    """Compares received forces and listed samples of one transmission, from SETTLING_NS after the first list."""

    def __init__(self) -> None:
        """No list yet."""
        self._begin_ns: int | None = None
        self._waiting: deque[int] = deque(maxlen=MAX_WAITING)  # stamps [ns] of received forces, in ascending order
        self._received = 0  # of the listed ones
        self._listed = self._listed_before = 0  # now, and at the last `update`
        self._end_ns = self._end_before_ns = 0  # last listed stamp [ns], likewise

    def add_force(self, stamp_ns: int) -> None:
        """A force was received, with this stamp [ns]."""
        if self._begin_ns is not None and stamp_ns > self._begin_ns:
            self._waiting.append(stamp_ns)

    def add_listed(self, stamps_ns: Sequence[int]) -> None:
        """The driver has published the samples with these stamps [ns]."""
        if not stamps_ns:
            return
        if self._begin_ns is None:
            self._begin_ns = stamps_ns[-1] + SETTLING_NS
        self._listed += sum(stamp_ns > self._begin_ns for stamp_ns in stamps_ns)
        self._end_ns = stamps_ns[-1]

    def update(self) -> int:
        """Missed forces among the samples listed before the last call; the later ones may still be on their way."""
        while self._waiting and self._waiting[0] <= self._end_before_ns:
            self._waiting.popleft()
            self._received += 1
        missed = max(0, self._listed_before - self._received)
        self._listed_before, self._end_before_ns = self._listed, self._end_ns
        return missed
