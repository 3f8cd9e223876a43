# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Diagnostics of a node: a status for each of its tasks, and increases of counters."""

import re
from collections import deque
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

OK, WARN, ERROR = 0, 1, 2  # STALE is for the aggregator: a status that is no longer published
REPORT_PERIOD = 1.0  # [s] between two equal diagnostics
CHECK_PERIOD = 0.2  # [s] between two checks for a new level or text
_NUMBERS = re.compile(r"[\d.]+")

Health = tuple[int, str, Mapping[str, object]]  # level (OK, WARN, ERROR), one line, key values
Tasks = Mapping[str, Health]


class DiagnosticsPublisher:
    """Publishes the tasks of a node on /diagnostics: a change at once, an unchanged status once a second."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._last: tuple[dict[str, tuple[int, str]], float] = ({}, 0.0)  # level and text by task, time [s]

    def publish(self, hardware_id: str, tasks: Tasks, now: float) -> None:
        """Publish if a level or text changed, or `REPORT_PERIOD` after the last; `now` [s] of a steady clock.

        The name of a status is "node: task", with the node's namespace. Call it every `CHECK_PERIOD`.
        """
        present = {task: (level, _NUMBERS.sub("", message)) for task, (level, message, _) in tasks.items()}
        last, last_time = self._last
        if present == last and now - last_time < REPORT_PERIOD - 0.5 * CHECK_PERIOD:
            return
        self._last = present, now
        node = self._node.get_fully_qualified_name()
        array = DiagnosticArray(status=[_status(f"{node}: {task}", hardware_id, one) for task, one in tasks.items()])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)


def _status(name: str, hardware_id: str, health: Health) -> DiagnosticStatus:
    level, message, values = health
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return DiagnosticStatus(level=bytes([level]), name=name, message=message, hardware_id=hardware_id, values=pairs)


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

    @property
    def span(self) -> float:
        """Time over which the last increases were counted [s]."""
        return self._past[-1][0] - self._past[0][0] if self._past else 0.0


def format_increases(increases: Mapping[str, int]) -> str:
    """Text for a diagnostic.

    >>> format_increases({"lost": 2, "late": 1})
    'in the last second: lost +2, late +1'
    """
    return "in the last second: " + ", ".join(f"{name} +{count}" for name, count in increases.items())
