# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces of a transmission that the driver has published and the recorder has not received.

The middleware drops the oldest messages of a reader whose queue is full, and reports none of them. The driver lists the
stamps of its samples in `capture_counters`, at a low rate.
"""

from collections.abc import Sequence


class MissedForces:
    """Counts received forces and listed samples of one transmission, from the first received force on."""

    def __init__(self) -> None:
        """No force yet."""
        self._begin_ns: int | None = None
        self._received = 0
        self._listed = 0
        self._listed_before = 0  # at the last `update`

    def add_force(self, stamp_ns: int) -> None:
        """A force was received, with this stamp [ns]."""
        if self._begin_ns is None:
            self._begin_ns = stamp_ns
        self._received += 1

    def add_listed(self, stamps_ns: Sequence[int]) -> None:
        """The driver has published the samples with these stamps [ns]."""
        if self._begin_ns is not None:
            self._listed += sum(stamp_ns >= self._begin_ns for stamp_ns in stamps_ns)

    def update(self) -> int:
        """Missed forces among the samples listed before the last call; the later ones may still be on their way."""
        missed = max(0, self._listed_before - self._received)
        self._listed_before = self._listed
        return missed
