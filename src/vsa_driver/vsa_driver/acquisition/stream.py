"""Signals that are sampled together: their frames are read, checked and put together, and what was wrong is counted."""

from typing import NamedTuple

from vsa_driver.acquisition.counter import COUNTED, RollingCounter
from vsa_driver.acquisition.mapping import Source
from vsa_driver.can.frames import FrameError

COUNTER = "counter"


class Reading(NamedTuple):
    """Signals that were sampled together, in the DBC's units, in the order of their roles."""

    stamp_ns: int
    number: int
    values: tuple[float, ...]


class Stream:
    """Puts the signals of one thing together, from one message or several."""

    def __init__(self, parts: tuple[Source, ...]) -> None:
        self.samples = 0
        self.wrong_length = 0
        self.out_of_range = 0
        self.incomplete = 0  # samples of which a message did not come
        self.sources = parts
        self.roles = tuple(role for part in parts for role in part.roles)
        self._limits = [part.limits for part in parts]
        self._parts: dict[int, tuple[float, ...]] = {}
        self._stamp_ns = 0
        self._counter_index = self.roles.index(COUNTER) if COUNTER in self.roles else -1
        self._counter = RollingCounter(self._bits()) if self._counter_index >= 0 else None

    def add(self, index: int, data: bytes, stamp_ns: int) -> Reading | None:
        """Take a frame of message `index`; what is complete and right with it, or None. Never raises."""
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
            if not self._complete(index, values, stamp_ns):
                return None
            values, stamp_ns = self._merged(), self._stamp_ns
        number = self._number(values, stamp_ns)
        if number is None:
            return None
        self.samples += 1
        return Reading(stamp_ns, number, values)

    @property
    def lost(self) -> int:
        """Samples that the device sent and that did not arrive."""
        return self._counter.lost if self._counter else 0

    def counts(self) -> dict[str, int]:
        """Everything counted, by name."""
        counted = {name: getattr(self, name) for name in ("samples", "wrong_length", "out_of_range", "incomplete")}
        if self._counter is not None:
            counted |= {name: getattr(self._counter, name) for name in COUNTED}
        return counted

    def _complete(self, index: int, values: tuple[float, ...], stamp_ns: int) -> bool:
        if index in self._parts:  # the partner of the last one did not come
            self.incomplete += 1
            self._parts.clear()
        if not self._parts:
            self._stamp_ns = stamp_ns
        self._parts[index] = values
        return len(self._parts) == len(self.sources)

    def _merged(self) -> tuple[float, ...]:
        values = tuple(value for index in range(len(self.sources)) for value in self._parts[index])
        self._parts.clear()
        return values

    def _number(self, values: tuple[float, ...], stamp_ns: int) -> int | None:
        if self._counter is None:
            return self.samples
        return self._counter.add(int(values[self._counter_index]), stamp_ns)

    def _bits(self) -> int:
        return next(part.signal(COUNTER).bits for part in self.sources if COUNTER in part.roles)
