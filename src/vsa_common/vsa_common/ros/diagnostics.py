"""What counters did within the last second, however often one looks."""

from collections import deque
from collections.abc import Mapping


class CounterDelta:
    """Remembers counters for `seconds` [s]; times are of a steady clock.

    >>> recent = Recent()
    >>> recent.rises({"lost": 3}, 0.0), recent.rises({"lost": 5}, 0.4), recent.rises({"lost": 5}, 1.3)
    ({}, {'lost': 2}, {'lost': 2})
    >>> recent.rises({"lost": 5}, 1.5)
    {}
    """

    def __init__(self, seconds: float = 1.0) -> None:
        self._seconds = seconds
        self._past: deque[tuple[float, dict[str, int]]] = deque()

    def increases(self, counts: Mapping[str, int], now: float) -> dict[str, int]:
        """By how much each counter that rose did, since the last look that is no younger than `seconds`."""
        self._past.append((now, dict(counts)))
        while len(self._past) > 2 and now - self._past[1][0] >= self._seconds:
            self._past.popleft()
        first = self._past[0][1]
        return {name: count - first.get(name, 0) for name, count in counts.items() if count > first.get(name, 0)}


def format_increases(rises: Mapping[str, int]) -> str:
    """Words for a diagnostic.

    >>> described({"lost": 2, "late": 1})
    'in the last second: lost +2, late +1'
    """
    return "in the last second: " + ", ".join(f"{name} +{count}" for name, count in rises.items())
