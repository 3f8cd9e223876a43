# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Failures to inject, in the syntax of PX4's failure injection, with additional types.

    <component> <failure type> [-i instance] [-t seconds] [-v value]

Instance 0, the default, is all instances; without -t a failure lasts until `ok`; `TYPES` defines -v.
"""

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

# The sensors of the rig and the frames of its transmissions; bus_off stops all frames.
INSTANCES = {"force": 2, "encoder": 2, "angle": 1, "torque": 1, "can_signal": 2}
UNITS = {"force": "N", "encoder": "m", "angle": "rad", "torque": "N m"}

TYPES = {
    "ok": "ends a failure",
    "off": "a sensor reads zero; can_signal sends nothing",
    "stuck": "the same value, or the same frame, every time",
    "garbage": "random values over the whole range, or frames of random bytes",
    "wrong": "value plus -v in the sensor's unit",
    "slow": "only every -v th value or frame is new",
    "delayed": "values or frames are -v seconds old",
    "intermittent": "a fraction -v of the values reads zero, of the frames is lost",
    "spike": "one value, off by -v",
    "drift": "-v per second is added",
    "noise": "-v times the nominal noise",
    "saturated": "reads full scale",
    "wrap": "the encoder is set so that its counter wraps",
    "duplicate": "every frame twice",
    "reordered": "every second frame after the one that follows it",
    "bus_off": "an error frame, then no frames",
}
_ONLY_SENSORS = {"wrong", "spike", "drift", "noise", "saturated"}
_ONLY_FRAMES = {"duplicate", "reordered", "bus_off"}

# Defaults of -v: for any component, and for one component.
_VALUES = {"slow": 10.0, "delayed": 0.05, "intermittent": 0.1, "noise": 10.0}
_SENSOR_VALUES = {
    ("wrong", "force"): 20.0,
    ("wrong", "encoder"): 0.002,
    ("wrong", "angle"): 0.1,
    ("wrong", "torque"): 0.5,
    ("spike", "force"): 1.7,  # a hundred standard deviations
    ("spike", "encoder"): 0.001,
    ("spike", "angle"): 0.01,
    ("spike", "torque"): 0.1,
    ("drift", "force"): 0.2,
    ("drift", "encoder"): 1e-4,
    ("drift", "angle"): 0.01,
    ("drift", "torque"): 0.05,
}


class FailureError(ValueError):
    """An invalid failure, or one that this rig does not support; the text names it."""


@dataclass(frozen=True)
class Failure:
    """One failure of one component; `instance` 0 is all instances."""

    component: str
    kind: str
    instance: int = 0
    duration: float = math.inf  # [s]
    value: float = 0.0

    def __str__(self) -> str:
        text = f"{self.component} {self.kind}"
        text += f" -i {self.instance}" if self.instance else ""
        text += f" -t {self.duration:g}" if math.isfinite(self.duration) else ""
        return text + (f" -v {self.value:g}" if self.value else "")

    def matches(self, component: str, instance: int) -> bool:
        """Whether the failure affects this instance, counted from 1."""
        return self.component == component and self.instance in (0, instance)


@dataclass(frozen=True)
class Event:
    """Event at the time `at` [s] of a scenario: a failure, or a disturbance torque `push` on the joint [N m]."""

    at: float
    failure: Failure | None = None
    push: float | None = None


def parse(text: str) -> Failure:
    """A failure from its text. Raises FailureError.

    >>> parse("failure force stuck -i 1 -t 5")
    Failure(component='force', kind='stuck', instance=1, duration=5.0, value=0.0)
    >>> parse("encoder spike").value
    0.001
    """
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise FailureError(f"{text!r}: {error}") from error
    if words[:1] == ["failure"]:
        words = words[1:]
    if len(words) < 2 or len(words) % 2:
        raise FailureError(f"{text!r}: expected <component> <failure type> [-i instance] [-t seconds] [-v value]")
    component, kind = words[:2]
    if component not in INSTANCES:
        raise FailureError(f"{text!r}: no component {component!r}; there are {', '.join(INSTANCES)}")
    if kind not in TYPES:
        raise FailureError(f"{text!r}: no failure type {kind!r}; there are {', '.join(TYPES)}")
    if not _supported(component, kind):
        raise FailureError(f"{text!r}: unsupported, {component} cannot be {kind}")
    options = _options(text, words[2:])
    instance = options.get("-i", 0.0)
    if instance not in range(INSTANCES[component] + 1):
        raise FailureError(f"{text!r}: instance {instance:g}: there are {INSTANCES[component]} of {component}")
    value = options.get("-v", _SENSOR_VALUES.get((kind, component), _VALUES.get(kind, 0.0)))
    if (kind == "slow" and value < 1.0) or (kind in ("delayed", "noise") and value < 0.0):
        raise FailureError(f"{text!r}: -v {value:g} is too small")
    if kind == "delayed" and value > 60.0:
        raise FailureError(f"{text!r}: -v {value:g}: at most 60 s")
    return Failure(component, kind, int(instance), options.get("-t", math.inf), value)


def scenario(entries: Any) -> tuple[Event, ...]:
    """Events by time from a scenario file's list, `- {at: 20.0, failure: force stuck -i 1 -t 5}`.

    Raises FailureError naming the entry.
    """
    if not isinstance(entries, Sequence) or isinstance(entries, str):
        raise FailureError("expected a list of {at: seconds, failure: text} or {at: seconds, push: N m}")
    return tuple(sorted((_event(number, entry) for number, entry in enumerate(entries, 1)), key=lambda event: event.at))


def _event(number: int, entry: Any) -> Event:
    if not isinstance(entry, Mapping) or set(entry) not in ({"at", "failure"}, {"at", "push"}):
        raise FailureError(f"entry {number}: expected {{at: seconds, failure: text}} or {{at: seconds, push: N m}}")
    for name in ("at", "push"):
        value = entry.get(name, 0.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise FailureError(f"entry {number}: {name} = {value!r}: expected a number")
    if "push" in entry:
        return Event(float(entry["at"]), push=float(entry["push"]))
    try:
        return Event(float(entry["at"]), parse(str(entry["failure"])))
    except FailureError as error:
        raise FailureError(f"entry {number}: {error}") from error


def _supported(component: str, kind: str) -> bool:
    if component == "can_signal":
        return kind not in _ONLY_SENSORS and kind != "wrap"
    return kind not in _ONLY_FRAMES and (kind != "wrap" or component == "encoder")


def _options(text: str, words: Sequence[str]) -> dict[str, float]:
    options: dict[str, float] = {}
    for name, word in zip(words[::2], words[1::2], strict=True):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if name not in ("-i", "-t", "-v") or not math.isfinite(value) or (name == "-t" and value <= 0.0):
            raise FailureError(f"{text!r}: {name} {word}: expected -i instance, -t seconds or -v value")
        options[name] = value
    return options
