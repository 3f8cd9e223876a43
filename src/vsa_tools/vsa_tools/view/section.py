# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State of the joint or of one transmission on the live page: what both have in common."""

import math
from collections.abc import Sequence
from operator import itemgetter
from typing import Any

from vsa_common.ros.cdr import Reader
from vsa_tools.view.events import Events, StatusTracker
from vsa_tools.view.time_series import TIMEOUT_S, quantity, status_label


class Section:
    """The newest impedance of one source, its status, and its timeout."""

    def __init__(
        self, source: str, reader: Reader, events: Events, quantities: Sequence[str], curves: Sequence[str]
    ) -> None:
        """In the message variance and validity follow each of `quantities`; `curves` are fields of the message."""
        self.last_time = -math.inf  # of the last message, on a steady clock [s]
        self.index = {name: i for i, name in enumerate(reader.names)}
        self.values: tuple[Any, ...] = ()  # of the newest message, in the order of the reader's names
        self._reader = reader
        self._status_tracker = StatusTracker(source, events)
        self._quantities = quantities
        self._select = itemgetter(*(self.index[name] for name in curves))
        self._status: float | None = None
        self._stamp_ns = 0

    def add_impedance_message(self, data: bytes, now: float) -> tuple[int, tuple[float, ...]]:
        """Add a serialized impedance at `now` [s] of a steady clock; returns its stamp [ns] and the curves' values."""
        stamp_ns, values = self._reader.read(data)
        self.values, self.last_time, self._stamp_ns = values, now, stamp_ns
        status = values[self.index["status"]]
        if status != self._status:
            self._status = status
            self._status_tracker.update(status_label(status, 0.0), stamp_ns)
        return stamp_ns, self._select(values)

    def is_current(self, now: float) -> bool:
        """Whether the last message is younger than TIMEOUT_S."""
        return now - self.last_time <= TIMEOUT_S

    def check_timeout(self, now: float, wall_ns: int) -> None:
        """Detect a timeout at `now` [s] of a steady clock and `wall_ns` of the wall clock."""
        if self.values and not self.is_current(now):
            self._status = None
            self._status_tracker.update("SILENT", wall_ns)

    def to_json(self, now: float) -> dict[str, Any]:
        """Status, stamp and quantities."""
        if not self.values:
            return {"status": status_label(None, math.inf)}
        current = self.is_current(now)
        return {
            "status": status_label(self.values[self.index["status"]], now - self.last_time),
            "stamp_ns": str(self._stamp_ns),  # as text: a JavaScript number has only 53 bits
            **{name: quantity(*self.values[self.index[name] :][:3], current=current) for name in self._quantities},
        }
