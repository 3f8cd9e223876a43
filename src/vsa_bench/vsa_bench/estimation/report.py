# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Table and figure of the results."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from vsa_bench.estimation.cases import Case
from vsa_common.figures import MEASURED, SIDE_1, SIDE_2, TRUTH, panels, save

HEADER = (
    "case", "method", "conv", "5 % [s]", "stiffness", "damping", "k2", "d2",
    "cover s/D/k2", "s from 1 s", "NEES", "/bound s,k2", "wrong", "valid s/D/M", "us/step",
)  # fmt: skip
NOTE = (
    "Errors in %, over the last 30 %: stiffness and damping NRMSE (median), k2 and d2 rms. Coverage of the 95 % "
    "intervals; NEES against 3; wrong: share of samples valid and beyond 4 sd and 1 % (stiffness, damping or inertia)."
)
COLOURS = {"force": SIDE_1, "force_rate": SIDE_2}
MARKERS = {
    "force": "o", "force_rate": "s", "literal_eq17": "x",
    "grioli_bicchi": "v", "recursive_least_squares": "^", "menard": "d",
}  # fmt: skip


def rows(cases: Sequence[Case], results: Sequence[dict[str, dict[str, Any]]]) -> list[list[str]]:
    """One row a method and case, for the terminal."""
    table = []
    for case, methods in zip(cases, results, strict=True):
        for name, r in methods.items():
            cover, valid, wrong, ratios = r["coverage"], r["valid_share"], r["confidently_wrong"], r["ratios_to_bound"]
            defined = [share for share in wrong.values() if share is not None]
            table.append(
                [
                    case.label if name == next(iter(methods)) else "",
                    name,
                    _text(r["converged"], 1, 2),
                    _text(r["time_to_5pct_s"], 1, 1),
                    *(_text(r[key], 100, 2) for key in ("stiffness_nrmse", "damping_nrmse", "k2_error", "d2_error")),
                    "/".join(_text(cover[key], 1, 2) for key in ("stiffness", "damping", "k2")),
                    _text(cover["stiffness_from_1s"], 1, 2),
                    _text(r["nees"], 1, 1),
                    "/".join(_text(ratios.get(key), 1, 1) for key in ("stiffness", "k2")),
                    _text(max(defined) if defined else None, 1, 3),
                    "/".join(_text(valid[key], 1, 1) for key in ("stiffness", "damping", "inertia")),
                    _text(r["us_per_step"], 1, 1),
                ]
            )
    return table


def plot(cases: Sequence[Case], results: Sequence[dict[str, dict[str, Any]]], path: Path) -> None:
    """Stiffness error of every method on every case, and coverage of the methods that state an interval."""
    figure, (left, right) = panels(1, 2, height=1.9 + 0.3 * len(cases), title="Error and coverage of the stiffness")
    places = np.arange(len(cases))[::-1]
    for name, marker in MARKERS.items():
        colour = COLOURS.get(name, TRUTH if name == "literal_eq17" else MEASURED)
        errors = _column(results, name, lambda r: r["stiffness_nrmse"])
        if np.isfinite(errors).any():
            left.plot(100.0 * errors, places, marker, color=colour, label=name.replace("_", " "))
        covers = _column(results, name, lambda r: r["coverage"]["stiffness"])
        if np.isfinite(covers).any():
            right.plot(covers, places, marker, color=colour)
    left.set_xscale("log")
    left.set_yticks(places, [case.label for case in cases])
    left.set_xlabel("stiffness NRMSE [%]")
    figure.legend(loc="outside lower center", ncols=3)
    right.axvspan(0.92, 0.98, color=MEASURED, alpha=0.2)
    right.set_xlim(0.0, 1.03)
    right.set_yticks(places, [""] * len(cases))
    right.set_xlabel("coverage of the 95 % interval of stiffness")
    save(figure, path)


def _column(results: Sequence[dict[str, dict[str, Any]]], method: str, pick: Any) -> Any:
    values = [pick(methods[method]) if method in methods else None for methods in results]
    return np.array([np.nan if value is None else value for value in values])


def _text(value: float | None, scale: float, digits: int) -> str:
    return "-" if value is None else f"{scale * value:.{digits}f}"
