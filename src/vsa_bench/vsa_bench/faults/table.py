# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tables of the figures, made from the JSON alone."""

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from vsa_bench.faults.cases import DEFAULT
from vsa_bench.faults.hypotheses import COLUMNS
from vsa_bench.faults.metrics import isolation_matrix
from vsa_bench.faults.summary import Run, bars, fault_figures, grouped, healthy_figures, usable
from vsa_common.terminal import Page

FAULT_HEADER = (
    "fault", "form", "runs", "detected %", "after s", "worst", "isolated %", "wrong s", "longest", "valid after s",
    "worst",
)  # fmt: skip
HEALTHY_HEADER = (
    "recordings", "hours", "alarms", "per hour", "from", "to", "correct reports", "valid %", "wrong %", "least valid %",
)  # fmt: skip
BAR_HEADER = ("required", "limit", "figure", "")
FAULT_NOTE = (
    "All motions and seeds: medians and the worst run. after: from the fault to its first report. isolated: the first "
    "hypothesis that a report names is the right one. wrong: time for which stiffness is valid and off by 4 standard "
    "deviations and 1 %, total and longest. valid after: from the end of a transient fault, or from the detection of a "
    "lasting one, until stiffness stays valid for 1 s; inf: not within the recording, or not "
    "detected."
)
HEALTHY_NOTE = (
    "After the first 6 s of each recording, or 6 s after its introduction. alarms: status DEGRADED or a reset by "
    "innovation or deflection, apart from correct reports: late stamps where they are late, saturation where the force "
    "leaves the sensor's range. from, to: 95 % interval of the rate. least valid: worst recording."
)
GROUPS = ("motion", "stamps", "transmission", "rate_hz")


def _setting(run: dict[str, Any]) -> tuple[int, str]:
    """Rate [Hz] and transmission of a run; older reports have one transmission."""
    return run["rate_hz"], run.get("transmission", DEFAULT)


def pages(report: dict[str, Any]) -> Iterator[Page]:
    """All tables of a report."""
    faults, healthy = report["faults"], report["healthy"]
    for (rate, transmission), runs in grouped(faults, _setting).items():
        by_form = grouped(runs, lambda one: (one["fault"], one["form"]))
        rows = [_fault_row(fault, form, members) for (fault, form), members in by_form.items()]
        yield Page(f"faults at {rate} Hz, {transmission}", FAULT_HEADER, rows, FAULT_NOTE, 2)
    if faults:
        yield _isolation_page(usable(faults))
    if healthy:
        rows = [_healthy_row("all", healthy)]
        for name in GROUPS:
            unit = " Hz" if name == "rate_hz" else ""
            for key, runs in grouped(healthy, lambda one, name=name: one[name]).items():  # type: ignore[misc]
                rows.append(_healthy_row(f"{name.removesuffix('_hz')} {key}{unit}", runs))
        yield Page("healthy motion", HEALTHY_HEADER, rows, HEALTHY_NOTE, 1)
        texts = Counter(text for one in healthy for alarm in one["alarms"] for text in alarm["texts"])
        if texts:
            rows = [[text, str(count)] for text, count in texts.most_common()]
            yield Page("texts of the false alarms", ("text", "alarms"), rows, "", 1)
    required = [[*one[:3], "reached" if one.reached else "missed"] for one in bars(faults, healthy)]
    yield Page("required figures", BAR_HEADER, required, "", 1)


def _isolation_page(runs: list[Run]) -> Page:
    matrix = isolation_matrix((one["fault"], one["named"]) for one in runs)
    named = [one for one in COLUMNS if any(one in row for row in matrix.values())]
    expected = {one["fault"]: one["expected"] for one in runs}
    rows = [
        [fault, expected[fault], *(str(row.get(one, "")) for one in named)] for fault, row in matrix.items()
    ]  # fmt: skip
    return Page("isolation", ("fault", "expected", *named), rows, "Runs by the hypothesis that is named first.", 2)


def _fault_row(fault: str, form: str, runs: list[Run]) -> list[str]:
    figures = fault_figures(runs)
    return [
        fault, form, str(figures.runs), _percent(figures.detected), _seconds(figures.delay),
        _seconds(figures.worst_delay), _percent(figures.isolated), _seconds(figures.wrong),
        _seconds(figures.longest_wrong), _seconds(figures.recovery), _seconds(figures.worst_recovery),
    ]  # fmt: skip


def _healthy_row(name: str, runs: list[Run]) -> list[str]:
    figures = healthy_figures(runs)
    return [
        name, f"{figures.hours:.2f}", str(figures.alarms), f"{figures.rate:.2f}", f"{figures.low:.2f}",
        f"{figures.high:.2f}", str(figures.correct_reports), f"{100.0 * figures.valid:.1f}",
        f"{100.0 * figures.wrong:.2f}", f"{100.0 * min(one['valid'] for one in runs):.1f}",
    ]  # fmt: skip


def _percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100.0 * share:.0f}"


def _seconds(time: float) -> str:
    return "-" if math.isnan(time) else f"{time:.2f}"
