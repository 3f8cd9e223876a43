# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`calibrate`: scale and offset of a force sensor against a reference gauge's log, as driver parameters."""

import argparse
import re
import sys
from pathlib import Path

import numpy as np
from vsa_common.config.configuration import ConfigurationError, load
from vsa_common.io.bags import BagError, read, topics
from vsa_common.io.tables import TableError, read_columns
from vsa_common.stamps import nanoseconds
from vsa_common.terminal import show_table
from vsa_common.types import Array
from vsa_driver.calibration.fit import GaugeError, GaugeFit, fit, fit_logs
from vsa_driver.settings import DriverSettings, TransmissionSettings


def main(args: list[str] | None = None) -> int:
    """Calibrate one sensor. Returns 0, or 1 with one line on stderr where the logs do not determine it."""
    options = _parser().parse_args(args)
    try:
        settings = load(options.config, "driver", DriverSettings) if options.config else DriverSettings()
        result = calibrate(options.input, options.reference, options.transmission, options.max_lag)
        text = parameter_file(options.transmission, settings.transmission(options.transmission), result)
        if options.out:
            options.out.write_text(text)
    except (GaugeError, TableError, BagError, ConfigurationError, OSError) as error:
        print(f"calibrate: {error}", file=sys.stderr)
        return 1
    show(options.transmission, result)
    print(f"wrote {options.out}; merge it into the rig's parameters" if options.out else text)
    return 0


def calibrate(source: Path, reference: Path | None, transmission: str, max_lag: float) -> GaugeFit:
    """Fit a recording to its own `reference` column or to the gauge's log. Raises GaugeError naming the file."""
    try:
        if reference is None:
            if source.suffix.lower() != ".csv":
                raise GaugeError("a bag holds no reference, expected --reference CSV")
            columns = read_columns(source, ["stamp", "force", "reference"])
            return fit(columns["force"], columns["reference"])
        stamp, force = read_force(source, transmission)
        gauge = read_columns(reference, ["stamp", "force"])
        return fit_logs(stamp, force, gauge["stamp"], gauge["force"], max_lag)
    except GaugeError as error:
        raise GaugeError(f"{source}{f' and {reference}' if reference else ''}: {error}") from error


def read_force(source: Path, transmission: str) -> tuple[Array, Array]:
    """Stamps [s] and forces [N] of a CSV file `stamp,force`, or of a transmission in a bag."""
    if source.suffix.lower() == ".csv":
        columns = read_columns(source, ["stamp", "force"])
        return columns["stamp"], columns["force"]
    matching = [name for name in topics(source) if re.fullmatch(rf"(.*/)?{transmission}/force", name)]
    if len(matching) != 1:
        raise GaugeError(f"expected one topic {transmission}/force, found {', '.join(matching) or 'none'}")
    samples = [
        (nanoseconds(message.header.stamp) * 1e-9, message.wrench.force.x) for _, _, message in read(source, matching)
    ]
    stamp, force = np.array(samples).reshape(-1, 2).T
    return stamp, force


def parameter_file(transmission: str, before: TransmissionSettings, result: GaugeFit) -> str:
    """Driver parameters (YAML) for a recording that was made with those of `before`."""
    scale, offset = result.scale * before.force_scale, result.scale * before.force_offset + result.offset
    scale_std = result.scale_std * before.force_scale
    covariance = 2.0 * before.force_offset * result.scale_offset_covariance
    offset_std = np.sqrt((before.force_offset * result.scale_std) ** 2 + covariance + result.offset_std**2)
    is_reversed = before.force_reversed != (scale < 0.0)
    return "\n".join(
        [
            f"# {result.samples} samples, {result.force_min:.4g} to {result.force_max:.4g} N by the gauge,"
            f" residual {result.residual_std:.3g} N",
            "/**/driver:",
            "  ros__parameters:",
            f"    {transmission}:",
            f"      force_scale: {abs(scale)!r}    # [N per unit] +- {scale_std:.2g}",
            f"      force_offset: {offset!r}    # [N] +- {offset_std:.2g}",
            f"      force_reversed: {str(is_reversed).lower()}",
            "",
        ]
    )


def show(transmission: str, result: GaugeFit) -> None:
    """Print the result as a table with standard deviations."""
    rows = [
        ["scale", f"{result.scale:.6f}", f"{result.scale_std:.6f}", "1"],
        ["offset", f"{result.offset:+.5f}", f"{result.offset_std:.5f}", "N"],
        ["residual, rms", f"{result.residual_std:.5f}", "", "N"],
        ["residual, largest", f"{result.residual_max:.5f}", "", "N"],
        ["gauge's clock ahead", f"{result.lag:+.4f}", "", "s"],
    ]
    note = f"{result.samples} samples, {result.force_min:.4g} to {result.force_max:.4g} N; true = scale * read + offset"
    show_table(f"Force sensor of {transmission}", ["", "value", "std", "unit"], rows, note=note)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="calibrate", description=__doc__)
    parser.add_argument("input", type=Path, help="CSV stamp,force (and reference, without --reference), or a bag")
    parser.add_argument("--reference", type=Path, metavar="CSV", help="the gauge's log: stamp,force in s and N")
    parser.add_argument("--transmission", default="transmission_1", choices=["transmission_1", "transmission_2"])
    parser.add_argument(
        "--config", type=Path, metavar="YAML", help="driver parameters that the recording was made with"
    )
    parser.add_argument("--max-lag", type=float, default=1.0, metavar="S", help="how far the clocks may be apart (1.0)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the parameters here instead of to the terminal")
    return parser


if __name__ == "__main__":
    sys.exit(main())
