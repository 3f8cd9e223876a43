# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Deadlines of the simulated rig's samples: absolute instants of a monotonic clock, which is an argument."""

from vsa_common.stamps import NANOSECONDS


class Pacer:
    """Counts the samples that are due. Late ones follow in bursts of bounded size; none is omitted.

    >>> pacer = Pacer(rate_hz=1000, burst=4)
    >>> pacer.start(0)
    >>> [pacer.take_due(now_ns) for now_ns in (0, 500_000, 1_000_000, 9_000_000, 9_100_000)]
    [1, 0, 1, 4, 4]
    >>> pacer.overruns  # samples taken after the deadline of the next one
    7
    """

    def __init__(self, rate_hz: int, burst: int = 10) -> None:
        self.overruns = 0
        self._rate_hz = rate_hz
        self._burst = burst
        self._start_ns: int | None = None
        self._taken = 0

    @property
    def running(self) -> bool:
        """Whether the clock runs."""
        return self._start_ns is not None

    def start(self, now_ns: int) -> None:
        """Start the clock; the next sample is due at once."""
        self._start_ns, self._taken = now_ns, 0

    def stop(self) -> None:
        """Stop the clock."""
        self._start_ns = None

    def take_due(self, now_ns: int) -> int:
        """Take the samples that are due, at most a burst; their number."""
        if self._start_ns is None:
            return 0
        elapsed = (now_ns - self._start_ns) * self._rate_hz // NANOSECONDS + 1 - self._taken
        samples = max(0, min(elapsed, self._burst))
        self.overruns += max(0, min(samples, elapsed - 1))
        self._taken += samples
        return samples

    def wait(self, now_ns: int) -> float:
        """Time until the next sample is due [s], negative after its deadline."""
        if self._start_ns is None:
            return 0.0
        deadline_ns = self._start_ns + self._taken * NANOSECONDS // self._rate_hz
        return (deadline_ns - now_ns) / NANOSECONDS
