# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tables of the figures, made from the JSON alone: for the terminal, and as Markdown."""

from collections.abc import Iterator, Sequence
from typing import Any

from vsa_bench.mismatch.bars import bars, best_peer
from vsa_bench.mismatch.cases import DRAWN_GROUP, VARIANTS
from vsa_common.terminal import Page

QUANTITY = ("valid", "error", "cover", "wrong", "+-")
FIGURES = (
    f"stiffness {QUANTITY[0]}", *QUANTITY[1:], "5 % after s", f"damping {QUANTITY[0]}", *QUANTITY[1:],
)  # fmt: skip
CASE_HEADER = ("case", "motion", "Hz", "best peer", "peer error", *FIGURES)
DRAWN_HEADER = ("case", "laws, sensors; motion", "Hz", *FIGURES[:5], "damping wrong")
WORST_HEADER = ("case", "best peer", "peer error", *FIGURES)
BAR_HEADER = ("required", "limit", "figure", "worst case", "missed in", "")
RECORDED_HEADER = ("recording", "start", "reference", "points", "valid", "error", "cover", "wrong", "+-")
NOTE = (
    "Median over the seeds, after the first 30 %, in % but for cover (share of the valid samples whose 95 % interval "
    "contains the truth). error and +- (half-width): medians over the valid samples; of damping relative to max(D, "
    "0.2 d1). wrong: share of the samples that are valid and off by 4 standard deviations and 1 %. 5 % after s: "
    "from when on the stiffness is within 5 %. peer error: of stiffness, over all "
    "samples."
)
RECORDED_NOTE = (
    "start: values of the estimator, default or those of `identify` on the file; local regression: not the estimator "
    "but the reference itself. reference: local regression, or the true stiffness of a simulated recording. points: "
    "instants compared, after the first 30 %. cover: of the estimate's interval combined with the reference's."
)
# Which extreme over motions and rates is the worst.
WORST = {"valid": min, "coverage": min, "error": max, "wrong": max, "half_width": max}


def pages(report: dict[str, Any]) -> Iterator[Page]:
    """All tables of a report: groups, drawn cases, the worst of each listed case, required figures, recordings."""
    cases = report["cases"]
    for group in VARIANTS:
        members = [one for one in cases if one["group"] == group]
        if members:
            yield Page(group.replace("_", " "), CASE_HEADER, [_row(one) for one in members], "", 4)
    drawn = [one for one in cases if one["group"] == DRAWN_GROUP]
    if drawn:
        yield Page(DRAWN_GROUP, DRAWN_HEADER, [_drawn_row(one) for one in drawn], NOTE, 3)
    names = list(dict.fromkeys(one["case"] for one in cases if one["group"] != DRAWN_GROUP))
    if names:
        rows = [_worst_row(name, [one for one in cases if one["case"] == name]) for name in names]
        yield Page("worst of the motions and rates", WORST_HEADER, rows, NOTE, 2)
    if cases:
        yield Page("required figures", BAR_HEADER, [_bar_row(*one) for one in bars(cases)], "", 1)
    if report["recorded"]:
        rows = [_recorded_row(one) for one in report["recorded"]]
        yield Page("real recordings: stiffness", RECORDED_HEADER, rows, RECORDED_NOTE, 3)


def _row(case: dict[str, Any]) -> list[str]:
    median, peer = case["median"], best_peer(case)
    return [
        case["case"],
        case["motion"],
        str(case["rate_hz"]),
        *_peer_cells(peer),
        *_quantity_cells(median["stiffness"]),
        _number(median["time_to_5pct_s"], 1),
        *_quantity_cells(median["damping"]),
    ]


def _drawn_row(case: dict[str, Any]) -> list[str]:
    stiffness, damping = case["median"]["stiffness"], case["median"]["damping"]
    wrong = _percent(damping["wrong"], 2)
    return [case["case"], case["motion"], str(case["rate_hz"]), *_quantity_cells(stiffness), wrong]


def _worst_row(name: str, cases: Sequence[dict[str, Any]]) -> list[str]:
    """The worst figures of a case over its motions and rates; of the peers, the best where it is worst."""
    peers = [one for one in map(best_peer, cases) if one]
    times = [one["median"]["time_to_5pct_s"] for one in cases]
    return [
        name,
        *_peer_cells(max(peers, key=lambda one: one[1], default=None)),
        *_quantity_cells(_worst("stiffness", cases)),
        "-" if None in times else _number(max(times), 1),
        *_quantity_cells(_worst("damping", cases)),
    ]


def _worst(name: str, cases: Sequence[dict[str, Any]]) -> dict[str, float | None]:
    result = {}
    for key, extreme in WORST.items():
        values = [value for one in cases if (value := one["median"][name][key]) is not None]
        result[key] = extreme(values, default=None)
    return result


def _bar_row(
    quantity: str, limit: str, figure: str, worst: str, missed: int | None, cases: int, reached: bool
) -> list[str]:
    share = f"mean of {cases}" if missed is None else f"{missed} of {cases}"
    return [quantity, limit, figure, worst, share, "reached" if reached else "missed"]


def _recorded_row(one: dict[str, Any]) -> list[str]:
    return [
        one["recording"], one["start"], one["reference"], str(one["points"]), *_quantity_cells(one["stiffness"]),
    ]  # fmt: skip


def _peer_cells(peer: tuple[str, float] | None) -> list[str]:
    return ["-", "-"] if peer is None else [peer[0].replace("_", " "), _percent(peer[1], 2)]


def _quantity_cells(figures: dict[str, float | None]) -> list[str]:
    return [
        _percent(figures["valid"], 0), _percent(figures["error"], 2), _number(figures["coverage"], 2),
        _percent(figures["wrong"], 2), _percent(figures["half_width"], 2),
    ]  # fmt: skip


def _percent(share: float | None, digits: int) -> str:
    return _number(None if share is None else 100.0 * share, digits)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
