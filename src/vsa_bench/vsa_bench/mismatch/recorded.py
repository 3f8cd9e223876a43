# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Real recordings: the estimator's stiffness against a reference without a model, or against the truth of a file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from vsa_bench.mismatch.cases import DEFAULT_LAW
from vsa_bench.mismatch.metrics import SCORED_FROM, Estimates, quantity_figures
from vsa_bench.mismatch.reference import Reference, local_slopes
from vsa_bench.mismatch.run import estimate
from vsa_common.io.tables import TableError, read_columns
from vsa_common.types import Array
from vsa_estimator.cli.identify import start_values
from vsa_estimator.filter.records import Record
from vsa_estimator.offline import recordings as offline
from vsa_estimator.offline.identification import identify
from vsa_estimator.offline.recordings import RecordingError
from vsa_simulator.rig.recording import START_NS, Recording

COLUMNS, TRUTH = ("stamp", "force", "deflection"), "true_stiffness"
MIN_SAMPLES = 500  # shorter recordings are curves: too slow for a filter
STARTS = ("default", IDENTIFIED := "identify")
NO_ESTIMATOR = "local regression"  # in place of a start: the reference itself is compared
SUFFIXES = (".csv", ".csv.gz")


def recordings(folder: Path) -> list[Path]:
    """CSV files of a folder."""
    return sorted(path for path in folder.iterdir() if path.name.endswith(SUFFIXES))


def compare(path: Path, elastic_law: str = DEFAULT_LAW) -> Iterator[dict[str, Any]]:
    """Figures of one file against local regression and, where it has the truth, against that; none if too short.

    The estimator has its default configuration: with the default start values, and with those of `./vsa identify` on
    the same file. Raises TableError for an unreadable file, RecordingError for one without a fit.
    """
    columns = read_columns(path, COLUMNS, (TRUTH,))
    complete = np.isfinite(columns["stamp"] + columns["force"] + columns["deflection"])
    stamp, force, deflection = (columns[name][complete] for name in COLUMNS)
    if len(stamp) < MIN_SAMPLES:
        return
    time = stamp - stamp[0]
    stamp_ns = START_NS + np.round(time * 1e9).astype(np.int64)
    references = {"local regression": local_slopes(time, force, deflection)}
    if TRUTH in columns:
        truth = columns[TRUTH][complete]
        references["truth"] = Reference(np.arange(len(time)), truth, np.zeros(len(time)))
        yield from _accuracy(path, references["local regression"], truth, time)
    for start in STARTS:
        initial = {}
        if start == IDENTIFIED:
            fit = identify([offline.Recording(path, "transmission_1", stamp_ns, stamp, force, deflection)])
            initial = {f"initial.{name}": value for name, value in start_values(fit).items()}
        rows = estimate(Recording(stamp_ns, force, deflection), initial, elastic_law)
        for name, reference in references.items():
            yield _comparison(path, rows, reference, time) | {"reference": name, "start": start}


def _comparison(path: Path, rows: Record, reference: Reference, time: Array) -> dict[str, Any]:
    """The rows of the estimator at the instants of a reference."""
    index, std = reference.index, reference.std
    kept = (time[index] >= SCORED_FROM * time[-1]) & np.isfinite(rows["status"][index])
    chosen, true = rows[index[kept]], reference.stiffness[kept]
    variance = chosen["stiffness_variance"] + std[kept] ** 2
    estimates = Estimates(chosen["stiffness"], variance, chosen["stiffness_valid"] > 0)
    return _entry(path, estimates, true)


def _accuracy(path: Path, reference: Reference, truth: Array, time: Array) -> Iterator[dict[str, Any]]:
    """The reference itself against the truth of a simulated file."""
    kept = time[reference.index] >= SCORED_FROM * time[-1]
    if kept.any():
        value, std = reference.stiffness[kept], reference.std[kept]
        estimates = Estimates(value, std**2, np.ones(len(value), dtype=np.bool_))
        yield _entry(path, estimates, truth[reference.index[kept]]) | {"reference": "truth", "start": NO_ESTIMATOR}


def _entry(path: Path, estimates: Estimates, true: Array) -> dict[str, Any]:
    figures: dict[str, Any] = dict.fromkeys(("valid", "error", "coverage", "wrong", "half_width"))
    if len(true):
        figures = quantity_figures(estimates, true, true, logarithmic=True)
    return {"recording": path.name, "points": len(true), "stiffness": figures}


def compare_all(folder: Path, elastic_law: str = DEFAULT_LAW) -> tuple[list[dict[str, Any]], list[str]]:
    """Figures of all files of a folder, and one line for each that is not usable."""
    entries, skipped = [], []
    for path in recordings(folder):
        try:
            found = list(compare(path, elastic_law))
        except (TableError, RecordingError) as error:
            skipped.append(str(error))
            continue
        entries += found
        if not found:
            skipped.append(f"{path.name}: fewer than {MIN_SAMPLES} samples")
    return entries, skipped
