"""The live page's state of one part, joint or transmission, as far as it is the same for both."""

import math
from collections.abc import Sequence
from operator import itemgetter
from typing import Any

from vsa_common.ros.cdr import Reader
from vsa_tools.view.events import Events, Turns
from vsa_tools.view.time_series import SILENT, quantity, status_word


class Part:
    """The newest impedance of one part, what its status is, and silence."""

    def __init__(
        self, who: str, reader: Reader, events: Events, quantities: Sequence[str], curves: Sequence[str]
    ) -> None:
        """Each of the `quantities` is followed by its variance and validity in the message; `curves` are its fields."""
        self.seen = -math.inf  # when the last message came, on a steady clock [s]
        self.at = {name: place for place, name in enumerate(reader.names)}
        self.values: tuple[Any, ...] = ()  # of the newest message, in the order of the reader's names
        self._reader = reader
        self._turns = Turns(who, events)
        self._quantities = quantities
        self._pick = itemgetter(*(self.at[name] for name in curves))
        self._status_at = self.at["status"]
        self._status: float | None = None
        self._stamp_ns = 0

    def take(self, data: bytes, now: float) -> tuple[int, tuple[float, ...]]:
        """An impedance as it came, `now` on a steady clock [s]: its stamp [ns] and the numbers of the curves."""
        stamp_ns, values = self._reader.read(data)
        self.values, self.seen, self._stamp_ns = values, now, stamp_ns
        status = values[self._status_at]
        if status != self._status:
            self._status = status
            self._turns.turn(status_word(status, 0.0), stamp_ns)
        return stamp_ns, self._pick(values)

    def fresh(self, now: float) -> bool:
        """Whether what is known is of now."""
        return now - self.seen <= SILENT

    def watch(self, now: float, wall_ns: int) -> None:
        """Notice silence, at `now` [s] of a steady clock and `wall_ns` of the day's."""
        if self.values and not self.fresh(now):
            self._status = None
            self._turns.turn("SILENT", wall_ns)

    def words(self, now: float) -> dict[str, Any]:
        """Status, stamp and quantities."""
        if not self.values:
            return {"status": status_word(None, math.inf)}
        fresh = self.fresh(now)
        return {
            "status": status_word(self.values[self._status_at], now - self.seen),
            "stamp_ns": str(self._stamp_ns),  # as text: a browser's numbers do not hold it
            **{name: quantity(*self.values[self.at[name] :][:3], fresh=fresh) for name in self._quantities},
        }
