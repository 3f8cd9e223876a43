"""Diagnostics of a node: rate of publication, and increases of counters."""

import re
import time
from collections import deque
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

OK, WARN, ERROR, STALE = 0, 1, 2, 3
REPORT_PERIOD = 1.0  # [s] between two equal diagnostics
CHECK_PERIOD = 0.2  # [s] between two checks for a new level or text
_NUMBERS = re.compile(r"[\d.]+")


class DiagnosticsPublisher:
    """Publishes a node's status on /diagnostics: a change at once, an unchanged status once a second."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._last: tuple[int, str, float] = (OK, "", 0.0)  # level, text without numbers, time [s]

    def publish(self, level: int, message: str, values: Mapping[str, object]) -> None:
        """Publish if level or text changed, or `REPORT_PERIOD` after the last. Call it every `CHECK_PERIOD`."""
        now, (last_level, last_text, last_time) = time.monotonic(), self._last
        text = _NUMBERS.sub("", message)
        if (level, text) == (last_level, last_text) and now - last_time < REPORT_PERIOD - 0.5 * CHECK_PERIOD:
            return
        self._last = level, text, now
        status = DiagnosticStatus(level=bytes([level]), name=self._node.get_fully_qualified_name(), message=message)
        status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)


class CounterDelta:
    """Increases of counters over the last `seconds` [s], at any rate of calls; times are of a steady clock.

    >>> delta = CounterDelta()
    >>> delta.increases({"lost": 3}, 0.0), delta.increases({"lost": 5}, 0.4), delta.increases({"lost": 5}, 1.3)
    ({}, {'lost': 2}, {'lost': 2})
    >>> delta.increases({"lost": 5}, 1.5)
    {}
    """

    def __init__(self, seconds: float = 1.0) -> None:
        self._seconds = seconds
        self._past: deque[tuple[float, dict[str, int]]] = deque()

    def increases(self, counts: Mapping[str, int], now: float) -> dict[str, int]:
        """Record `counts` at `now` [s]; the increase of each counter that rose within the last `seconds`."""
        self._past.append((now, dict(counts)))
        while len(self._past) > 2 and now - self._past[1][0] >= self._seconds:
            self._past.popleft()
        first = self._past[0][1]
        return {name: count - first.get(name, 0) for name, count in counts.items() if count > first.get(name, 0)}


def format_increases(increases: Mapping[str, int]) -> str:
    """Text for a diagnostic.

    >>> format_increases({"lost": 2, "late": 1})
    'in the last second: lost +2, late +1'
    """
    return "in the last second: " + ", ".join(f"{name} +{count}" for name, count in increases.items())
