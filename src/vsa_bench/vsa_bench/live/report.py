# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Table and figure of the runs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from vsa_bench.harness.deployment import COMPOSED, SEPARATE, STANDARD_EXECUTOR
from vsa_common.figures import JOINT, MEASURED, SIDE_1, WARNING, panels, save

HEADER = (
    "mode", "joints", "rate [Hz]", "sent", "lost", "p50 [ms]", "p99", "p99.9", "max", "machine", "stolen", "CPU [%]",
    "of which", "RSS [MB]", "",
)  # fmt: skip
NOTE = (
    "Delay from the capture stamp of a sample's later CAN frame to its joint message in another process. machine: p99 "
    "of the wake-up latency of an idle process of the highest priority meanwhile; stolen: steal time of a virtual "
    "machine, in percent of one core. CPU of one core, suite alone. RSS: growth after the first fifth. Simulated rig, "
    "bus and subscriber run on the same machine. In composed, each joint has a core to itself where there are enough, "
    "and polls for frames (realtime.cores and busy; not with --asleep). Else a thread that takes a quarter of a core "
    "pauses between frames (realtime.rest)."
)
SHORT = {"estimator_1": "est 1", "estimator_2": "est 2"}
OUTSIDE = ("rig_simulator", "subscriber")
COLOURS = {SEPARATE: SIDE_1, COMPOSED: JOINT, STANDARD_EXECUTOR: MEASURED}


def row(run: dict[str, Any]) -> list[str]:
    """One line of the table."""
    cpu = {name: percent for name, percent in run["cpu_percent"].items() if not name.endswith(OUTSIDE)}
    shown = [*run["latency_ms"].values(), run["machine_late_ms"]["p99"]]
    delays = [f"{value:.2f}" if value is not None else "-" for value in shown]
    parts = ", ".join(f"{SHORT.get(name, name)} {percent:.0f}" for name, percent in cpu.items())
    return [
        run["mode"],
        str(run["joints"]),
        str(run["rate_hz"]),
        str(run["samples_sent"]),
        str(run["samples_lost"]),
        *delays,
        f"{run['stolen_percent']:.0f}",
        f"{sum(cpu.values()):.0f}",
        parts if len(cpu) <= 4 else f"{len(cpu)} processes",
        f"{run['rss_growth_mb']:+.1f}",
        "" if run["sustained"] else "not sustained",
    ]


def plot(runs: Sequence[dict[str, Any]], path: Path) -> None:
    """Delay and processor time over the rate; runs that are not sustained are crossed."""
    figure, (left, right) = panels(1, 2, height=3.6, title="Delay and cost from CAN frame to joint impedance")
    for mode, colour in COLOURS.items():
        for joints, line in ((1, "-"), (2, "--")):
            chosen = sorted(
                (run for run in runs if (run["mode"], run["joints"]) == (mode, joints)), key=lambda run: run["rate_hz"]
            )
            if not chosen:
                continue
            rates = [run["rate_hz"] for run in chosen]
            label = f"{mode.replace('_', ' ')}, {joints} joint{'s' * (joints > 1)}"
            left.plot(rates, [_delay(run, "p99") for run in chosen], "o" + line, color=colour, label=label)
            left.plot(rates, [_delay(run, "p50") for run in chosen], "." + line, color=colour, alpha=0.5)
            right.plot(rates, [_cpu(run) for run in chosen], "o" + line, color=colour)
            lost = [run for run in chosen if not run["sustained"]]
            crossed = [run["rate_hz"] for run in lost]
            left.plot(crossed, [_delay(run, "p99") for run in lost], "x", color=WARNING, markersize=9)
    left.set(xscale="log", yscale="log", xlabel="samples a second", ylabel="delay [ms]: p99, and p50 pale")
    right.set(xscale="log", xlabel="samples a second", ylabel="processor time of the suite [% of a core]")
    figure.legend(loc="outside lower center", ncols=3)
    save(figure, path)


def _delay(run: dict[str, Any], quantile: str) -> float:
    value = run["latency_ms"][quantile]
    return float("nan") if value is None else value


def _cpu(run: dict[str, Any]) -> float:
    return sum(percent for name, percent in run["cpu_percent"].items() if not name.endswith(OUTSIDE))
