"""Pairs a force stream with an encoder stream by stamp; pairs come out in order."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FORCE, ENCODER = range(2)


class Sample(NamedTuple):
    """One instant of both sensors."""

    stamp_ns: int
    force: float  # [N]
    deflection: float  # [m]


class Pairing:
    """Matches by stamp within a tolerance. A half waits until its partner's stream has passed it by the window.

    Its own stream may run on meanwhile: one of two topics can be held up on its way for long, and nothing is lost.
    """

    def __init__(self, tolerance_ns: int, window_ns: int, capacity: int = 2000) -> None:
        """`window_ns` of the other sensor's stamps may pass a half before it is given up; `capacity` bounds each
        queue."""
        self.dropped = 0
        self._tolerance_ns = tolerance_ns
        self._window_ns = window_ns
        self._capacity = capacity
        self._forces: dict[int, float] = {}
        self._encoders: dict[int, float] = {}
        self._pairs: dict[int, Sample] = {}
        self._newest_force_ns = self._newest_encoder_ns = 0

    def add_force(self, stamp_ns: int, force: float) -> list[Sample]:
        """Take a force [N]; the pairs that may go out now, oldest first."""
        self._look_back(stamp_ns)
        self._newest_force_ns = max(self._newest_force_ns, stamp_ns)
        partner = self._partner(self._encoders, stamp_ns)
        if partner is None:
            self._keep(self._forces, stamp_ns, force, self._newest_encoder_ns)
        else:
            self._pair(Sample(stamp_ns, force, self._encoders.pop(partner)))
        self._give_up(self._encoders, 0, self._newest_force_ns - self._window_ns)
        return self._ready()

    def add_encoder(self, stamp_ns: int, deflection: float) -> list[Sample]:
        """Take a deflection [m]; the pairs that may go out now, oldest first."""
        self._look_back(stamp_ns)
        self._newest_encoder_ns = max(self._newest_encoder_ns, stamp_ns)
        partner = self._partner(self._forces, stamp_ns)
        if partner is None:
            self._keep(self._encoders, stamp_ns, deflection, self._newest_force_ns)
        else:
            self._pair(Sample(partner, self._forces.pop(partner), deflection))
        self._give_up(self._forces, 0, self._newest_encoder_ns - self._window_ns)
        return self._ready()

    def clear(self) -> None:
        """Forget all halves: stamps went back."""
        self._forces.clear()
        self._encoders.clear()
        self._pairs.clear()
        self._newest_force_ns = self._newest_encoder_ns = 0

    def _partner(self, others: dict[int, float], stamp_ns: int) -> int | None:
        if stamp_ns in others:
            return stamp_ns
        if self._tolerance_ns == 0 or not others:
            return None
        nearest = min(others, key=lambda other_ns: abs(other_ns - stamp_ns))
        return nearest if abs(nearest - stamp_ns) <= self._tolerance_ns else None

    def _keep(self, halves: dict[int, float], stamp_ns: int, value: float, partners_ns: int) -> None:
        """Let a half wait, unless its partner's stream, now at `partners_ns`, has passed it already."""
        if stamp_ns < partners_ns - self._window_ns:
            self.dropped += 1
            return
        self.dropped += stamp_ns in halves
        halves[stamp_ns] = value
        if len(halves) > self._capacity:
            del halves[min(halves)]
            self.dropped += 1

    def _pair(self, sample: Sample) -> None:
        self.dropped += 2 * (sample.stamp_ns in self._pairs)
        self._pairs[sample.stamp_ns] = sample

    def _look_back(self, stamp_ns: int) -> None:
        """Forget what lies ahead of a stamp that is far behind: it is a clock that was set back, not a late sample."""
        newest_ns = max(self._newest_force_ns, self._newest_encoder_ns)
        if stamp_ns < newest_ns - max(100 * self._window_ns, 1_000_000_000):
            self._newest_force_ns = self._newest_encoder_ns = stamp_ns
            for halves in (self._forces, self._encoders):
                self._give_up(halves, stamp_ns + 1, newest_ns + 1)

    def _give_up(self, halves: dict[int, float], first_ns: int, last_ns: int) -> None:
        for half_ns in [half_ns for half_ns in halves if first_ns <= half_ns < last_ns]:
            del halves[half_ns]
            self.dropped += 1

    def _ready(self) -> list[Sample]:
        """Pairs that no older half still waits for."""
        if not self._pairs:
            return []
        waiting = min((*self._forces, *self._encoders), default=None)
        ready = sorted(pair_ns for pair_ns in self._pairs if waiting is None or pair_ns < waiting)
        return [self._pairs.pop(pair_ns) for pair_ns in ready]


def pair_all(
    sensors: NDArray[np.uint8],
    stamp_ns: NDArray[np.int64],
    values: NDArray[np.float64],
    tolerance_ns: int,
    window_ns: int,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Stamps [ns], forces [N] and deflections [m] of the pairs in a recording of n halves.

    A row each in the order of their arrival: FORCE or ENCODER, its stamp, what it says. The pairs are those of
    `Pairing`; where both streams only go forward and stamps pair exactly, they are the stamps that both have.
    """
    of_force = sensors == FORCE
    forces_ns, encoders_ns = stamp_ns[of_force], stamp_ns[~of_force]
    if not tolerance_ns and (np.diff(forces_ns) > 0).all() and (np.diff(encoders_ns) > 0).all():
        both_ns, i, j = np.intersect1d(forces_ns, encoders_ns, assume_unique=True, return_indices=True)
        return both_ns, values[of_force][i], values[~of_force][j]
    pairing = Pairing(tolerance_ns, window_ns)
    add = {FORCE: pairing.add_force, ENCODER: pairing.add_encoder}
    halves = zip(sensors.tolist(), stamp_ns.tolist(), values.tolist(), strict=True)
    samples = [sample for sensor, half_ns, value in halves for sample in add[sensor](half_ns, value)]
    stamps, forces, deflections = zip(*samples, strict=True) if samples else ((), (), ())
    return np.array(stamps, np.int64), np.array(forces, float), np.array(deflections, float)
