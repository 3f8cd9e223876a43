# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Evaluation of injected faults: diagnosis, recovery time, and errors of a stiffness that is marked valid."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_simulator.faults.failure import Failure
from vsa_tools.evaluation.recorded_run import Diagnostic, Floats, Integers

# Acceptance limits of each fault [s]: the requirements on the suite.
MAX_DIAGNOSIS_S = 1.0  # from its begin to the first diagnostic that names it
MAX_RECOVERY_S = 15.0  # from its end to the last sample that is not VALID; a renewed initialization fits into it
MAX_UNDETECTED_S = 0.1  # of wrong stiffness marked valid, without interruption

# A stiffness marked valid is an undetected error where it exceeds both thresholds.
ERROR_THRESHOLD = 0.01  # relative [1]: smaller errors are within the accuracy of healthy operation
DEVIATION_THRESHOLD = 4.0  # in standard deviations [1]: 6e-5 of the samples of a consistent filter exceed it

AFTER_LAST_S = 12.0  # [s] from the begin of the last fault to the end of the run: room for its recovery
STAMP_LEAD_S = 0.02  # [s] the sample before a fault may carry its diagnosis: two sample periods at 100 Hz
INTERVAL_GAP_S = 0.03  # [s] a pause of this length separates two undetected errors: three sample periods at 100 Hz

# Diagnostics that isolate the fault of one sensor.
ISOLATION = re.compile(r"(force sensor|encoder) (stuck|noisy|saturated)|encoder step|deflection at its limit")

# Pattern of the diagnostic, or of the estimator's reason, that names a failure.
DIAGNOSES = {
    "stuck": r"{component}( sensor)? stuck",
    "spike": r"(force|deflection)_rejected",
    "drift": r"inconsistent",
    "noise": r"{component}( sensor)? noisy",
    "saturated": r"saturated|at its limit",
    "wrap": r"encoder step",
    "wrong": r"encoder step|inconsistent",
    "intermittent": r"lost",
    "delayed": r"delayed",
    "duplicate": r"duplicates",
    "reordered": r"late",
    "garbage": r"implausible|wrong_length",
    "off": r"no samples|stuck",
    "bus_off": r"bus-off",
}


class Estimates(NamedTuple):
    """Stiffness of one source and its error, in ascending order of time."""

    time: Floats  # on the rig's clock [s]
    error: Floats  # relative [1]
    deviations: Floats  # error in standard deviations [1]
    valid: NDArray[np.bool_]  # stiffness_valid
    status_valid: NDArray[np.bool_]  # status VALID


class FaultInterval(NamedTuple):
    """One fault on the rig's clock [s]; `until` is the begin of the next one."""

    failure: Failure
    begin: float
    end: float
    until: float


def fault_intervals(events: Sequence[tuple[float, Failure]]) -> list[FaultInterval]:
    """Intervals of the faults of a scenario; each extends to the begin of the next fault."""
    begins = [at for at, _ in events]
    ends = [*begins[1:], begins[-1] + AFTER_LAST_S] if begins else []
    return [
        FaultInterval(failure, at, at + (0.0 if failure.kind == "spike" else failure.duration), until)
        for (at, failure), until in zip(events, ends, strict=True)
    ]


def evaluate_fault(
    interval: FaultInterval, begin_ns: int, diagnostics: Sequence[Diagnostic], sources: Mapping[str, Estimates]
) -> dict[str, Any]:
    """Figures of one fault; `begin_ns` is its begin on the clock of the diagnostics."""
    failure = interval.failure
    pattern = re.compile(DIAGNOSES[failure.kind].format(component=failure.component))
    window_ns = int((interval.until - interval.begin) * 1e9)
    by_time = sorted(diagnostics, key=lambda d: d.stamp_ns)  # messages of two nodes arrive in any order
    within = [d for d in by_time if 0 <= d.stamp_ns - begin_ns < window_ns]
    matches = [d for d in within if pattern.search(d.text) and is_of(failure.instance, d.text)]
    end_ns = matches[0].stamp_ns if matches else begin_ns + window_ns
    other = [d for d in within if d.stamp_ns < end_ns and ISOLATION.search(d.text)]
    recoveries = [recovery_time(source, interval) for source in sources.values()]
    errors = {name: undetected_error(source, interval) for name, source in sources.items()}
    worst = max(errors, key=lambda name: errors[name][0])
    return {
        "at_s": interval.begin,
        "failure": str(failure),
        "diagnosed_after_s": round((matches[0].stamp_ns - begin_ns) * 1e-9, 3) if matches else None,
        "diagnosed_by": matches[0].text if matches else "",
        "wrongly_isolated": other[0].text if other else "",
        "valid_again_after_s": None if None in recoveries else max(time for time in recoveries if time is not None),
        "undetected_error_s": errors[worst][0],
        "undetected_error_source": worst if errors[worst][0] else "",
        "worst_error": errors[worst][1],
    }


def is_of(instance: int, text: str) -> bool:
    """Whether a diagnostic "source: text" is of the transmission `instance`, 0 for any, or of both.

    >>> is_of(1, "transmission_1: encoder stuck"), is_of(1, "/vsa/estimator_2: estimation: encoder stuck")
    (True, False)
    """
    named = set(re.findall(r"(?:transmission|estimator)_(\d)", text))
    return not instance or not named or str(instance) in named


def recovery_time(source: Estimates, interval: FaultInterval) -> float | None:
    """Time from the end of a fault to the last sample that is not VALID [s]; None without recovery before the next."""
    here = (source.time >= interval.begin) & (source.time < interval.until - STAMP_LEAD_S)
    not_valid = source.time[here & ~(source.status_valid & source.valid)]
    if not here.any() or (not_valid.size and not_valid[-1] >= source.time[here][-1]):
        return None
    return round(max(0.0, float(not_valid[-1]) - interval.end), 3) if not_valid.size else 0.0


def undetected_error(source: Estimates, interval: FaultInterval) -> tuple[float, float]:
    """Longest interval of wrong stiffness marked valid [s], and the relative error of greatest magnitude in it."""
    here = (source.time >= interval.begin) & (source.time < interval.until) & source.valid
    wrong = here & (np.abs(source.error) > ERROR_THRESHOLD) & (np.abs(source.deviations) > DEVIATION_THRESHOLD)
    if not wrong.any():
        return 0.0, 0.0
    time, error = source.time[wrong], source.error[wrong]
    intervals = np.split(np.arange(time.size), np.flatnonzero(np.diff(time) > INTERVAL_GAP_S) + 1)
    longest = max(intervals, key=lambda one: time[one[-1]] - time[one[0]])
    length = float(time[longest[-1]] - time[longest[0]])
    return round(length, 3), round(float(error[longest][np.argmax(np.abs(error[longest]))]), 4)


def acceptance(figures: Sequence[Mapping[str, Any]]) -> dict[str, bool]:
    """Whether every fault meets each limit."""

    def all_within(name: str, limit: float) -> bool:
        return all(one[name] is not None and one[name] <= limit for one in figures)

    return {
        "diagnosed": all_within("diagnosed_after_s", MAX_DIAGNOSIS_S),
        "isolated": not any(one["wrongly_isolated"] for one in figures),
        "valid_again": all_within("valid_again_after_s", MAX_RECOVERY_S),
        "no_undetected_error": all_within("undetected_error_s", MAX_UNDETECTED_S),
    }


def failures(figures: Sequence[Mapping[str, Any]]) -> list[str]:
    """A sentence for each limit that a fault does not meet."""
    texts = []
    for one in figures:
        name, after, recovery = (
            f"{one['failure']} at {one['at_s']:g} s",
            one["diagnosed_after_s"],
            one["valid_again_after_s"],
        )
        if one["wrongly_isolated"]:
            texts.append(f"{name}: wrong isolation: {one['wrongly_isolated']}")
        if after is None or after > MAX_DIAGNOSIS_S:
            texts.append(f"{name}: " + ("not diagnosed" if after is None else f"diagnosed after {after:.2f} s"))
        if recovery is None or recovery > MAX_RECOVERY_S:
            texts.append(
                f"{name}: " + ("not valid again" if recovery is None else f"valid again after {recovery:.1f} s")
            )
        if one["undetected_error_s"] > MAX_UNDETECTED_S:
            source = one["undetected_error_source"]
            texts.append(f"{name}: wrong stiffness of {source} marked valid for {one['undetected_error_s']:.2f} s")
    return texts


def rig_time(stamp_ns: Integers, frame_ns: Integers, sample: Integers, rate_hz: float) -> Floats:
    """Time on the rig's clock [s] of `stamp_ns`, interpolated linearly between the stamps of known samples."""
    return np.interp(stamp_ns.astype(float), frame_ns.astype(float), sample / rate_hz)
