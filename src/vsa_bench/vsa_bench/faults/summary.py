# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Aggregates over the runs of a report: figures of the faults and of healthy motion, required figures."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from vsa_bench.faults.metrics import poisson_interval

MAX_ALARMS_PER_HOUR = 0.01
MIN_VALID, MAX_WRONG = 0.97, 0.005  # shares of healthy samples
MAX_WRONG_S = 0.1  # longest time that a stiffness is wrong and valid, in every run with a fault
MEDIAN_RECOVERY_S, MAX_RECOVERY_S = 1.0, 3.0  # of transient faults

Run = dict[str, Any]  # an entry of the JSON


class FaultFigures(NamedTuple):
    """Figures of a group of runs; times in s, infinite where a run has none."""

    runs: int
    detected: float  # share
    delay: float  # median
    worst_delay: float
    isolated: float  # share whose first named hypothesis is the expected one
    wrong: float  # median of the total time
    longest_wrong: float  # of all runs
    recovery: float  # median
    worst_recovery: float


class HealthyFigures(NamedTuple):
    """Figures of a group of healthy runs; rates per hour with the 95 % interval."""

    hours: float
    alarms: int
    rate: float
    low: float
    high: float
    correct_reports: int
    valid: float  # share of the samples
    wrong: float


class Bar(NamedTuple):
    """One required figure."""

    quantity: str
    limit: str
    figure: str
    reached: bool


def fault_figures(runs: Sequence[Run]) -> FaultFigures:
    """Figures of the runs whose stiffness is valid before the fault, else of none."""
    runs = usable(runs)
    if not runs:
        return FaultFigures(0, *[np.nan] * 8)
    delays, recoveries = _times(runs, "detected_after_s"), _times(runs, "time_to_valid_s")
    return FaultFigures(
        runs=len(runs),
        detected=float(np.mean(np.isfinite(delays))),
        delay=float(np.median(delays)),
        worst_delay=float(max(delays)),
        isolated=float(np.mean([one["named"] == one["expected"] for one in runs])),
        wrong=float(np.median([one["wrong_s"] for one in runs])),
        longest_wrong=max(one["longest_wrong_s"] for one in runs),
        recovery=float(np.median(recoveries)),
        worst_recovery=float(max(recoveries)),
    )


def usable(runs: Sequence[Run]) -> list[Run]:
    """Runs whose stiffness is valid before the fault."""
    return [one for one in runs if one["valid_before"]]


def healthy_figures(runs: Sequence[Run]) -> HealthyFigures:
    """Figures of the healthy runs; shares weighted by their hours."""
    hours, count = sum(one["hours"] for one in runs), sum(len(one["alarms"]) for one in runs)
    valid, wrong = (sum(one[name] * one["hours"] for one in runs) / hours for name in ("valid", "wrong"))
    low, high = poisson_interval(count, hours)
    reports = sum(one["correct_reports"] for one in runs)
    return HealthyFigures(hours, count, count / hours, low, high, reports, valid, wrong)


def grouped(runs: Sequence[Run], key: Callable[[Run], Any]) -> dict[Any, list[Run]]:
    """Runs by `key`, in order of their first occurrence."""
    result: dict[Any, list[Run]] = {}
    for one in runs:
        result.setdefault(key(one), []).append(one)
    return result


def bars(faults: Sequence[Run], healthy: Sequence[Run]) -> Iterator[Bar]:
    """Required figures that the runs define."""
    if healthy:
        figures = healthy_figures(healthy)
        yield _bar("false alarms per hour", figures.rate, MAX_ALARMS_PER_HOUR, "{:.2f}")
        worst = min(one["valid"] for one in healthy)
        yield Bar("stiffness valid, worst recording", f">= {MIN_VALID:.0%}", f"{worst:.1%}", worst >= MIN_VALID)
        yield _bar("valid and wrong, worst recording", max(one["wrong"] for one in healthy), MAX_WRONG, "{:.2%}")
    if usable(faults):
        figures_all = fault_figures(faults)
        yield _bar("valid and wrong at a fault, longest", figures_all.longest_wrong, MAX_WRONG_S, "{:.2f} s")
    transient = usable([one for one in faults if one["form"] != "lasting"])
    if transient:
        figures_all = fault_figures(transient)
        yield _bar("valid again after a transient fault, median", figures_all.recovery, MEDIAN_RECOVERY_S, "{:.2f} s")
        yield _bar("valid again after a transient fault, worst", figures_all.worst_recovery, MAX_RECOVERY_S, "{:.2f} s")


def _bar(quantity: str, figure: float, limit: float, form: str) -> Bar:
    return Bar(quantity, "<= " + form.format(limit), form.format(figure), figure <= limit)


def _times(runs: Sequence[Run], name: str) -> list[float]:
    return [np.inf if one[name] is None else one[name] for one in runs]
