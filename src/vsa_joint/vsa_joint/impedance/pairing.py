# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Pairing of the samples of both transmissions by stamp.

Samples pair when their stamps differ by less than half the sampling period and `max_skew`. A larger difference has two
causes: one transmission lost a sample, or the frame of the other one was delayed. The subsequent samples decide: the
first ones with nominal skew show which samples correspond. A lost sample costs one pair and does not shift the
pairing; a delayed frame costs none. A measured sample does not pair with an earlier prediction that bridges a gap of
the other transmission.
"""

from collections import deque
from typing import NamedTuple

from vsa_common.types import Status
from vsa_joint.impedance.propagation import ImpedanceEstimate
from vsa_joint.tuning import (
    JITTER_GATE,
    JITTER_MIN_NS,
    JITTER_START_NS,
    LOOKAHEAD,
    PERIOD_GAIN,
    PERIOD_STEP_CAP,
    QUEUE_LENGTH,
    RATE_RATIO,
    TIME_RESET_NS,
)


class TransmissionEstimate(NamedTuple):
    """One transmission at one instant, named as in TransmissionImpedance.msg (SI)."""

    stamp_ns: int
    force: float
    force_variance: float
    force_valid: bool
    impedance: ImpedanceEstimate
    stiffness_valid: bool
    damping_valid: bool
    inertia_valid: bool
    status: int
    reset_count: int = 0
    reset_reason: int = 0


Queue = deque[TransmissionEstimate]


class Pairing:
    """Queues of both transmissions; pairs have a skew of at most `max_skew_ns`."""

    def __init__(self, max_skew_ns: float) -> None:
        self.pairs = 0
        self.unpaired = 0  # samples discarded without a partner
        self._max_skew_ns = max_skew_ns
        self._queues: tuple[Queue, Queue] = (deque(maxlen=QUEUE_LENGTH), deque(maxlen=QUEUE_LENGTH))
        self._newest_ns: list[int | None] = [None, None]
        self._period_ns = [0.0, 0.0]
        self._skew_ns = 0.0  # stamp of transmission_1 minus stamp of transmission_2
        self._jitter_ns = JITTER_START_NS  # median deviation of the skew

    def set_max_skew(self, max_skew_ns: float) -> None:
        """Apply another greatest skew of a pair [ns]."""
        self._max_skew_ns = max_skew_ns

    @property
    def period_ns(self) -> float:
        """Longer sampling period of both transmissions [ns]; 0 before the second sample."""
        return max(self._period_ns)

    def add(self, index: int, sample: TransmissionEstimate) -> bool:
        """Append a sample of transmission `index` (0 or 1); False for a duplicate or late one, which is discarded."""
        if not self._accept_stamp(index, sample.stamp_ns):
            return False
        self._newest_ns[index] = sample.stamp_ns
        queue = self._queues[index]
        if len(queue) == QUEUE_LENGTH:
            self.unpaired += 1
        queue.append(sample)
        return True

    def pop_pair(self) -> tuple[TransmissionEstimate, TransmissionEstimate] | None:
        """Remove the oldest pair, if there is one; call it once after each `add`."""
        first, second = self._queues
        limit = self._skew_limit_ns()
        while first and second:
            skew = first[0].stamp_ns - second[0].stamp_ns
            later, earlier = (first, second) if skew > 0 else (second, first)
            if _is_predicted(earlier[0]) and not _is_predicted(later[0]):
                if len(earlier) == 1:
                    return None  # the measured sample may be pending
                earlier.popleft()
                continue
            matched = abs(skew) <= limit
            if not matched and self._has_common_rate():
                delayed = self._is_delayed(later, earlier)
                if delayed is None:
                    return None  # the next samples decide
                if delayed:
                    matched = abs(skew) <= self._max_skew_ns
                    if not matched:
                        self._discard(later)
            if matched:
                self._update_skew(skew)
                self.pairs += 1
                return first.popleft(), second.popleft()
            self._discard(earlier)
        return None

    def _accept_stamp(self, index: int, stamp_ns: int) -> bool:
        """Whether the stamp is newer than the previous one, or a time reset; updates period and queues."""
        previous_ns = self._newest_ns[index]
        if previous_ns is None:
            return True
        step = stamp_ns - previous_ns
        if step > 0:
            period = self._period_ns[index]
            capped = min(step, PERIOD_STEP_CAP * period)
            self._period_ns[index] = period + PERIOD_GAIN * (capped - period) if period else float(step)
            return True
        if step < -TIME_RESET_NS:
            self._discard_after(stamp_ns + TIME_RESET_NS)
            return True
        return False

    def _discard_after(self, stamp_ns: int) -> None:
        for queue in self._queues:
            while queue and queue[-1].stamp_ns > stamp_ns:
                queue.pop()
                self.unpaired += 1

    def _discard(self, queue: Queue) -> None:
        queue.popleft()
        self.unpaired += 1

    def _skew_limit_ns(self) -> float:
        first, second = self._period_ns
        return min(self._max_skew_ns, 0.5 * min(first, second)) if first and second else self._max_skew_ns

    def _has_common_rate(self) -> bool:
        """Whether there was a pair and the sampling periods agree within RATE_RATIO."""
        low, high = sorted(self._period_ns)
        return self.pairs > 0 and high <= RATE_RATIO * low

    def _is_delayed(self, later: Queue, earlier: Queue) -> bool | None:
        """Whether the oldest samples correspond and the later one is delayed; None while that is undecided.

        Decided by the first subsequent samples with nominal skew, at the latest after LOOKAHEAD samples.
        """
        nominal_skew = self._skew_ns if later is self._queues[0] else -self._skew_ns
        deviation = shifted_deviation = 0.0
        for j in range(1, min(len(later), len(earlier))):
            stamp_ns = earlier[j].stamp_ns
            aligned = abs(later[j].stamp_ns - stamp_ns - nominal_skew)
            shifted = abs(later[j - 1].stamp_ns - stamp_ns - nominal_skew)
            if min(aligned, shifted) <= JITTER_GATE * self._jitter_ns:
                return aligned < shifted
            deviation, shifted_deviation = deviation + aligned, shifted_deviation + shifted
            if j == LOOKAHEAD:
                return deviation < shifted_deviation
        return None

    def _update_skew(self, skew_ns: float) -> None:
        """Recursive medians of the skew and of its absolute deviation."""
        deviation = skew_ns - self._skew_ns
        jitter = max(self._jitter_ns, JITTER_MIN_NS)
        self._jitter_ns = jitter * (1.0 + PERIOD_GAIN if abs(deviation) > jitter else 1.0 - PERIOD_GAIN)
        self._skew_ns += PERIOD_GAIN * min(max(deviation, -jitter), jitter)


def _is_predicted(sample: TransmissionEstimate) -> bool:
    """Whether the sample is a prediction without measurement."""
    return sample.status == Status.STALE
