"""Rests between turns of a busy thread: what comes meanwhile is served together, at half the cost or less.

A thread that sleeps between two messages wakes up cold: the same work takes it several times as long.
"""

import time
from collections.abc import Callable

WINDOW_S = 0.02  # the share of a core is measured over
SMOOTHING = 0.2  # of each window in the share
TIRED, RESTED = 0.24, 0.12  # shares of a core at which rests begin and end


class Coalescer:
    """Of the thread that asks `due`, `seconds` each, while it is busy.

    `now` and `cpu` are a steady clock and the thread's processor time [s].
    """

    def __init__(
        self,
        seconds: float,
        now: Callable[[], float] = time.monotonic,
        cpu: Callable[[], float] = time.thread_time,
    ) -> None:
        self._seconds = seconds
        self._now, self._cpu = now, cpu
        self._begin = now(), cpu()
        self._share = self._due = 0.0

    def due(self) -> float:
        """How long to rest now [s]."""
        begin, used = self._begin
        now = self._now()
        if now - begin >= WINDOW_S:
            cpu = self._cpu()
            self._begin = now, cpu
            self._share += SMOOTHING * ((cpu - used) / (now - begin) - self._share)
            if self._share > TIRED:
                self._due = self._seconds
            elif self._share < RESTED:
                self._due = 0.0
        return self._due
