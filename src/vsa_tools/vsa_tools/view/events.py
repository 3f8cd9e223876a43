"""What happened, as the live page tells it: changes of status, resets, lost samples, complaints."""

from collections import deque
from dataclasses import dataclass
from typing import Any

from vsa_common.stamps import NANOSECONDS

KEPT = 40  # events
APART_NS = 2 * NANOSECONDS  # what repeats sooner is counted, not told again
LOOK_BACK = 4  # events among which a repetition is looked for
TONES = {"VALID": "good", "CONVERGING": "note", "INITIALIZING": "note", "DEGRADED": "warn", "STALE": "warn"}


@dataclass
class Event:
    """Something that happened `times` times to `who`, last at `time_ns`; `tone` is good, note, warn or bad."""

    time_ns: int
    who: str
    text: str
    tone: str
    times: int


class Events:
    """The last events, newest last."""

    def __init__(self) -> None:
        self._kept: deque[Event] = deque(maxlen=KEPT)

    def add(self, time_ns: int, who: str, text: str, tone: str, times: int = 1) -> None:
        """Tell that something happened at `time_ns`, `times` times since it was told last."""
        for event in list(self._kept)[-LOOK_BACK:]:
            if (event.who, event.text) == (who, text) and abs(time_ns - event.time_ns) < APART_NS:
                event.time_ns, event.times = time_ns, event.times + times
                return
        self._kept.append(Event(time_ns, who, text, tone, times))

    def words(self) -> list[dict[str, Any]]:
        """All that are kept, with their time in seconds since 1970."""
        return [
            {"time": round(event.time_ns / NANOSECONDS, 3), "who": event.who, "text": event.text}
            | {"tone": event.tone, "times": event.times}
            for event in self._kept
        ]


class Turns:
    """The status word of one part, and an event whenever it turns into another."""

    def __init__(self, who: str, events: Events) -> None:
        self.word = "WAITING"
        self._who, self._events = who, events

    def turn(self, word: str, time_ns: int) -> None:
        """The status is `word` from `time_ns` on."""
        if word != self.word:
            self._events.add(time_ns, self._who, f"{self.word} → {word}", TONES.get(word, "bad"))
            self.word = word


class Tally:
    """Counts that only grow, and an event whenever one did."""

    def __init__(self, who: str, events: Events) -> None:
        self._who, self._events = who, events
        self._before: dict[str, int] = {}

    def count(self, text: str, total: int, time_ns: int, tone: str = "warn") -> None:
        """`total` of what `text` tells at `time_ns`; the first total is where counting starts."""
        grown = total - self._before.get(text, total)
        self._before[text] = total
        if grown > 0:
            self._events.add(time_ns, self._who, text, tone, grown)
