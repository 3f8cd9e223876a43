# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Counters that wrap: a continuous encoder count, and the sequence number of a sample with a check for gaps."""

import math
import statistics
from collections import deque

from vsa_driver.tuning import (
    BACKLOG_DECAY,
    DELAY_PERIODS,
    DELAY_THRESHOLD_NS,
    MAX_PAUSE_NS,
    MAX_REORDER,
    MAX_SKIP,
    MIN_INTERVALS,
    MIN_PERIOD_ESTIMATES,
    PERIOD_BLOCK,
    PERIOD_ESTIMATES,
    PERIOD_GAIN,
    RATE_MARGIN,
)

COUNTED = ("lost", "duplicates", "late", "restarts", "implausible", "delayed")  # attributes of a RollingCounter


class Unwrapped:
    """A value that wraps with a period, made continuous in both directions.

    A value further from `centre` than `max_travel` and half a period is the result of a corrupted count: the
    unwrapping restarts nearest to the centre.

    >>> count = Unwrapped(period=65536, centre=1000)
    >>> [count.add(raw) for raw in (65530, 65535, 4, 65534)]
    [-6.0, -1.0, 4.0, -2.0]
    """

    def __init__(self, period: float, centre: float, max_travel: float = math.inf) -> None:
        self._period = period
        self._centre = centre
        self._max_distance = max_travel + 0.5 * period
        self._last = centre  # the first value is unwrapped nearest to the centre

    def add(self, value: float) -> float:
        """`value` plus the number of periods that brings it nearest to the previous one."""
        self._last += math.remainder(value - self._last, self._period)
        if abs(self._last - self._centre) > self._max_distance:
            self._last = self._centre + math.remainder(value - self._centre, self._period)
        return self._last


class MeanPeriod:
    """Running mean of the sampling period; inf before the first interval."""

    def __init__(self) -> None:
        self.ns = math.inf
        self.intervals = 0  # in the mean

    def add(self, interval_ns: float) -> None:
        """Take the interval between two samples [ns]; one below 1 ns counts as 1 ns."""
        self.intervals += 1
        if math.isinf(self.ns):
            self.ns = max(interval_ns, 1.0)
        else:
            self.ns += (max(interval_ns, 1.0) - self.ns) * max(PERIOD_GAIN, 1.0 / self.intervals)


class RollingCounter:
    """Sequence number of a sample from a counter of few bits; counts lost, repeated, late and delayed samples.

    The elapsed time distinguishes a wrap during a long silence from a short gap, and a restarted device from a gap.
    """

    def __init__(self, bits: int) -> None:
        self.lost = 0  # samples sent that did not arrive
        self.duplicates = 0
        self.late = 0  # samples out of order
        self.restarts = 0  # of the device
        self.implausible = 0  # steps of the counter that the next frame did not confirm, or the first that it did
        self.delayed = 0  # samples later than their sequence numbers and the nominal period allow
        self._modulus = 1 << bits
        self._max_reorder = min(MAX_REORDER, self._modulus // 8)
        self._sequence: int | None = None
        self._stamp_ns = 0
        self._candidate: int | None = None  # count of the last frame, where its step was implausible
        self._period = MeanPeriod()
        self._nominal_period_ns = 0.0  # median of the estimates
        self._period_estimates: deque[float] = deque(maxlen=PERIOD_ESTIMATES)  # [ns]
        self._block_ns, self._block_samples = 0.0, 0  # of the next estimate
        self._backlog_ns = 0.0

    def add(self, raw: int, stamp_ns: int) -> int | None:
        """Continuous sequence number of the sample; None for a repeated, late or implausible one."""
        if self._sequence is None:
            return self._accept(raw, stamp_ns)
        step = (raw - self._sequence) % self._modulus
        elapsed = (stamp_ns - self._stamp_ns) / self._period.ns  # in samples
        if step > 1 and elapsed > self._modulus // 2:  # a step of 1 is of a device that paused
            step += self._modulus * max(0, round((elapsed - step) / self._modulus))
        if step == 0:
            self.duplicates += 1
            return None
        if self._modulus - self._max_reorder <= step < self._modulus and elapsed < step / 2:
            self.late += 1
            return None
        if step > MAX_SKIP + RATE_MARGIN * elapsed and not self._is_confirmed(raw):
            self._candidate = raw
            self.implausible += 1
            return None
        if self._is_restart(step, elapsed):
            self.restarts += 1
            return self._accept(raw, stamp_ns)
        self.lost += step - 1
        self._update_backlog(stamp_ns - self._stamp_ns, step)
        self._period.add((stamp_ns - self._stamp_ns) / step)
        return self._accept(self._sequence + step, stamp_ns)

    def _is_confirmed(self, raw: int) -> bool:
        """Whether `raw` follows the implausible count of the frame before."""
        return self._candidate is not None and 0 < (raw - self._candidate) % self._modulus <= self._max_reorder

    def _is_restart(self, step: int, elapsed: float) -> bool:
        # more samples than the elapsed time allows; a burst of a stalled adapter may be an eighth of the counter
        return step > self._modulus // 8 + RATE_MARGIN * elapsed

    def _accept(self, sequence: int, stamp_ns: int) -> int:
        self._sequence, self._stamp_ns, self._candidate = sequence, stamp_ns, None
        return sequence

    def _update_backlog(self, elapsed_ns: float, step: int) -> None:
        if elapsed_ns > MAX_PAUSE_NS or self._period.intervals < MIN_INTERVALS:
            self._backlog_ns, self._block_ns, self._block_samples = 0.0, 0.0, 0
            return
        self._block_ns += elapsed_ns
        self._block_samples += step
        if self._block_samples >= PERIOD_BLOCK:
            self._period_estimates.append(self._block_ns / self._block_samples)
            self._block_ns, self._block_samples = 0.0, 0
            self._nominal_period_ns = statistics.median(self._period_estimates)
        if len(self._period_estimates) < MIN_PERIOD_ESTIMATES:
            return
        excess_ns = elapsed_ns - step * self._nominal_period_ns
        self._backlog_ns = max(0.0, (1.0 - BACKLOG_DECAY) ** step * self._backlog_ns + excess_ns)
        self.delayed += self._backlog_ns > max(DELAY_THRESHOLD_NS, DELAY_PERIODS * self._period.ns)
