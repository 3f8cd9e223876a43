# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa noise`: noise of force, force rate and position from a recording at rest or on a slow ramp (section VI)."""

import argparse
import sys
from pathlib import Path

import numpy as np
import yaml
from vsa_common.config.configuration import Parameter, parameters
from vsa_common.figures import MEASURED, SIDE_1, panels, save
from vsa_common.io.bags import BagError
from vsa_common.io.tables import TableError
from vsa_common.terminal import show_table
from vsa_estimator.offline.allan import Allan
from vsa_estimator.offline.noise import analyse
from vsa_estimator.offline.recordings import RecordingError, read_recordings
from vsa_estimator.settings import EstimatorConfig

UNITS = {"force": "N", "force_rate": "N/s", "deflection": "m"}
HEADER = ("signal", "std", "variance", "unit", "std of 1 s mean", "slope", "noise")


def write_parameters(path: Path, noise: dict[str, dict[str, Allan]]) -> None:
    """Write a ROS parameter file with the noise of each transmission's estimator, clipped to its declared range."""
    tree = {}
    for name, signals in noise.items():
        values = {
            one.name: float(f"{min(max(signals[signal].std, one.low), one.high):.6g}")
            for signal, one in _declared().items()
        }
        tree[f"/**/{name.replace('transmission', 'estimator')}"] = {"ros__parameters": values}
    notes = [
        f"# {name}: {signal} {one.std:.4g} {UNITS[signal]}, {one.classification} (slope {one.slope:.2f})\n"
        for name, signals in noise.items()
        for signal, one in signals.items()
    ]
    notes += [f"# {name}: {line}\n" for name, signals in noise.items() for line in constant_signals(signals)]
    path.write_text("".join(notes) + yaml.safe_dump(tree, sort_keys=False))


def constant_signals(signals: dict[str, Allan]) -> list[str]:
    """A line for each signal without a change above rounding errors, of which the noise is unknown."""
    constant = [(signal, one.low) for signal, one in _declared().items() if signals[signal].std < one.low]
    return [
        f"the {name} did not change: the least permitted {low:g} {UNITS[name]} is written" for name, low in constant
    ]


def _declared() -> dict[str, Parameter]:
    """The estimator's parameters of the noise, by signal."""
    ranges = {parameter.name: parameter for parameter in parameters(EstimatorConfig)}
    return {signal: ranges[f"{signal}_noise_std"] for signal in ("force", "deflection")}


def plot(path: Path, noise: dict[str, dict[str, Allan]]) -> None:
    """Plot the Allan variance over averaging time and the slope of white noise, as in Fig. 6."""
    figure, axes = panels(len(noise), 3, width=10.0, height=2.7 * len(noise) + 0.4, title="Allan variance")
    for row, (name, signals) in zip(np.atleast_2d(axes), noise.items(), strict=True):
        for axis, (signal, one) in zip(row, signals.items(), strict=True):
            axis.loglog(one.tau, one.deviation**2, "o-", color=SIDE_1, markersize=3)
            axis.loglog(one.tau, one.std**2 * one.tau[0] / one.tau, "--", color=MEASURED, label="white: slope -1")
            axis.set(title=f"{signal.replace('_', ' ')}: {one.classification}", xlabel="averaging time [s]")
            axis.set_ylabel(f"{name}\n[({UNITS[signal]})²]" if signal == "force" else f"[({UNITS[signal]})²]")
            axis.legend()
    save(figure, path)


def main(argv: list[str] | None = None) -> int:
    """Run the command; exit code 0 if the whole recording was analysed, else 1 with one line on stderr."""
    arguments = _parser().parse_args(argv)
    try:
        recordings = read_recordings(arguments.input, arguments.transmission, arguments.namespace)
        results = {one.transmission: analyse(one) for one in recordings}
        noise = {name: signals for name, (signals, _) in results.items()}
        arguments.out.mkdir(parents=True, exist_ok=True)
        write_parameters(arguments.out / "noise.yaml", noise)
        plot(arguments.out / "noise.png", noise)
    except (BagError, RecordingError, TableError, OSError) as error:
        print(f"noise: {error}", file=sys.stderr)
        return 1
    for name, signals in noise.items():
        table = [
            [s, f"{a.std:.4g}", f"{a.std**2:.4g}", UNITS[s], f"{a.density:.3g}", f"{a.slope:.2f}", a.classification]
            for s, a in signals.items()
        ]
        note = f"Slope of the Allan variance: -1 for white noise. Timing: {results[name][1]}."
        show_table(name, HEADER, table, "; ".join([note, *constant_signals(signals)]))
    print(f"wrote {arguments.out}/noise.yaml and noise.png")
    if not all(one.complete for one in recordings):
        print(f"noise: {arguments.input}: the bag was cut off; what it holds was analysed", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="noise", description="Allan deviation and noise parameters of a recording.")
    parser.add_argument(
        "input", type=Path, help="CSV (stamp,force,deflection in s, N, m) or bag, at rest or on a slow ramp"
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
        "--out", type=Path, default=Path("noise"), metavar="DIR", help="folder for noise.yaml and noise.png"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
