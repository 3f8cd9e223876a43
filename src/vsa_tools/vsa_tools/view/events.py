# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Events of the live page: changes of status, resets, lost samples, diagnostics."""

from collections import deque
from dataclasses import dataclass
from typing import Any

from vsa_common.stamps import NANOSECONDS

MAX_EVENTS = 40  # of the list: about two screens
REPEAT_NS = 2 * NANOSECONDS  # [ns] a repetition within this time is counted, not listed again
REPEAT_DEPTH = 4  # last events among which a repetition is searched: alternating events count as repeated
SEVERITIES = {
    "VALID": "ok", "CONVERGING": "info", "INITIALIZING": "info",
    "DEGRADED": "warning", "STALE": "warning", "MODEL_INADEQUATE": "warning",
}  # fmt: skip


@dataclass
class Event:
    """`text` of `source`, which occurred `count` times, last at `time_ns`; severity ok, info, warning or error."""

    time_ns: int
    source: str
    text: str
    severity: str
    count: int


class Events:
    """The last MAX_EVENTS events, newest last."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=MAX_EVENTS)

    def add(self, time_ns: int, source: str, text: str, severity: str, count: int = 1) -> None:
        """Add `count` occurrences at `time_ns`; a repetition within REPEAT_NS increments the count of its event."""
        for event in list(self._events)[-REPEAT_DEPTH:]:
            if (event.source, event.text) == (source, text) and abs(time_ns - event.time_ns) < REPEAT_NS:
                event.time_ns, event.count = time_ns, event.count + count
                return
        self._events.append(Event(time_ns, source, text, severity, count))

    def to_json(self) -> list[dict[str, Any]]:
        """All events; their time in seconds since 1970."""
        return [
            {"time": round(event.time_ns / NANOSECONDS, 3), "source": event.source, "text": event.text}
            | {"severity": event.severity, "count": event.count}
            for event in self._events
        ]


class StatusTracker:
    """The status of one source; each change is an event."""

    def __init__(self, source: str, events: Events) -> None:
        self._status = "WAITING"
        self._source, self._events = source, events

    def update(self, status: str, time_ns: int) -> None:
        """The status is `status` from `time_ns` on."""
        if status != self._status:
            self._events.add(time_ns, self._source, f"{self._status} → {status}", SEVERITIES.get(status, "error"))
            self._status = status


class CounterWatch:
    """Monotonic counters of one source; each increment is an event."""

    def __init__(self, source: str, events: Events) -> None:
        self._source, self._events = source, events
        self._last: dict[str, int] = {}

    def update(self, text: str, total: int, time_ns: int, severity: str = "warning") -> None:
        """The counter of `text` is `total` at `time_ns`; its first value is the reference."""
        increment = total - self._last.get(text, total)
        self._last[text] = total
        if increment > 0:
            self._events.add(time_ns, self._source, text, severity, increment)
