# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Time series of the live page: bins with minimum and maximum of every curve, delays, quantities of the table."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from vsa_common.types import Status

BIN_NS = 20_000_000  # [ns] width of a bin: 50 points per second at any data rate
MAX_BINS = 1500  # per curve: 30 s, the longest window of the page
MAX_LAG = 3  # bins that a topic may lag behind the fastest one: 60 ms, above the jitter between the topics
HOLD_BINS = 12  # empty bins that the last value of a slow topic fills: 0.24 s, above the period of estimator_state
TIMEOUT_S = 0.5  # [s] without a message until a topic is SILENT
MAX_JUMP_NS = 3_000_000_000  # [ns] a larger difference between stamps starts a new time axis (restart, other bag)

Extremes = tuple[list[float], list[float]]


class Stream:
    """Minimum and maximum of each number of one topic in bins of BIN_NS of its stamps.

    The value of a name that ends in _std is a variance; its square root is computed once per bin.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._roots = [i for i, name in enumerate(names) if name.endswith("_std")]
        self.newest = -1  # index of the newest bin
        self.restarts = 0
        self._samples: dict[int, list[Sequence[float]]] = {}  # of the open bins
        self._bins: dict[int, Extremes] = {}
        self._on_step_back: Callable[[int], None] = lambda index: None

    def on_step_back(self, call: Callable[[int], None]) -> None:
        """`call` is called with the new bin where the stamps step back by more than MAX_JUMP_NS."""
        self._on_step_back = call

    def add(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Add one sample, in the order of `names`."""
        index = stamp_ns // BIN_NS
        samples = self._samples.get(index)
        if samples is not None:
            samples.append(values)
            return
        if abs(self.newest - index) > MAX_JUMP_NS // BIN_NS:
            self.restarts += self.newest >= 0
            stepped_back = index < self.newest
            self.clear()
            self.newest = index
            if stepped_back:
                self._on_step_back(index)
        self._samples[index] = [values]
        self.newest = max(self.newest, index)
        while len(self._samples) > MAX_LAG + 1:
            self._close(next(iter(self._samples)))
        while len(self._bins) > MAX_BINS:
            del self._bins[next(iter(self._bins))]

    def clear(self) -> None:
        """Remove all samples and bins."""
        self._bins.clear()
        self._samples.clear()
        self.newest = -1

    def close_and_read(self, begin: int, end: int) -> list[Extremes | None]:
        """Close the open bins before `end`; return bins `begin` to `end`.

        An empty bin repeats the last one for up to HOLD_BINS bins, then it is None.
        """
        for index in [index for index in self._samples if index < end]:
            self._close(index)
        rows: list[Extremes | None] = []
        last, age = None, HOLD_BINS
        for index in range(begin - HOLD_BINS, end):
            extremes = self._bins.get(index)
            last, age = (extremes, 0) if extremes else (last, age + 1)
            if index >= begin:
                rows.append(last if age < HOLD_BINS else None)
        return rows

    def _close(self, index: int) -> None:
        columns = list(zip(*self._samples.pop(index), strict=True))
        low, high = list(map(min, columns)), list(map(max, columns))
        for i in self._roots:
            low[i], high[i] = math.sqrt(max(low[i], 0.0)), math.sqrt(max(high[i], 0.0))
        closed = self._bins.get(index)
        if closed:  # late samples
            low, high = list(map(min, low, closed[0])), list(map(max, high, closed[1]))
        self._bins[index] = (low, high)


class TimeSeriesStore:
    """All streams on one time axis."""

    def __init__(self, streams: dict[str, Stream]) -> None:
        self._streams = streams
        for stream in streams.values():
            stream.on_step_back(self._clear_ahead)

    def _clear_ahead(self, index: int) -> None:
        """Clear the streams far ahead of bin `index`: they are of the time axis before a step back of the stamps."""
        for stream in self._streams.values():
            if stream.newest - index > MAX_JUMP_NS // BIN_NS:
                stream.clear()

    @property
    def channels(self) -> list[str]:
        """Names of the columns of a frame, as "transmission_1/force"."""
        return [f"{topic}/{name}" for topic, stream in self._streams.items() for name in stream.names]

    @property
    def epoch(self) -> int:
        """Number of restarts of the time axis; a change invalidates all earlier frames."""
        return sum(stream.restarts for stream in self._streams.values())

    @property
    def end(self) -> int:
        """The first incomplete bin; 0 before the first sample."""
        return max(0, max((stream.newest for stream in self._streams.values()), default=0) - MAX_LAG)

    def frame(self, begin: int) -> dict[str, Any]:
        """Bins from `begin` (at most MAX_BINS) to `end`: minima and maxima for each channel."""
        end = self.end
        begin = max(begin, end - MAX_BINS, 0)
        lows: list[list[float | None]] = []
        highs: list[list[float | None]] = []
        for stream in self._streams.values():
            rows = stream.close_and_read(begin, end)
            for i in range(len(stream.names)):
                lows.append([rounded(row[0][i]) if row else None for row in rows])
                highs.append([rounded(row[1][i]) if row else None for row in rows])
        return {"begin": begin, "end": end, "epoch": self.epoch, "low": lows, "high": highs}


@dataclass
class Delays:
    """Time from sensor stamp to arrival, over the last 1000 to 2000 messages."""

    delays_ms: list[float] = field(default_factory=list)

    def add(self, delay_ns: int) -> None:
        """Add the delay of one message [ns]."""
        self.delays_ms.append(1e-6 * delay_ns)
        if len(self.delays_ms) > 2000:
            del self.delays_ms[:1000]

    def to_json(self) -> dict[str, float]:
        """p50, p99 and max [ms]; empty before the first message or where the clocks differ."""
        ordered = sorted(self.delays_ms)
        if not ordered or not -1.0 < ordered[len(ordered) // 2] < 60e3:
            return {}
        return {
            "p50": round(ordered[len(ordered) // 2], 2),
            "p99": round(ordered[int(0.99 * (len(ordered) - 1))], 2),
            "max": round(ordered[-1], 2),
        }


def status_label(status: float | None, age: float) -> str:
    """Status label of an estimate whose last message is `age` [s] old."""
    if status is None:
        return "WAITING"
    if age > TIMEOUT_S:
        return "SILENT"
    try:
        return Status(int(status)).name
    except ValueError:
        return "UNKNOWN"


def quantity(value: float, variance: float, valid: float, *, current: bool = True) -> dict[str, Any]:
    """An estimate for the page's table, `std` in its unit; only a current value is valid."""
    return {"value": rounded(value), "std": rounded(math.sqrt(max(variance, 0.0))), "valid": bool(valid) and current}


def count_lost(counters: Iterable[int], before: tuple[int, int] | None) -> tuple[int, int]:
    """Newest counter and total of lost frames after a batch of counters; `before` is the result of the last batch."""
    newest, missing = before or (-1, 0)
    for counter in counters:
        if newest < 0 or counter <= newest:  # the first one, or the rig has restarted
            newest = counter
            continue
        missing += counter - newest - 1
        newest = counter
    return newest, missing


def rounded(value: float) -> float | None:
    """Six significant digits; None for a number that JSON cannot represent."""
    return float(f"{value:.6g}") if math.isfinite(value) else None
