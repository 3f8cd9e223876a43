"""Averages fast samples down to the filter's rate; at or below that rate a sample passes as it is."""

from typing import NamedTuple


class Block(NamedTuple):
    """Mean of consecutive samples."""

    stamp_ns: int  # mean stamp of the deflections
    deflection: float  # [m]
    force: float  # mean of the fresh forces; 0 where there was none [N]
    samples: int
    forces: int  # fresh ones among them


class BlockAverage:
    """Collects samples until they span one period of the filter, by their stamps."""

    def __init__(self, rate: float) -> None:
        """`rate` of the filter [Hz]."""
        self._span_ns = 0.95e9 / rate
        self._period_ns = 0.0
        self._last_ns = 0
        self.clear()

    @property
    def period_ns(self) -> float:
        """Running mean of the sample period [ns]; 0 before the second sample."""
        return self._period_ns

    @property
    def averages(self) -> bool:
        """Whether samples come at least twice as fast as the filter steps."""
        return 0.0 < 2.0 * self._period_ns <= self._span_ns

    def clear(self) -> None:
        """Forget the unfinished block."""
        self._first_ns = 0
        self._offset_sum = 0
        self._deflection_sum = 0.0
        self._force_sum = 0.0
        self._count = 0
        self._force_count = 0

    def add(self, stamp_ns: int, deflection: float | None, force: float | None) -> list[Block]:
        """Take a sample, without what of it is not to be believed; the blocks that it completes, at most two."""
        step = stamp_ns - self._last_ns
        gap = self._first_ns > 0 and step > 2.0 * self._span_ns
        if self._period_ns == 0.0:
            self._period_ns = float(step) if self._last_ns else 0.0
        elif step < 3.0 * self._period_ns:
            self._period_ns += 0.02 * (step - self._period_ns)
        elif step < 1e9:
            self._period_ns *= 1.02
        self._last_ns = stamp_ns
        complete = [self._close()] if gap and self._count else []
        if gap:
            self.clear()
        if not self._first_ns:
            self._first_ns = stamp_ns
        if deflection is not None:
            self._offset_sum += stamp_ns - self._first_ns
            self._deflection_sum += deflection
            self._count += 1
        if force is not None:
            self._force_sum += force
            self._force_count += 1
        if self._count and self._period_ns and stamp_ns - self._first_ns + self._period_ns >= self._span_ns:
            complete.append(self._close())
        return complete

    def _close(self) -> Block:
        block = Block(
            self._first_ns + self._offset_sum // self._count,
            self._deflection_sum / self._count,
            self._force_sum / self._force_count if self._force_count else 0.0,
            self._count,
            self._force_count,
        )
        self.clear()
        return block
