# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Samples that were lost before a sample, by the driver's sequence numbers."""

from collections import deque
from collections.abc import Sequence

from vsa_estimator.tuning.preprocessing import MAX_GAPS


class SequenceGaps:
    """Gaps in the sequence numbers, which come in batches, before or after their samples.

    >>> gaps = SequenceGaps()
    >>> gaps.add([10, 20, 50], [4, 5, 8])
    >>> gaps.lost_before(20), gaps.lost_before(50), gaps.lost_before(60)
    (0, 2, 0)
    """

    def __init__(self) -> None:
        """No sequence number yet."""
        self._gaps: deque[tuple[int, int]] = deque(maxlen=MAX_GAPS)  # stamp [ns] and lost samples before it
        self._last: int | None = None

    def add(self, stamps_ns: Sequence[int], sequence: Sequence[int]) -> None:
        """Add the sequence numbers of samples with these stamps [ns]. A number that goes back is a new device."""
        for stamp_ns, number in zip(stamps_ns, sequence, strict=True):
            if self._last is not None and number > self._last + 1:
                self._gaps.append((stamp_ns, number - self._last - 1))
            self._last = number

    def lost_before(self, stamp_ns: int) -> int:
        """Samples lost since the stamp of the last call, up to this one [ns]."""
        lost = 0
        while self._gaps and self._gaps[0][0] <= stamp_ns:
            lost += self._gaps.popleft()[1]
        return lost
