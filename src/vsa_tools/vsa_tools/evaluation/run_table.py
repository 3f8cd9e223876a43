# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tables of summary.json on the terminal."""

from collections.abc import Mapping
from typing import Any

from vsa_common.terminal import show_table
from vsa_tools.evaluation.summary import Z95

PAPER_UNITS = {
    "k2": (1e-3, "1/mm"),
    "d2": (1e-9, "N s^3/mm^3"),
    "stiffness": (1e-3, "N/mm"),
    "damping": (1e-3, "N s/mm"),
    "inertia": (1.0, "kg"),
}


def show(summary: Mapping[str, Any]) -> None:
    """Print the coefficients in the paper's units, and the errors of stiffness and damping."""
    rows = [
        row
        for side, figures in summary["transmissions"].items()
        for row in (_coefficient_row(side, name, figures[name]) for name in _listed(figures))
    ]
    columns = ("", "coefficient", "start", "estimate (95 %)", "truth", "error")
    show_table("Coefficients at the end, as in Table I of the paper", columns, rows, texts=2)
    quality = [_quality_row(side, figures) for side, figures in summary["transmissions"].items()]
    quality.append(_quality_row("joint", summary["joint"]))
    heads = ("", "stiffness error", "coverage", "damping error", "coverage", "lost / sent", "converged after")
    latency = summary["latency_ms"]
    note = (
        "errors: rms of the last 30 % of the run over rms of the truth. Latency from CAN frame to joint message at a "
        f"subscriber: median {_number(latency['p50'])} ms, 99th percentile {_number(latency['p99'])} ms, "
        f"maximum {_number(latency['max'])} ms"
    )
    show_table("Stiffness and damping against the truth", heads, quality, note)


def _listed(figures: Mapping[str, Any]) -> list[str]:
    """Names of a table's rows: with laws other than the paper's, stiffness and damping in place of k2 and d2."""
    absent = ("k2", "d2") if "stiffness" in figures else ("stiffness", "damping")
    return [name for name in PAPER_UNITS if name not in absent]


def _coefficient_row(side: str, name: str, figures: Mapping[str, Any]) -> list[str]:
    scale, unit = PAPER_UNITS[name]
    start, estimate, std, truth = (figures[key] * scale for key in ("start", "estimate", "std", "truth"))
    observable = figures.get("valid", True)
    error = f"{100.0 * (estimate / truth - 1.0):+.2f} %" if observable and truth else "not observable here"
    return [side, f"{name}, {unit}", f"{start:.4g}", f"{estimate:.5g} ± {Z95 * std:.2g}", f"{truth:.5g}", error]


def _quality_row(name: str, figures: Mapping[str, Any]) -> list[str]:
    lost = f"{figures['samples_lost']} / {figures['samples_sent']}" if "samples_lost" in figures else ""
    after = f"{_number(figures['converged_after_s'])} s" if "converged_after_s" in figures else ""
    return [
        name,
        _percent(figures["stiffness_nrmse"]),
        _percent(figures["stiffness_coverage95"], 0),
        _percent(figures["damping_nrmse"]),
        _percent(figures["damping_coverage95"], 0) if "damping_coverage95" in figures else "",
        lost,
        after,
    ]


def _percent(fraction: float | None, digits: int = 2) -> str:
    return "-" if fraction is None else f"{100.0 * fraction:.{digits}f} %"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
