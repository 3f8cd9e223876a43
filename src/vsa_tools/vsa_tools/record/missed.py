# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces of a transmission that the driver has published and the recorder has not received.

The middleware drops the oldest messages of a reader whose queue is full, and reports none of them. The driver lists the
stamps of its samples in `capture_counters`, at a low rate.
"""

from collections import deque
from collections.abc import Sequence

SETTLING_NS = 1_000_000_000  # [ns] in which a force and its list may overtake each other
MAX_WAITING = 100_000  # stamps of forces, and of lists: 100 s at 1 kHz


class MissedForces:
    """Compares received forces and listed samples of one transmission, from SETTLING_NS after the first list."""

    def __init__(self) -> None:
        """No list yet."""
        self._begin_ns: int | None = None
        self._forces: deque[int] = deque(maxlen=MAX_WAITING)  # stamps [ns] in ascending order, not yet compared
        self._samples: deque[int] = deque(maxlen=MAX_WAITING)  # likewise, of the lists
        self._missed = 0

    def add_force(self, stamp_ns: int) -> None:
        """A force was received, with this stamp [ns]."""
        if self._begin_ns is not None and stamp_ns > self._begin_ns:
            self._forces.append(stamp_ns)

    def add_listed(self, stamps_ns: Sequence[int]) -> None:
        """The driver has published the samples with these stamps [ns]."""
        if not stamps_ns:
            return
        if self._begin_ns is None:
            self._begin_ns = stamps_ns[-1] + SETTLING_NS
        self._samples.extend(stamp_ns for stamp_ns in stamps_ns if stamp_ns > self._begin_ns)

    def update(self) -> int:
        """Missed forces among all samples that are older by SETTLING_NS than the last one."""
        if self._samples:
            until_ns = self._samples[-1] - SETTLING_NS
            self._missed += _drop(self._samples, until_ns) - _drop(self._forces, until_ns)
        return max(0, self._missed)


def _drop(stamps_ns: deque[int], until_ns: int) -> int:
    """Remove the stamps up to an instant [ns]; their number."""
    before = len(stamps_ns)
    while stamps_ns and stamps_ns[0] <= until_ns:
        stamps_ns.popleft()
    return before - len(stamps_ns)
