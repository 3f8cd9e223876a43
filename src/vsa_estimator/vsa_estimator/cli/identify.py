# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa identify`: start values with covariance from recordings, eqs. (18) and (19), as a parameter file."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from vsa_common.config.configuration import parameters
from vsa_common.figures import MEASURED, SIDE_1, TRUTH, limits, panels, save
from vsa_common.io.bags import BagError
from vsa_common.io.tables import TableError
from vsa_common.terminal import show_table
from vsa_estimator.offline.coefficient_file import NamedCoefficients, described, posterior_parameters, write_file
from vsa_estimator.offline.identification import NAMES, UNITS, Identification, identify
from vsa_estimator.offline.instants import Timing, corrected
from vsa_estimator.offline.recordings import Recording, RecordingError, read_recordings
from vsa_estimator.settings import EstimatorConfig

HEADER = ("coefficient", "value", "std", "variance", "unit", "95 % interval")


def start_values(result: Identification) -> dict[str, float]:
    """The estimator's parameters initial.X and initial.X_std, clipped to their ranges."""
    ranges = {parameter.name: parameter for parameter in parameters(EstimatorConfig)}
    values: dict[str, float] = {}
    for name in NAMES:
        if f"initial.{name}" not in ranges:
            continue
        for key, value in ((name, result.value(name)), (f"{name}_std", result.std(name))):
            parameter = ranges[f"initial.{key}"]
            values[key] = float(f"{min(max(value, parameter.low), parameter.high):.6g}")
    return values


def write_parameters(path: Path, results: Mapping[str, Identification]) -> None:
    """Write a ROS parameter file for the estimators of the identified transmissions."""
    sections: dict[str, object] = {}
    remarks = ["Start values by least squares, eqs. (18) and (19), SI."]
    for name, one in results.items():
        node = f"/**/{name.replace('transmission', 'estimator')}"
        initial: dict[str, object] = {**start_values(one)}
        if one.value("k1") > 0.0 and one.value("k2") > 0.0:
            coefficients = posterior(one)
            initial["posterior"] = posterior_parameters(coefficients)
            remarks += described(node, coefficients, f"{name}, {one.rows} rows")
        sections[node] = {"ros__parameters": {"initial": initial}}
    write_file(path, sections, remarks)


def posterior(result: Identification) -> NamedCoefficients:
    """Coefficients about the middle of the data, with ln_stiffness_reference = ln(k1 k2) + k2 x instead of k1."""
    k1, k2, middle = result.value("k1"), result.value("k2"), float(np.median(result.deflection))
    names = ("ln_stiffness_reference", *(name for name in NAMES if name != "k1"))
    jacobian = np.zeros((len(names), len(NAMES)))
    jacobian[0, NAMES.index("k1")], jacobian[0, NAMES.index("k2")] = 1.0 / k1, 1.0 / k2 + middle
    for row, name in enumerate(names[1:], 1):
        jacobian[row, NAMES.index(name)] = 1.0
    values = (float(np.log(k1 * k2) + k2 * middle), *(result.value(name) for name in names[1:]))
    return NamedCoefficients(names, values, jacobian @ result.covariance @ jacobian.T, middle)


def rows(result: Identification) -> list[list[str]]:
    """Rows of the printed table, one for each coefficient."""
    table = []
    for name, unit in zip(NAMES, UNITS, strict=True):
        value, std = result.value(name), result.std(name)
        low, high = value - 1.96 * std, value + 1.96 * std
        table.append([name, f"{value:.5g}", f"{std:.2g}", f"{std**2:.3g}", unit, f"{low:.4g} to {high:.4g}"])
    return table


def law(result: Identification) -> str:
    """The spring's law in the form of eq. (20), in N and mm."""
    f0, k1, k2 = (result.value(name) for name in ("force_offset", "k1", "k2"))
    return f"F_S = {f0:.4g} + {k1:.4g} exp({1e-3 * k2:.4g} x)    N, mm"


def plot(path: Path, results: Mapping[str, Identification]) -> None:
    """Plot force and residual over deflection and speed."""
    figure, axes = panels(len(results), 3, width=11.0, height=2.6 * len(results) + 0.5, title="Identification")
    for row, (name, one) in zip(np.atleast_2d(axes), results.items(), strict=True):
        x, v = 1e3 * one.deflection, 1e3 * one.velocity  # [mm, mm/s]
        along = np.linspace(one.deflection.min(), one.deflection.max(), 200)
        spring = one.value("force_offset") + one.value("k1") * np.exp(one.value("k2") * along)
        row[0].plot(x, one.force, ".", color=MEASURED, markersize=2, label="measured")
        row[0].plot(1e3 * along, spring, color=SIDE_1, label="spring, eq. (2)")
        row[0].set(ylabel=f"{name}\nforce [N]", xlabel="deflection [mm]")
        row[0].legend()
        for axis, abscissa, label in ((row[1], x, "deflection [mm]"), (row[2], v, "speed [mm/s]")):
            axis.plot(abscissa, one.residual, ".", color=SIDE_1, markersize=2)
            axis.axhline(0.0, color=TRUTH, linewidth=0.6)
            axis.set(xlabel=label, ylabel="residual [N]")
            limits(axis, one.residual)
    save(figure, path)


def main(argv: list[str] | None = None) -> int:
    """Run the command; exit code 0, or 1 with one line on stderr."""
    arguments = _parser().parse_args(argv)
    try:
        groups: dict[str, list[Recording]] = {}
        timings: dict[str, list[Timing]] = {}
        for path in arguments.input:
            for recording in read_recordings(path, arguments.transmission):
                even, timing = corrected(recording)
                groups.setdefault(even.transmission, []).append(even)
                timings.setdefault(even.transmission, []).append(timing)
        results = {name: identify(recordings) for name, recordings in groups.items()}
        write_parameters(arguments.out, results)
        plot(arguments.out.with_suffix(".png"), results)
    except (BagError, RecordingError, TableError, OSError) as error:
        print(f"identify: {error}", file=sys.stderr)
        return 1
    for name, one in results.items():
        show_table(f"{name}: {law(one)}", HEADER, rows(one), _note(one, timings[name]))
    print(f"wrote {arguments.out} and {arguments.out.with_suffix('.png')}")
    return 0


def _note(result: Identification, timings: Sequence[Timing]) -> str:
    note = f"{len(timings)} recording(s), {result.rows} rows, residual {result.residual.std():.3g} N rms"
    if result.repeated:
        note += f"; {result.repeated} repeated force samples left out: the force sensor is slower than the recording"
    if result.misfit > 2.0:
        note += f"; the model explains the data in part only: variances scaled by up to {result.misfit:.2g} times"
    return f"{note}; {'; '.join(dict.fromkeys(map(str, timings)))}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="identify", description="Start values for the estimator from recordings.")
    parser.add_argument("input", type=Path, nargs="+", help="CSV files (stamp,force,deflection in s, N, m) or bags")
    parser.add_argument(
        "--transmission",
        metavar="NAME",
        help="for bags: this transmission only; for CSV: its name (default: transmission_1)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("identified.yaml"),
        metavar="FILE.yaml",
        help="parameter file; the plot is written to the same folder",
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
