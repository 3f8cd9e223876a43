# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Coalescing of messages: a busy thread pauses between turns and then serves all messages that arrived.

A thread that sleeps between any two messages pays for cold caches: the same work takes several times as long.
"""

import time
from collections.abc import Callable

WINDOW_S = 0.02  # processor share is measured over windows of this length: long beside a turn, short beside a change
SMOOTHING = 0.2  # weight of one window in the share: one long turn alone causes no pause
BUSY, IDLE = 0.24, 0.12  # shares of a core at which pauses begin and end; the gap is the hysteresis


class Coalescer:
    """Pauses of `seconds` for the calling thread while its processor share is high.

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
        self._share = self._pause = 0.0

    def pause(self) -> float:
        """Measure the processor share up to this call; the pause that the thread is to make [s]."""
        begin, used = self._begin
        now = self._now()
        if now - begin >= WINDOW_S:
            cpu = self._cpu()
            self._begin = now, cpu
            self._share += SMOOTHING * ((cpu - used) / (now - begin) - self._share)
            if self._share > BUSY:
                self._pause = self._seconds
            elif self._share < IDLE:
                self._pause = 0.0
        return self._pause
