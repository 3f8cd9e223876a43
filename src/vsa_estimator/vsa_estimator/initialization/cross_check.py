# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""When the filter's coefficients are cross-checked by a regression over the same data."""

from vsa_estimator.tuning.initialization import FIRST_CROSS_CHECK_NS, MAX_CROSS_CHECK_NS


class CrossCheckSchedule:
    """Due a first time after hand-over, then after intervals that double up to a maximum."""

    def __init__(self) -> None:
        """Due after the first interval."""
        self._interval_ns = self._due_ns = FIRST_CROSS_CHECK_NS

    def restart(self, now_ns: int) -> None:
        """Begin anew after a hand-over at `now_ns` [ns]."""
        self._interval_ns = FIRST_CROSS_CHECK_NS
        self._due_ns = now_ns + self._interval_ns

    def postpone(self, now_ns: int) -> None:
        """Double the interval after a cross-check at `now_ns` [ns]."""
        self._interval_ns = min(2 * self._interval_ns, MAX_CROSS_CHECK_NS)
        self._due_ns = now_ns + self._interval_ns

    def is_due(self, now_ns: int) -> bool:
        """Whether a cross-check is due at `now_ns` [ns]."""
        return now_ns >= self._due_ns
