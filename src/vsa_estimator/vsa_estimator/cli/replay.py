# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa replay`: run a recording through the estimator of the node."""

import argparse
import gc
import json
import sys
import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.config.configuration import ConfigurationError, build, node_values
from vsa_common.fork import ForkedTasks, ReportProgress
from vsa_common.io.bags import BagError
from vsa_common.io.tables import TableError, write_columns
from vsa_common.terminal import progress
from vsa_estimator.formulations import create_estimator
from vsa_estimator.offline.recordings import Recording, RecordingError, read_recordings, transmissions
from vsa_estimator.output.estimate import State
from vsa_estimator.settings import EstimatorConfig, NodeConfig

CHUNK = 2000  # samples between two reports of progress

# Column of the output: field of Estimate; a column `_std` is the square root of a variance.
FIELDS = {
    "deflection": "deflection", "velocity": "velocity", "acceleration": "acceleration",
    "stiffness": "stiffness", "stiffness_std": "stiffness_variance",
    "damping": "damping", "damping_std": "damping_variance",
    "inertia": "inertia", "inertia_std": "inertia_variance",
    "k2": "k2", "k2_std": "k2_variance", "d2": "d2", "d2_std": "d2_variance",
    "force_offset": "force_offset", "coulomb_friction": "coulomb_friction",
    "status": "status",
    "stiffness_valid": "stiffness_valid", "damping_valid": "damping_valid", "inertia_valid": "inertia_valid",
}  # fmt: skip
INTEGER_COLUMNS = ("status", "stiffness_valid", "damping_valid", "inertia_valid")


def replay(
    recording: Recording, config: EstimatorConfig, report_progress: ReportProgress
) -> tuple[dict[str, NDArray[Any]], State]:
    """Output columns with one row for each sample used, and the final state.

    `report_progress` is called with the share of the recording done since its last call.
    """
    estimator = create_estimator(config)
    chunks = []
    for part in _parts(recording):
        if recording.lost is not None:
            estimator.count_lost(int(recording.lost[part.start]))
        chunks.append(estimator.add_many(recording.stamp_ns[part], recording.force[part], recording.deflection[part]))
        report_progress(len(chunks[-1]) / len(recording))
    rows = np.concatenate(chunks)
    used = ~np.isnan(rows["status"])
    columns: dict[str, NDArray[Any]] = {"stamp": recording.stamp[used]}
    for name, field in FIELDS.items():
        values = rows[field][used]
        columns[name] = (
            np.sqrt(values) if name.endswith("_std") else values.astype(int) if name in INTEGER_COLUMNS else values
        )
    return columns, estimator.state()


def _parts(recording: Recording) -> list[slice]:
    """Parts of a recording of at most CHUNK samples, which begin after lost samples."""
    starts = set(range(0, len(recording), CHUNK))
    if recording.lost is not None:
        starts |= set(np.flatnonzero(recording.lost).tolist())
    return [slice(*pair) for pair in pairwise([*sorted(starts), len(recording)])]


def configuration(transmission: str, given: Path | None) -> EstimatorConfig:
    """Parameters of the transmission's estimator in the file `given`, without one in paper_rig.yaml where installed.

    A parameter that is not in the file has its default, as in the node. Raises ConfigurationError.
    """
    node = transmission.replace("transmission", "estimator")
    values: dict[str, Any] = {}
    for path in [given] if given else _installed_configuration():
        values |= node_values(path, node, NodeConfig)
    try:
        return build(NodeConfig, values)
    except ConfigurationError as error:
        raise ConfigurationError(f"{given or 'paper_rig.yaml'}: {node}: {error}") from error


def summarise(recording: Recording, columns: dict[str, NDArray[Any]], state: State, seconds: float) -> dict[str, Any]:
    """Counts of samples and final coefficients, for summary.json."""
    rows = len(columns["stamp"])
    coefficients = ("k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
    return {
        "input": str(recording.source),
        "complete": recording.complete,
        "rows_read": len(recording),
        "rows_used": rows,
        "rows_dropped": len(recording) - rows,
        "messages_unpaired": recording.unpaired,
        "force_repeated": state.force_repeated,
        "force_rejected": state.force_rejected,
        "deflection_rejected": state.deflection_rejected,
        "resets": state.reset_count,
        "status": state.status.name,
        "reason": state.reason,
        "observability": list(state.observability),
        "coefficients": {
            name: {
                "value": getattr(state, name),
                "std": getattr(state, f"{name}_variance") ** 0.5,
                "valid": bool(getattr(state, f"{name}_valid")),
            }
            for name in coefficients
        },
        "stiffness_valid_share": float(columns["stiffness_valid"].mean()) if rows else 0.0,
        "recorded_s": recording.duration,
        "replayed_in_s": seconds,
    }


def main(argv: list[str] | None = None) -> int:
    """Run the command; exit code 0 if the whole recording was processed, else 1 with one line on stderr."""
    arguments = _parser().parse_args(argv)
    gc.freeze()  # the collector skips the modules: a tenth of the time of a minute of 1 kHz
    try:
        return _run(arguments)
    except (BagError, ConfigurationError, RecordingError, TableError, OSError) as error:
        print(f"replay: {error}", file=sys.stderr)
        return 1


def _run(arguments: argparse.Namespace) -> int:
    names = transmissions(arguments.input, arguments.transmission, arguments.namespace)
    tasks = [
        partial(_replay, partial(read_recordings, arguments.input, name, arguments.namespace), configured)
        for name, configured in ((name, configuration(name, arguments.config)) for name in names)
    ]
    arguments.out.mkdir(parents=True, exist_ok=True)
    with progress(len(tasks), "replay") as bar:
        results = ForkedTasks(*tasks).results(bar.advance) if len(tasks) > 1 else [task(bar.advance) for task in tasks]
    for name, (columns, _) in zip(names, results, strict=True):
        write_columns(arguments.out / f"{name}.csv", columns)
    summary = {name: one for name, (_, one) in zip(names, results, strict=True)}
    (arguments.out / "summary.json").write_text(json.dumps(summary, indent=1) + "\n")
    for name, one in summary.items():
        k2 = one["coefficients"]["k2"]
        reason = f"; {one['reason']}" if one["reason"] else ""
        print(
            f"{name}: {one['rows_used']} of {one['rows_read']} samples in {one['replayed_in_s']:.1f} s, "
            f"{one['status']}, k2 {k2['value']:.5g} +- {k2['std']:.2g} 1/m{reason}"
        )
    if not all(one["complete"] for one in summary.values()):
        print(f"replay: {arguments.input}: the bag was cut off; what it holds was replayed", file=sys.stderr)
        return 1
    return 0


def _replay(
    read: Callable[[], list[Recording]], config: EstimatorConfig, report_progress: ReportProgress
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Output columns and summary of one transmission, which `read` returns."""
    (recording,) = read()
    start = time.perf_counter()
    columns, state = replay(recording, config, report_progress)
    summary = summarise(recording, columns, state, time.perf_counter() - start)
    return columns, summary | {"formulation": config.formulation}


def _installed_configuration() -> list[Path]:
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        path = Path(get_package_share_directory("vsa_bringup"), "config", "paper_rig.yaml")
    except (PackageNotFoundError, LookupError, OSError):
        return []
    return [path] if path.exists() else []


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="replay", description="Run a recording through the estimator of the node.")
    parser.add_argument(
        "input", type=Path, help="CSV (stamp,force,deflection in s, N, m) or bag: folder, .mcap or .db3"
    )
    parser.add_argument(
        "--transmission",
        metavar="NAME",
        help="for a bag: this transmission only; for a CSV: its name (default: transmission_1)",
    )
    parser.add_argument(
        "--namespace", metavar="NAME", help="for a bag of several joints: the joint's namespace (/vsa in this suite)"
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="YAML",
        help="ROS parameter file; parameters not in it keep their defaults (without it: paper_rig.yaml)",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("vsa_replay"), metavar="DIR", help="folder for NAME.csv and summary.json"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
