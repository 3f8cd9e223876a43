# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Signals that are sampled together: reads, checks and merges their frames, and counts the rejected ones."""

import math
from typing import NamedTuple

from vsa_driver.acquisition.counter import COUNTED, MeanPeriod, RollingCounter
from vsa_driver.acquisition.mapping import Source
from vsa_driver.can.frames import FrameError
from vsa_driver.tuning import MAX_PAUSE_NS, MERGE_SHARE

COUNTER = "counter"  # role of the signal that numbers the samples


class Reading(NamedTuple):
    """Signals that were sampled together, in the DBC's units, in the order of their roles."""

    stamp_ns: int
    sequence: int
    values: tuple[float, ...]


class Stream:
    """Merges the signals of one channel, which arrive in one message or in several.

    The frames of one sample are closer in time than those of two: a frame later than MERGE_SHARE of the mean period
    after the first one of a sample is of the next sample.
    """

    def __init__(self, sources: tuple[Source, ...]) -> None:
        self.samples = 0
        self.wrong_length = 0
        self.out_of_range = 0
        self.incomplete = 0  # samples of which a message did not arrive
        self.sources = sources
        self.roles = tuple(role for source in sources for role in source.roles)
        self._limits = [source.limits for source in sources]
        self._received: dict[int, tuple[float, ...]] = {}  # values of the present sample, by source
        self._stamp_ns = 0  # of the first frame of the present sample
        self._newest_ns: list[int | None] = [None] * len(sources)  # stamp of the newest frame, by source
        self._periods = [MeanPeriod() for _ in sources]
        self._counter_index = self.roles.index(COUNTER) if COUNTER in self.roles else -1
        self._counter = RollingCounter(self._counter_bits()) if self._counter_index >= 0 else None

    def add(self, index: int, data: bytes, stamp_ns: int) -> Reading | None:
        """Take a frame of source `index`; the valid reading that it completes, or None. Raises nothing."""
        try:
            values = self.sources[index].read(data)
        except FrameError:
            self.wrong_length += 1
            return None
        for value, (low, high) in zip(values, self._limits[index], strict=True):
            if not low <= value <= high:  # also for NaN
                self.out_of_range += 1
                return None
        if len(self.sources) > 1:
            if not self._merge(index, values, stamp_ns):
                return None
            values, stamp_ns = self._take_merged(), self._stamp_ns
        sequence = self._next_sequence(values, stamp_ns)
        if sequence is None:
            return None
        self.samples += 1
        return Reading(stamp_ns, sequence, values)

    def counts(self) -> dict[str, int]:
        """All counters, by name."""
        counted = {name: getattr(self, name) for name in ("samples", "wrong_length", "out_of_range", "incomplete")}
        if self._counter is not None:
            counted |= {name: getattr(self._counter, name) for name in COUNTED}
        return counted

    def _merge(self, index: int, values: tuple[float, ...], stamp_ns: int) -> bool:
        self._update_period(index, stamp_ns)
        if self._received and (index in self._received or not self._is_of_present_sample(stamp_ns)):
            self.incomplete += 1  # a message of the present sample did not arrive
            self._received.clear()
        if not self._received:
            self._stamp_ns = stamp_ns
        self._received[index] = values
        return len(self._received) == len(self.sources)

    def _is_of_present_sample(self, stamp_ns: int) -> bool:
        """Whether a frame is close to the first one of the present sample; true before all periods are known."""
        if any(math.isinf(period.ns) for period in self._periods):
            return True
        period_ns = self._periods[next(iter(self._received))].ns
        return 0 <= stamp_ns - self._stamp_ns <= MERGE_SHARE * period_ns

    def _update_period(self, index: int, stamp_ns: int) -> None:
        newest_ns, self._newest_ns[index] = self._newest_ns[index], stamp_ns
        if newest_ns is not None and 0 < stamp_ns - newest_ns <= MAX_PAUSE_NS:  # no pause, and no clock set back
            period = self._periods[index]
            period.add(min(stamp_ns - newest_ns, 2.0 * period.ns))  # after a loss or with a clock set forward: longer

    def _take_merged(self) -> tuple[float, ...]:
        values = tuple(value for index in range(len(self.sources)) for value in self._received[index])
        self._received.clear()
        return values

    def _next_sequence(self, values: tuple[float, ...], stamp_ns: int) -> int | None:
        if self._counter is None:
            return self.samples
        return self._counter.add(int(values[self._counter_index]), stamp_ns)

    def _counter_bits(self) -> int:
        return next(source.signal(COUNTER).bits for source in self.sources if COUNTER in source.roles)
