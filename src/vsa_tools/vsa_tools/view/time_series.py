"""What the live page shows, without clock, network or ROS: bins of least and greatest, words, numbers."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from vsa_common.types import Status

WIDTH_NS = 20_000_000  # of a bin: 50 points a second, however fast the data
KEPT = 1500  # bins that a newly opened page gets, 30 s
LATE = 3  # bins that a slower topic may lag behind the fastest
HELD = 12  # empty bins that a slow topic's last value fills, 0.25 s
SILENT = 0.5  # seconds without a message after which a topic is called silent
FAR = 3_000_000_000  # a stamp that far back begins a new time axis [ns]

Extremes = tuple[list[float], list[float]]


class Stream:
    """Least and greatest of each number of one topic in bins of WIDTH_NS of its own stamps.

    A number whose name ends in _std is given as its variance: the root is taken once a bin.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._roots = [i for i, name in enumerate(names) if name.endswith("_std")]
        self.newest = -1  # index of the bin that is being filled
        self.restarts = 0
        self._samples: dict[int, list[Sequence[float]]] = {}  # of the bins that may still get some
        self._bins: dict[int, Extremes] = {}

    def add(self, stamp_ns: int, values: Sequence[float]) -> None:
        """One sample, in the order of `names`."""
        index = stamp_ns // WIDTH_NS
        found = self._samples.get(index)
        if found is not None:
            found.append(values)
            return
        if abs(self.newest - index) > FAR // WIDTH_NS:
            self.restarts += self.newest >= 0
            self._bins.clear()
            self._samples.clear()
            self.newest = index
        self._samples[index] = [values]
        self.newest = max(self.newest, index)
        while len(self._samples) > LATE + 1:
            self._close(next(iter(self._samples)))
        while len(self._bins) > KEPT:
            del self._bins[next(iter(self._bins))]

    def rows(self, begin: int, end: int) -> list[Extremes | None]:
        """The bins `begin` to `end`, a slow topic's held for HELD bins; None where there is nothing."""
        for index in [index for index in self._samples if index < end]:
            self._close(index)
        found: list[Extremes | None] = []
        last, age = None, HELD
        for index in range(begin - HELD, end):
            here = self._bins.get(index)
            last, age = (here, 0) if here else (last, age + 1)
            if index >= begin:
                found.append(last if age < HELD else None)
        return found

    def _close(self, index: int) -> None:
        columns = list(zip(*self._samples.pop(index), strict=True))
        low, high = list(map(min, columns)), list(map(max, columns))
        for i in self._roots:
            low[i], high[i] = math.sqrt(max(low[i], 0.0)), math.sqrt(max(high[i], 0.0))
        before = self._bins.get(index)
        if before:  # a late sample
            low, high = list(map(min, low, before[0])), list(map(max, high, before[1]))
        self._bins[index] = (low, high)


class Board:
    """All streams on one time axis."""

    def __init__(self, streams: dict[str, Stream]) -> None:
        self._streams = streams

    @property
    def channels(self) -> list[str]:
        """Names of the columns of a frame, "transmission_1/force" and so on."""
        return [f"{topic}/{name}" for topic, stream in self._streams.items() for name in stream.names]

    @property
    def era(self) -> int:
        """Grows when stamps jump and what was shown is void."""
        return sum(stream.restarts for stream in self._streams.values())

    @property
    def end(self) -> int:
        """The first bin that is not complete yet; 0 before the first sample."""
        return max(0, max((stream.newest for stream in self._streams.values()), default=0) - LATE)

    def frame(self, begin: int) -> dict[str, Any]:
        """Bins from `begin` (at most KEPT) to `end`: start, and for each channel its lows and highs."""
        end = self.end
        begin = max(begin, end - KEPT, 0)
        lows: list[list[float | None]] = []
        highs: list[list[float | None]] = []
        for stream in self._streams.values():
            rows = stream.rows(begin, end)
            for i in range(len(stream.names)):
                lows.append([_short(row[0][i]) if row else None for row in rows])
                highs.append([_short(row[1][i]) if row else None for row in rows])
        return {"begin": begin, "end": end, "era": self.era, "low": lows, "high": highs}


@dataclass
class Delays:
    """Time from sensor stamp to arrival, over the last messages."""

    kept: list[float] = field(default_factory=list)  # [ms]

    def add(self, delay_ns: int) -> None:
        """One message's delay."""
        self.kept.append(1e-6 * delay_ns)
        if len(self.kept) > 2000:
            del self.kept[:1000]

    def words(self) -> dict[str, float]:
        """p50, p99 and max [ms]; nothing before the first message or where the clocks differ."""
        ordered = sorted(self.kept)
        if not ordered or not -1.0 < ordered[len(ordered) // 2] < 60e3:
            return {}
        return {
            "p50": round(ordered[len(ordered) // 2], 2),
            "p99": round(ordered[int(0.99 * (len(ordered) - 1))], 2),
            "max": round(ordered[-1], 2),
        }


def status_word(status: float | None, age: float) -> str:
    """One word for the state of an estimate whose last message is `age` old [s]."""
    if status is None:
        return "WAITING"
    if age > SILENT:
        return "SILENT"
    try:
        return Status(int(status)).name
    except ValueError:
        return "UNKNOWN"


def quantity(value: float, variance: float, valid: float, *, fresh: bool = True) -> dict[str, Any]:
    """An estimate as the page's table shows it, `std` in its unit; what is not fresh is not valid either."""
    return {"value": _short(value), "std": _short(math.sqrt(max(variance, 0.0))), "valid": bool(valid) and fresh}


def lost(counters: Iterable[int], before: tuple[int, int] | None) -> tuple[int, int]:
    """(newest counter, frames lost so far) from the counters of a batch, given the same of the batch before."""
    newest, missing = before or (-1, 0)
    for counter in counters:
        if newest < 0 or counter <= newest:  # the first, or the rig began anew
            newest = counter
            continue
        missing += counter - newest - 1
        newest = counter
    return newest, missing


def _short(value: float) -> float | None:
    """Six digits; None for what JSON has no word for."""
    return float(f"{value:.6g}") if math.isfinite(value) else None
