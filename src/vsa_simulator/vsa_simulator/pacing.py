"""When the simulated rig's samples are due: absolute deadlines on a steady clock that is passed in."""

NANOSECONDS = 1_000_000_000


class Pacer:
    """Counts the samples that are due. Late ones are caught up in bounded bursts; none is left out.

    >>> pacer = Pacer(rate_hz=1000, burst=4)
    >>> pacer.start(0)
    >>> pacer.due(0), pacer.due(500_000), pacer.due(1_000_000), pacer.due(9_000_000), pacer.due(9_100_000)
    (1, 0, 1, 4, 4)
    >>> pacer.overruns  # samples that came after the next one was due
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

    def due(self, now_ns: int) -> int:
        """How many samples to take now, at most a burst; they count as taken."""
        if self._start_ns is None:
            return 0
        elapsed = (now_ns - self._start_ns) * self._rate_hz // NANOSECONDS + 1 - self._taken
        samples = max(0, min(elapsed, self._burst))
        self.overruns += max(0, min(samples, elapsed - 1))
        self._taken += samples
        return samples

    def wait(self, now_ns: int) -> float:
        """Time until the next sample is due [s], negative where it is late."""
        if self._start_ns is None:
            return 0.0
        deadline_ns = self._start_ns + self._taken * NANOSECONDS // self._rate_hz
        return (deadline_ns - now_ns) / NANOSECONDS
