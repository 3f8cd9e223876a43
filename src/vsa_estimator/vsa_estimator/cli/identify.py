# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa identify`: start values from recordings, eqs. (18) and (19), or of a law of any form, as a parameter file."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from vsa_common.config.configuration import parameters
from vsa_common.io.bags import BagError
from vsa_common.io.tables import TableError
from vsa_common.terminal import show_table
from vsa_estimator.cli.identify_output import (
    COEFFICIENTS,
    KNOT_STEP,
    LAW,
    coefficient_rows,
    comparison,
    law_rows,
    law_text,
    plot,
)
from vsa_estimator.offline.coefficient_file import NamedCoefficients, described, posterior_parameters, write_file
from vsa_estimator.offline.identification import NAMES, Identification, identify
from vsa_estimator.offline.instants import Timing, corrected
from vsa_estimator.offline.recordings import Recording, RecordingError, read_recordings
from vsa_estimator.settings import EstimatorConfig, Initial

LAWS = (AUTOMATIC := "automatic", EXPONENTIAL := "exponential")
STEEPEST = 4.0  # k2 times stroke, up to which the spline of the bank of laws covers the stroke from any start
STEEP_SHARE = 0.9  # quantile of the slopes of ln stiffness that k2 is


def start_values(result: Identification) -> dict[str, float]:
    """The estimator's parameters initial.X and initial.X_std, clipped to their ranges.

    Of a law of any form they are the orders of magnitude that the prior of the bank of laws is made of.
    """
    ranges = {parameter.name: parameter for parameter in parameters(EstimatorConfig)}
    found = _coefficients(result) if result.is_exponential else _orders_of_magnitude(result)
    values: dict[str, float] = {}
    for name, pair in found.items():
        for key, value in zip((name, f"{name}_std"), pair, strict=True):
            parameter = ranges[f"initial.{key}"]
            values[key] = float(f"{min(max(value, parameter.low), parameter.high):.6g}")
    return values


def _coefficients(result: Identification) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of each coefficient that has a start value."""
    names = [name for name in result.names if hasattr(Initial, name)]
    return {name: (result.value(name), result.std(name)) for name in names}


def _orders_of_magnitude(result: Identification) -> dict[str, tuple[float, float]]:
    """The exponential law that touches the law of any form in its middle, and damper, friction and mass.

    k2 is a steep slope of ln stiffness: it sets the distance of the bank's knots. A coefficient of the wrong sign has
    the default. Standard deviations are as large in proportion as the defaults, or those of the regression.
    """
    law, default = result.law, Initial()
    x, middle = law.deflection, np.array([np.median(result.deflection)])
    slopes = np.abs(np.diff(law.ln_stiffness) / np.diff(x))
    stroke = float(np.ptp(x))
    k2 = float(np.clip(np.quantile(slopes, STEEP_SHARE), 1.0 / stroke, STEEPEST / stroke))
    force_offset = float(law.force(middle)[0] - law.stiffness(middle)[0] / k2)
    found = {"k2": (k2, _share("k2") * k2), "force_offset": (force_offset, default.force_offset_std)}
    for name, (value, std) in _coefficients(result).items():
        usual = getattr(default, name)
        value = value if value * usual > 0.0 else usual
        found[name] = value, max(_share(name) * abs(value), std)
    return found


def _share(name: str) -> float:
    """Standard deviation of a default start value over its magnitude."""
    default = Initial()
    return abs(getattr(default, f"{name}_std") / getattr(default, name))


def write_parameters(path: Path, results: Mapping[str, Identification]) -> None:
    """Write a ROS parameter file for the estimators of the identified transmissions."""
    sections: dict[str, object] = {}
    remarks = ["Start values by least squares, eqs. (18) and (19), SI."]
    for name, one in results.items():
        node = f"/**/{name.replace('transmission', 'estimator')}"
        initial: dict[str, object] = {**start_values(one)}
        values: dict[str, Any] = {"initial": initial, "elastic_law": EXPONENTIAL if one.is_exponential else AUTOMATIC}
        if not one.is_exponential:
            remarks += _law_remarks(node, one, f"{name}, {one.rows} rows; {comparison(one)}")
        elif one.value("k1") > 0.0 and one.value("k2") > 0.0:
            coefficients = posterior(one)
            initial["posterior"] = posterior_parameters(coefficients)
            remarks += described(node, coefficients, f"{name}, {one.rows} rows")
        sections[node] = {"ros__parameters": values}
    write_file(path, sections, remarks)


def _law_remarks(node: str, result: Identification, remark: str) -> list[str]:
    """Lines for a reader: remark, and the stiffness at knots with standard deviation."""
    x = result.law.deflection[::KNOT_STEP]
    points = zip(x, result.law.stiffness(x), result.law.ln_std(x), strict=True)
    return [
        f"{node}: {remark}",
        *(f"{node}: stiffness at {at:.6f} m = {value:.5g} +- {value * std:.2g} N/m" for at, value, std in points),
    ]


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


def main(argv: list[str] | None = None) -> int:
    """Run the command; exit code 0 if all recordings were used to their end, else 1 with one line on stderr."""
    arguments = _parser().parse_args(argv)
    try:
        groups: dict[str, list[Recording]] = {}
        timings: dict[str, list[Timing]] = {}
        for path in arguments.input:
            for recording in read_recordings(path, arguments.transmission, arguments.namespace):
                even, timing = corrected(recording)
                groups.setdefault(even.transmission, []).append(even)
                timings.setdefault(even.transmission, []).append(timing)
        any_law = arguments.elastic_law == AUTOMATIC
        results = {name: identify(recordings, any_law) for name, recordings in groups.items()}
        write_parameters(arguments.out, results)
        plot(arguments.out.with_suffix(".png"), results)
    except (BagError, RecordingError, TableError, OSError) as error:
        print(f"identify: {error}", file=sys.stderr)
        return 1
    for name, one in results.items():
        if not one.is_exponential:
            show_table(f"{name}: {law_text(one)}", LAW, law_rows(one), "")
        title = f"{name}: {law_text(one)}" if one.is_exponential else f"{name}: damper, friction and mass"
        show_table(title, COEFFICIENTS, coefficient_rows(one), _note(one, timings[name]))
    print(f"wrote {arguments.out} and {arguments.out.with_suffix('.png')}")
    cut = dict.fromkeys(str(one.source) for group in groups.values() for one in group if not one.complete)
    if cut:
        print(f"identify: {', '.join(cut)}: the bag was cut off; what it holds was used", file=sys.stderr)
    return 1 if cut else 0


def _note(result: Identification, timings: Sequence[Timing]) -> str:
    note = f"{len(timings)} recording(s), {result.rows} rows, residual {result.residual.std():.3g} N rms"
    if result.repeated:
        note += f"; {result.repeated} repeated force samples left out: the force sensor is slower than the recording"
    if result.misfit > 2.0:
        note += f"; the model explains the data in part only: variances scaled by up to {result.misfit:.2g} times"
    compared = comparison(result)
    return "; ".join([note, *([compared] if compared else []), *dict.fromkeys(map(str, timings))])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="identify", description="Start values for the estimator from recordings.")
    parser.add_argument("input", type=Path, nargs="+", help="CSV files (stamp,force,deflection in s, N, m) or bags")
    parser.add_argument(
        "--transmission",
        metavar="NAME",
        help="for bags: this transmission only; for CSV: its name (default: transmission_1)",
    )
    parser.add_argument(
        "--namespace", metavar="NAME", help="for a bag of several joints: the joint's namespace (/vsa in this suite)"
    )
    parser.add_argument(
        "--elastic-law",
        choices=LAWS,
        default=LAWS[0],
        help="automatic: eq. (2) unless a law of any form refutes it; exponential: eq. (2) (default: %(default)s)",
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
