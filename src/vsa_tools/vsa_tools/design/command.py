# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`design`: spring constants and cam profile from a specification, section II-B of the paper."""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from vsa_common.config.configuration import ConfigurationError, build, parameters
from vsa_common.figures import save
from vsa_tools.design.cam import Cam, Follower, cam_for, least_preload, rolled_force
from vsa_tools.design.plot import draw_design
from vsa_tools.design.spring import ExponentialSpring, Specification, spring_from


@dataclass(frozen=True)
class Design(Follower, Specification):
    """Parameters of a spring and of its follower."""


def main(args: list[str] | None = None) -> int:
    """Design one spring; 0 if its cam can be cut, else 1 with one line on stderr."""
    options = _parser().parse_args(args)
    try:
        wanted = build(Design, read_specification(options.spec) | _given(options))
        spring = spring_from(wanted)
        cam = cam_for(spring, wanted, wanted.max_deflection)
        check_cuttable(spring, wanted, cam)
        write(options.out, wanted, spring, cam)
    except (ConfigurationError, OSError) as error:
        print(f"design: {error}", file=sys.stderr)
        return 1
    print(describe(wanted, spring, cam))
    print(f"wrote {options.out}/design.csv, {options.out}/cam_mm.csv (for milling), {options.out}/design.png and .svg")
    return 0


def read_specification(path: Path | None) -> dict[str, object]:
    """Values of a YAML file `name: value`. Raises ConfigurationError, with the path, for an invalid file."""
    if path is None:
        return {}
    try:
        tree = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ConfigurationError(f"{path}: {' '.join(str(error).split())}") from error
    if not isinstance(tree, dict):
        raise ConfigurationError(f"{path}: expected lines 'max_force: 200.0', as `design --help` names them")
    try:
        build(Design, tree)
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from error
    return tree


def check_cuttable(spring: ExponentialSpring, follower: Follower, cam: Cam) -> None:
    """Raise ConfigurationError, with the remedy, where friction locks the follower or the roller undercuts its cam."""
    if not cam.slope.min() > 0.0:
        at = 1e3 * cam.deflection[cam.slope.argmin()]
        raise ConfigurationError(
            f"friction = {follower.friction:g} 1: at {at:.2f} mm the law requires a falling cam; "
            "use less friction or less preload"
        )
    if not cam.largest_roller > follower.roller_radius:
        enough = least_preload(spring, follower, float(cam.deflection[-1]))
        instead = "" if np.isnan(enough) else f" or a preload of at least {enough:.3g} m"
        raise ConfigurationError(
            f"undercut: roller_radius = {follower.roller_radius:g} m does not reach the cam at "
            f"{1e3 * cam.tightest:.2f} mm of deflection, where the roller's path bends with a radius of "
            f"{1e3 * cam.largest_roller:.2f} mm; use a roller below {cam.largest_roller:.2g} m{instead}"
        )


def check_force(spring: ExponentialSpring, follower: Follower, cam: Cam) -> float:
    """Largest relative error [1] along the stroke of the force computed from the cut surface."""
    deflection = np.linspace(0.0, cam.deflection[-1], 201)
    wanted = spring.force(deflection)
    return float(np.max(np.abs(rolled_force(cam.cut_x, cam.cut_y, follower, deflection) / wanted - 1.0)))


def describe(wanted: Design, spring: ExponentialSpring, cam: Cam) -> str:
    """Summary of the design, in the paper's N and mm and in SI."""
    rest, stroke = wanted.rest_length, wanted.max_deflection
    sign = "+" if spring.force_offset >= 0.0 else "-"
    softest, stiffest = 1e-3 * spring.stiffness(np.array([0.0, stroke]))
    angle = np.degrees(np.arctan(cam.slope))
    roller = (
        f"rollers below {1e3 * cam.largest_roller:.3g} mm fit" if cam.largest_roller < np.inf else "any roller fits"
    )
    lines = [
        f"F_S = {spring.k1:.4f} exp({1e-3 * spring.k2:.4f} x) {sign} {abs(spring.force_offset):.4f}    N, mm; eq. (2)",
        f"k1 {spring.k1:.5g} N, k2 {spring.k2:.5g} 1/m, F0 {spring.force_offset:.5g} N, "
        f"alpha = k2 L0 = {spring.k2 * rest:.5g}",
        f"force {spring.force(0.0):.4g} N at rest, {spring.force(rest):.4g} N at {1e3 * rest:g} mm, "
        f"{spring.force(stroke):.4g} N at {1e3 * stroke:g} mm",
        f"stiffness {softest:.4g} to {stiffest:.4g} N/mm",
        f"cam: {wanted.springs} x {1e-3 * wanted.spring_rate:g} N/mm, preload {1e3 * wanted.preload:g} mm, "
        f"roller radius {1e3 * wanted.roller_radius:g} mm; lift {1e3 * cam.lift[-1]:.2f} mm, "
        f"contact angle {angle.min():.1f} to {angle.max():.1f} deg; {roller}",
        f"force computed from the cut surface: within {1e2 * check_force(spring, wanted, cam):.3f} % of the law",
    ]
    if wanted.friction:
        lost = 1e2 * (1.0 - cam.unloading_force / spring.force(cam.deflection))
        stuck = "; the rod does not return by itself there" if cam.unloading_force.min() <= 0.0 else ""
        lines.append(f"friction reduces the force by {lost.min():.1f} to {lost.max():.1f} % while unloading{stuck}")
    return "\n".join(lines)


def write(folder: Path, wanted: Design, spring: ExponentialSpring, cam: Cam) -> None:
    """Write design.csv (SI), cam_mm.csv (cut surface for milling) and the figure into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    columns = {
        "deflection": cam.deflection,
        "force": spring.force(cam.deflection),
        "unloading_force": cam.unloading_force,
        "stiffness": spring.stiffness(cam.deflection),
        "spring_compression": cam.compression,
        "contact_angle": np.arctan(cam.slope),
        "centre_x": cam.deflection,
        "centre_y": cam.lift,
        "cut_x": cam.cut_x,
        "cut_y": cam.cut_y,
    }
    _write_csv(folder / "design.csv", columns, "%.9g")
    _write_csv(folder / "cam_mm.csv", {"x": 1e3 * cam.cut_x, "y": 1e3 * cam.cut_y}, "%.6f")
    figure = draw_design(wanted, spring, wanted, cam)
    save(figure, folder / "design.png")
    save(figure, folder / "design.svg")


def _write_csv(path: Path, columns: dict[str, np.ndarray], number: str) -> None:
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt=number, delimiter=",", header=",".join(columns), comments="")


def _given(options: argparse.Namespace) -> dict[str, object]:
    """Parameters given on the command line."""
    values = {parameter.name: getattr(options, parameter.name) for parameter in parameters(Design)}
    return {name: value for name, value in values.items() if value is not None}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="design", description=__doc__, allow_abbrev=False)
    text = "YAML file with the names below, 'max_force: 200.0'"
    parser.add_argument("spec", nargs="?", type=Path, metavar="SPEC", help=text)
    text = "folder for CSV and pictures (default: design)"
    parser.add_argument("--out", type=Path, default=Path("design"), metavar="DIR", help=text)
    for one in parameters(Design):
        option, text = "--" + one.name.replace("_", "-"), f"{one.text} [{one.unit}] (default: {one.default:g})"
        parser.add_argument(option, dest=one.name, type=one.kind, metavar="NUMBER", help=text)
    return parser


if __name__ == "__main__":
    sys.exit(main())
