"""Pairs a force stream with an encoder stream by stamp; pairs come out in order."""

import math
from typing import NamedTuple


class Sample(NamedTuple):
    """One instant of both sensors."""

    stamp_ns: int
    force: float  # [N]
    deflection: float  # [m]


class Pairing:
    """Matches by stamp within a tolerance. A half waits for its partner no longer than the window."""

    def __init__(self, tolerance_ns: int, window_ns: int, capacity: int = 2000) -> None:
        """`window_ns` of stamps may pass before a half is given up; `capacity` bounds each queue."""
        self.dropped = 0
        self._tolerance_ns = tolerance_ns
        self._window_ns = window_ns
        self._capacity = capacity
        self._forces: dict[int, float] = {}
        self._encoders: dict[int, float] = {}
        self._pairs: dict[int, Sample] = {}
        self._newest_ns = 0

    def add_force(self, stamp_ns: int, force: float) -> list[Sample]:
        """Take a force [N]; the pairs that may go out now, oldest first."""
        partner = self._partner(self._encoders, stamp_ns)
        if partner is None:
            self._keep(self._forces, stamp_ns, force)
        else:
            self._pair(Sample(stamp_ns, force, self._encoders.pop(partner)))
        return self._ready(stamp_ns)

    def add_encoder(self, stamp_ns: int, deflection: float) -> list[Sample]:
        """Take a deflection [m]; the pairs that may go out now, oldest first."""
        partner = self._partner(self._forces, stamp_ns)
        if partner is None:
            self._keep(self._encoders, stamp_ns, deflection)
        else:
            self._pair(Sample(partner, self._forces.pop(partner), deflection))
        return self._ready(stamp_ns)

    def clear(self) -> None:
        """Forget all halves: stamps went back."""
        self._forces.clear()
        self._encoders.clear()
        self._pairs.clear()
        self._newest_ns = 0

    def _partner(self, others: dict[int, float], stamp_ns: int) -> int | None:
        if stamp_ns in others:
            return stamp_ns
        if self._tolerance_ns == 0 or not others:
            return None
        nearest = min(others, key=lambda other_ns: abs(other_ns - stamp_ns))
        return nearest if abs(nearest - stamp_ns) <= self._tolerance_ns else None

    def _keep(self, halves: dict[int, float], stamp_ns: int, value: float) -> None:
        self.dropped += stamp_ns in halves
        halves[stamp_ns] = value
        if len(halves) > self._capacity:
            del halves[min(halves)]
            self.dropped += 1

    def _pair(self, sample: Sample) -> None:
        self.dropped += 2 * (sample.stamp_ns in self._pairs)
        self._pairs[sample.stamp_ns] = sample

    def _ready(self, stamp_ns: int) -> list[Sample]:
        """Pairs that no older half still waits for."""
        if stamp_ns < self._newest_ns - max(100 * self._window_ns, 1_000_000_000):
            self._newest_ns = stamp_ns
            self._give_up(stamp_ns + 1, math.inf)
        self._newest_ns = max(self._newest_ns, stamp_ns)
        self._give_up(0, self._newest_ns - self._window_ns)
        if not self._pairs:
            return []
        waiting = min((*self._forces, *self._encoders), default=None)
        ready = sorted(pair_ns for pair_ns in self._pairs if waiting is None or pair_ns < waiting)
        return [self._pairs.pop(pair_ns) for pair_ns in ready]

    def _give_up(self, first_ns: float, last_ns: float) -> None:
        for halves in (self._forces, self._encoders):
            for other_ns in [other_ns for other_ns in halves if first_ns <= other_ns < last_ns]:
                del halves[other_ns]
                self.dropped += 1
