# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Truth of the simulated rig on the time of the recording; the rolling counter assigns the samples."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from vsa_common.io.tables import TableError, read_columns
from vsa_common.stamps import NANOSECONDS
from vsa_tools.report.columns import Floats
from vsa_tools.report.data import Run, Transmission

QUANTITIES = ("deflection", "velocity", "acceleration", "force", "stiffness", "damping", "inertia")
MISFIT = 1e-3  # relative; truth of the paper's law has rounding errors only
NEGLIGIBLE = 1e-6  # relative; a smaller change is one by rounding errors: the file has 10 digits


@dataclass(frozen=True)
class Truth:
    """One transmission's truth at the samples of the recording."""

    time: Floats  # [s]
    columns: dict[str, Floats]
    coefficients: dict[str, float] = field(default_factory=dict)  # k2, d1, d2, inertia; SI


Truths = dict[tuple[str, str], Truth]  # by the names of joint and transmission


def read_truth(path: Path, run: Run) -> Truths:
    """Truth of each (joint, transmission) of `run` in the rig's CSV file. Raises TableError for an invalid file.

    The file may end within a line; rows with a value that is not finite are left out.
    """
    names = [f"{quantity}_{i}" for i in (1, 2) for quantity in QUANTITIES]
    table = read_columns(path, ["sample", *names], cut=True)
    complete = np.isfinite(list(table.values())).all(axis=0)
    if not complete.any():
        raise TableError(f"{path}: line 2: expected a row of finite numbers, found none in the whole file")
    table = {name: column[complete] for name, column in table.items()}
    found: Truths = {}
    for joint in run.joints:
        for side in joint.transmissions:
            number = side.name.rpartition("_")[2]
            if number in ("1", "2") and side.counters:
                found[joint.name, side.name] = _truth(table, number, side, run.start_ns)
    return found


def _truth(table: dict[str, Floats], number: str, side: Transmission, start_ns: int) -> Truth:
    by_counter = {counter: stamp for stamp, counter in side.counters.items()}
    stamps = np.array([by_counter.get(int(sample), 0) for sample in table["sample"]], dtype=np.int64)
    recorded = stamps > 0
    columns = {name: table[f"{name}_{number}"][recorded] for name in QUANTITIES}
    all_samples = {name: table[f"{name}_{number}"] for name in QUANTITIES}
    return Truth((stamps[recorded] - start_ns) / NANOSECONDS, columns, coefficients(all_samples))


def coefficients(columns: dict[str, Floats]) -> dict[str, float]:
    """k2, d1, d2 and inertia by regression: slope of ln(sigma) over x is k2, eq. (3); D = d1 + 3 d2 v^2, eq. (5).

    Coefficients that do not describe the truth within MISFIT, as those of other laws, are absent; so are slopes that
    change nothing over the data, as of a linear spring or damper.
    """
    found: dict[str, float] = {"inertia": float(np.median(columns["inertia"]))}
    x = columns["deflection"]
    if np.ptp(x) > 0.0:
        line = np.polyfit(x - x.mean(), np.log(columns["stiffness"]), 1)
        misfit = np.abs(np.polyval(line, x - x.mean()) - np.log(columns["stiffness"])).max()
        if misfit < MISFIT and abs(line[0]) * np.ptp(x) > NEGLIGIBLE:
            found["k2"] = float(line[0])
    square, damping = columns["velocity"] ** 2, columns["damping"]
    passive = damping > 0.01 * damping.max()  # beyond its peak speed the damper law is clipped
    if np.ptp(square[passive]) > 0.0:
        slope, d1 = np.polyfit(square[passive], damping[passive], 1)
        if np.abs(d1 + slope * square - damping)[passive].max() < MISFIT * damping.max():
            found["d1"] = float(d1)
            if abs(slope) * np.ptp(square[passive]) > NEGLIGIBLE * damping.max():
                found["d2"] = float(slope / 3.0)
    return found
