"""From what a demo left behind, bag and truth, to the content of summary.json and the table on the terminal."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from vsa_common.config.configuration import flatten, load
from vsa_common.io.tables import read_columns
from vsa_common.terminal import show_table
from vsa_estimator.settings import NodeConfig
from vsa_simulator.node import SimulatorConfig
from vsa_simulator.rig.config import TransmissionConfig
from vsa_tools.evaluation.recorded_run import Recorded
from vsa_tools.evaluation.summary import (
    UNKNOWN,
    Z95,
    Geometry,
    Integers,
    joint_summary,
    latency_summary,
    transmission_summary,
)
from vsa_tools.topics import TRANSMISSIONS

TRUTH = tuple(f"{name}_{side}" for side in (1, 2) for name in ("stiffness", "damping"))
PAPER_UNITS = {"k2": (1e-3, "1/mm"), "d2": (1e-9, "N s^3/mm^3"), "inertia": (1.0, "kg")}


def summarise(folder: Path, arrivals_ns: Sequence[tuple[int, int]]) -> dict[str, Any]:
    """The content of summary.json for the run whose bag, truth.csv and parameters.yaml are in `folder`.

    `arrivals_ns` are stamp and time of arrival of each joint message at a subscriber.
    Raises BagError, TableError or ConfigurationError where one of them cannot be read.
    """
    parameters = folder / "parameters.yaml"
    rig = load(parameters, "rig_simulator", SimulatorConfig)
    truth = read_columns(folder / "truth.csv", TRUTH)
    recorded = Recorded(folder / "bag")
    transmissions = {}
    for i, (side, true) in enumerate(zip(TRANSMISSIONS, (rig.transmission_1, rig.transmission_2), strict=True), 1):
        start = flatten(load(parameters, f"estimator_{i}", NodeConfig).initial)
        run = recorded.transmission(side, start, flatten(true))
        transmissions[side] = transmission_summary(run, truth, i, rig.rate_hz)
    return {
        "rate_hz": rig.rate_hz,
        "duration_s": len(truth["stiffness_1"]) / rig.rate_hz,
        "transmissions": transmissions,
        "joint": joint_summary(recorded.joint(), truth, geometry(rig)),
        "latency_ms": latency_summary(_latencies(recorded, arrivals_ns)),
    }


def _latencies(recorded: Recorded, arrivals_ns: Sequence[tuple[int, int]]) -> Integers:
    """From the capture of a frame to the arrival of the joint's message with its stamp [ns].

    A message with another stamp, or once more with the same, only says that the sensors are silent.
    """
    stamp_ns, arrival_ns = np.array(arrivals_ns, dtype=np.int64).reshape(-1, 2).T
    stamp_ns, first = np.unique(stamp_ns, return_index=True)
    arrival_ns = arrival_ns[first]
    of_frame = np.any([recorded.frames(side).samples(stamp_ns) != UNKNOWN for side in TRANSMISSIONS], axis=0)
    latency_ns: Integers = (arrival_ns - stamp_ns)[of_frame]
    return latency_ns


def geometry(rig: SimulatorConfig) -> Geometry:
    """How the simulated rig's transmissions reach its joint."""
    sides: tuple[TransmissionConfig, TransmissionConfig] = (rig.transmission_1, rig.transmission_2)
    return Geometry(rig.joint.radius, (sides[0].tendon_stiffness, sides[1].tendon_stiffness), rig.joint.damping)


def show(summary: Mapping[str, Any]) -> None:
    """Print the table of coefficients, in the paper's units, and what came of it."""
    rows = [
        row
        for side, figures in summary["transmissions"].items()
        for row in (_coefficient_row(side, name, figures[name]) for name in PAPER_UNITS)
    ]
    columns = ("", "coefficient", "start", "estimate (95 %)", "truth", "error")
    show_table("Coefficients at the end, as in Table I of the paper", columns, rows, texts=2)
    quality = [_quality_row(side, figures) for side, figures in summary["transmissions"].items()]
    quality.append(_quality_row("joint", summary["joint"]))
    heads = ("", "stiffness error", "covered", "damping error", "covered", "lost / sent", "converged after")
    latency = summary["latency_ms"]
    note = (
        "errors: rms of the last 30 % of the run over rms of the truth. From CAN frame to joint message at a "
        f"subscriber: median {_number(latency['p50'])} ms, 99 % within {_number(latency['p99'])} ms, "
        f"longest {_number(latency['max'])} ms"
    )
    show_table("Stiffness and damping against the truth", heads, quality, note)


def _coefficient_row(side: str, name: str, figures: Mapping[str, Any]) -> list[str]:
    scale, unit = PAPER_UNITS[name]
    start, estimate, std, truth = (figures[key] * scale for key in ("start", "estimate", "std", "truth"))
    known = figures.get("valid", True)
    error = f"{100.0 * (estimate / truth - 1.0):+.2f} %" if known else "not observable here"
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


def _percent(share: float | None, digits: int = 2) -> str:
    return "-" if share is None else f"{100.0 * share:.{digits}f} %"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
