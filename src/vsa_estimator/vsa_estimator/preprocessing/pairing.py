# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Approximate time synchronisation of force and encoder messages; the samples leave in order of their stamps."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_estimator.tuning.preprocessing import MAX_LATENESS_NS, PAIRING_CAPACITY

FORCE, ENCODER = range(2)


class Sample(NamedTuple):
    """Both sensors at one instant."""

    stamp_ns: int
    force: float  # [N]
    deflection: float  # [m]


class Pairing:
    """Matches messages by stamp within a tolerance.

    A message is dropped when the other stream has passed it by the reorder window. Its own stream may advance
    meanwhile: one of two topics can be delayed for long without a loss.
    """

    def __init__(self, tolerance_ns: int, window_ns: int, capacity: int = PAIRING_CAPACITY) -> None:
        """Greatest distance of two stamps [ns], reorder window [ns], and bound of each queue."""
        self.dropped = 0
        self._tolerance_ns = tolerance_ns
        self._window_ns = window_ns
        self._capacity = capacity
        self._forces: dict[int, float] = {}
        self._encoders: dict[int, float] = {}
        self._pairs: dict[int, Sample] = {}
        self._newest_force_ns = self._newest_encoder_ns = 0

    def set_windows(self, tolerance_ns: int, window_ns: int) -> None:
        """Apply another greatest distance of two stamps and reorder window [ns]."""
        self._tolerance_ns, self._window_ns = tolerance_ns, window_ns

    def add_force(self, stamp_ns: int, force: float) -> list[Sample]:
        """Add a force [N]; samples that are complete and in order, oldest first."""
        self._check_time_reset(stamp_ns, self._newest_force_ns)
        self._newest_force_ns = max(self._newest_force_ns, stamp_ns)
        match = self._match(self._encoders, stamp_ns)
        if match is None:
            self._enqueue(self._forces, stamp_ns, force, self._newest_encoder_ns)
        else:
            self._add_pair(Sample(stamp_ns, force, self._encoders.pop(match)))
        self._drop(self._encoders, 0, self._newest_force_ns - self._window_ns)
        return self._pop_ready()

    def add_encoder(self, stamp_ns: int, deflection: float) -> list[Sample]:
        """Add a deflection [m]; samples that are complete and in order, oldest first."""
        self._check_time_reset(stamp_ns, self._newest_encoder_ns)
        self._newest_encoder_ns = max(self._newest_encoder_ns, stamp_ns)
        match = self._match(self._forces, stamp_ns)
        if match is None:
            self._enqueue(self._encoders, stamp_ns, deflection, self._newest_force_ns)
        else:
            self._add_pair(Sample(match, self._forces.pop(match), deflection))
        self._drop(self._forces, 0, self._newest_encoder_ns - self._window_ns)
        return self._pop_ready()

    def _match(self, queue: dict[int, float], stamp_ns: int) -> int | None:
        """Stamp [ns] of the nearest message of the other stream within the tolerance."""
        if stamp_ns in queue:
            return stamp_ns
        if self._tolerance_ns == 0 or not queue:
            return None
        nearest = min(queue, key=lambda other_ns: abs(other_ns - stamp_ns))
        return nearest if abs(nearest - stamp_ns) <= self._tolerance_ns else None

    def _enqueue(self, queue: dict[int, float], stamp_ns: int, value: float, newest_other_ns: int) -> None:
        """Queue a message, unless the other stream, now at `newest_other_ns`, has passed it by the window."""
        if stamp_ns < newest_other_ns - self._window_ns:
            self.dropped += 1
            return
        self.dropped += stamp_ns in queue
        queue[stamp_ns] = value
        if len(queue) > self._capacity:
            del queue[min(queue)]
            self.dropped += 1

    def _add_pair(self, sample: Sample) -> None:
        self.dropped += 2 * (sample.stamp_ns in self._pairs)
        self._pairs[sample.stamp_ns] = sample

    def _check_time_reset(self, stamp_ns: int, newest_ns: int) -> None:
        """Drop later messages when a stamp is too far behind its own stream's newest: the clock was set back."""
        if stamp_ns < newest_ns - max(self._window_ns, MAX_LATENESS_NS):
            end_ns = max(self._newest_force_ns, self._newest_encoder_ns) + 1
            self._newest_force_ns = self._newest_encoder_ns = stamp_ns
            for queue in (self._forces, self._encoders):
                self._drop(queue, stamp_ns + 1, end_ns)
            for later_ns in [pair_ns for pair_ns in self._pairs if pair_ns > stamp_ns]:
                del self._pairs[later_ns]
                self.dropped += 2

    def _drop(self, queue: dict[int, float], first_ns: int, end_ns: int) -> None:
        """Drop and count the queued messages from `first_ns` to before `end_ns`."""
        for stamp_ns in [stamp_ns for stamp_ns in queue if first_ns <= stamp_ns < end_ns]:
            del queue[stamp_ns]
            self.dropped += 1

    def _pop_ready(self) -> list[Sample]:
        """Pairs that are older than every queued message."""
        if not self._pairs:
            return []
        oldest = min((*self._forces, *self._encoders), default=None)
        ready = sorted(pair_ns for pair_ns in self._pairs if oldest is None or pair_ns < oldest)
        return [self._pairs.pop(pair_ns) for pair_ns in ready]


def pair_all(
    sensors: NDArray[np.uint8],
    stamp_ns: NDArray[np.int64],
    values: NDArray[np.float64],
    tolerance_ns: int,
    window_ns: int,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Stamps [ns], forces [N] and deflections [m] of the samples in n recorded messages.

    `sensors` (n,) is FORCE or ENCODER, `values` (n,) the force or deflection, each in order of arrival. The samples are
    those of `Pairing`. Where the stamps of both streams increase and pair exactly, they are the common stamps.
    """
    is_force = sensors == FORCE
    forces_ns, encoders_ns = stamp_ns[is_force], stamp_ns[~is_force]
    if not tolerance_ns and (np.diff(forces_ns) > 0).all() and (np.diff(encoders_ns) > 0).all():
        both_ns, i, j = np.intersect1d(forces_ns, encoders_ns, assume_unique=True, return_indices=True)
        return both_ns, values[is_force][i], values[~is_force][j]
    pairing = Pairing(tolerance_ns, window_ns)
    add = {FORCE: pairing.add_force, ENCODER: pairing.add_encoder}
    messages = zip(sensors.tolist(), stamp_ns.tolist(), values.tolist(), strict=True)
    samples = [sample for sensor, message_ns, value in messages for sample in add[sensor](message_ns, value)]
    stamps, forces, deflections = zip(*samples, strict=True) if samples else ((), (), ())
    return np.array(stamps, np.int64), np.array(forces, float), np.array(deflections, float)
