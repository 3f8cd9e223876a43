"""Judgement of a run in which faults were rehearsed: what was said of each, when all was well again, and no lies."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_simulator.faults.failure import Failure
from vsa_tools.evaluation.summary import Floats, Integers

NAMED_S, VALID_S, LYING_S = 1.0, 15.0, 0.1  # what is asked of the suite
OFF, DEVIATIONS = 0.01, 4.0  # a stiffness off by more than both, and marked valid, is a lie
AFTER_S = 12.0  # of the last fault that are still judged
AHEAD_S = 0.02  # what tells of a fault may be stamped so long before it: as the last samples that came through
BROKEN_S = 0.03  # a pause in lying by so much ends a lie

# The words by which the suite names a failure, in diagnostics or in an estimator's reason.
NAMES = {
    "stuck": r"{component}( sensor)? stuck",
    "spike": r"(force|deflection)_rejected",
    "drift": r"contradict",
    "noise": r"{component}( sensor)? noisy",
    "saturated": r"saturated|at its limit",
    "wrap": r"encoder jumped",
    "wrong": r"encoder jumped|contradict",
    "intermittent": r"lost",
    "delayed": r"delayed",
    "duplicate": r"duplicates",
    "reordered": r"late",
    "garbage": r"implausible|wrong_length",
    "off": r"no samples|stuck",
    "bus_off": r"bus-off",
}


@dataclass(frozen=True)
class Saying:
    """One line of a diagnostic or of an estimator's reason; `stamp_ns` is its own."""

    stamp_ns: int
    text: str


class Estimates(NamedTuple):
    """Stiffness of one source with the truth, in order of time on the rig's clock."""

    time: Floats  # [s]
    error: Floats  # relative
    deviations: Floats  # error in standard deviations
    valid: NDArray[np.bool_]  # marked so
    well: NDArray[np.bool_]  # status VALID


class Occasion(NamedTuple):
    """One fault on the rig's clock [s]; `until` is when the next one begins."""

    failure: Failure
    begin: float
    end: float
    until: float


def occasions(events: Sequence[tuple[float, Failure]]) -> list[Occasion]:
    """The faults of a scenario, each judged until the next."""
    begins = [at for at, _ in events]
    ends = [*begins[1:], begins[-1] + AFTER_S] if begins else []
    return [
        Occasion(failure, at, at + (0.0 if failure.kind == "spike" else failure.duration), until)
        for (at, failure), until in zip(events, ends, strict=True)
    ]


def judged(
    occasion: Occasion, begin_ns: int, sayings: Sequence[Saying], sources: Mapping[str, Estimates]
) -> dict[str, Any]:
    """Figures of one fault; `begin_ns` is its begin on the clock of the sayings."""
    failure = occasion.failure
    pattern = re.compile(NAMES[failure.kind].format(component=failure.component))
    window_ns = int((occasion.until - occasion.begin) * 1e9)
    named = [s for s in sayings if 0 <= s.stamp_ns - begin_ns < window_ns and pattern.search(s.text)]
    wells = [well_again(source, occasion) for source in sources.values()]
    lies = {name: undetected_error(source, occasion) for name, source in sources.items()}
    worst = max(lies, key=lambda name: lies[name][0])
    return {
        "at_s": occasion.begin,
        "failure": str(failure),
        "named_after_s": round((named[0].stamp_ns - begin_ns) * 1e-9, 3) if named else None,
        "named_by": named[0].text if named else "",
        "valid_again_after_s": None if None in wells else max(well for well in wells if well is not None),
        "lying_for_s": lies[worst][0],
        "lying": worst if lies[worst][0] else "",
        "worst_error": lies[worst][1],
    }


def well_again(source: Estimates, occasion: Occasion) -> float | None:
    """Time from the end of a fault until all is well for good [s]; None if it is not before the next one."""
    here = (source.time >= occasion.begin) & (source.time < occasion.until - AHEAD_S)
    ill = source.time[here & ~(source.well & source.valid)]
    if not here.any() or (ill.size and ill[-1] >= source.time[here][-1]):
        return None
    return round(max(0.0, float(ill[-1]) - occasion.end), 3) if ill.size else 0.0


def undetected_error(source: Estimates, occasion: Occasion) -> tuple[float, float]:
    """Longest stretch of one fault in which a stiffness marked valid was wrong [s], and its greatest error."""
    here = (source.time >= occasion.begin) & (source.time < occasion.until) & source.valid
    lying = here & (np.abs(source.error) > OFF) & (np.abs(source.deviations) > DEVIATIONS)
    if not lying.any():
        return 0.0, 0.0
    time, error = source.time[lying], source.error[lying]
    stretches = np.split(np.arange(time.size), np.flatnonzero(np.diff(time) > BROKEN_S) + 1)
    longest = max(stretches, key=lambda stretch: time[stretch[-1]] - time[stretch[0]])
    length = float(time[longest[-1]] - time[longest[0]])
    return round(length, 3), round(float(error[longest][np.argmax(np.abs(error[longest]))]), 4)


def verdict(figures: Sequence[Mapping[str, Any]]) -> dict[str, bool]:
    """Whether what is asked was met by every fault."""

    def all_within(name: str, limit: float) -> bool:
        return all(one[name] is not None and one[name] <= limit for one in figures)

    return {
        "named": all_within("named_after_s", NAMED_S),
        "valid_again": all_within("valid_again_after_s", VALID_S),
        "never_lying": all_within("lying_for_s", LYING_S),
    }


def rig_time(stamp_ns: Integers, frame_ns: Integers, sample: Integers, rate_hz: float) -> Floats:
    """Time on the rig's clock [s] of stamps, by the samples whose stamps are known; in between, by proportion."""
    return np.interp(stamp_ns.astype(float), frame_ns.astype(float), sample / rate_hz)
