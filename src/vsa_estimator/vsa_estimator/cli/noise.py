"""`./vsa noise`: noise of force, force rate and position from a recording at rest or on a slow ramp (section VI)."""

import argparse
import sys
from pathlib import Path

import numpy as np
import yaml
from vsa_common.figures import MEASURED, SIDE_1, panels, save
from vsa_common.io.bags import BagError
from vsa_common.io.tables import TableError
from vsa_common.terminal import show_table
from vsa_common.types import Array
from vsa_estimator.force_rate.rate_filter import RATE_FILTER, filtered_rate
from vsa_estimator.offline.allan import Allan, allan
from vsa_estimator.offline.recordings import Recording, RecordingError, read_recordings

FEWEST = 200  # samples
SETTLED = 8.0  # time constants of the rate filter until it has forgotten its start
INDEPENDENT = 2.0  # time constants between two rates that count as independent
UNITS = {"force": "N", "force_rate": "N/s", "deflection": "m"}
HEADER = ("signal", "std", "variance", "unit", "std of 1 s mean", "slope", "noise")


def analyse(recording: Recording) -> dict[str, Allan]:
    """Allan deviations of force, force rate and deflection; a straight slope in time (a ramp) is taken out first.

    The force rate is that of the paper's first-order filter, taken at times so far apart that only the sensor's
    noise, not the filter's memory, can relate them.
    Raises RecordingError for a recording that is too short or too uneven.
    """
    finite = np.isfinite(recording.stamp) & np.isfinite(recording.force) & np.isfinite(recording.deflection)
    time, force, deflection = (a[finite] for a in (recording.stamp, recording.force, recording.deflection))
    steps = np.diff(time)
    if len(time) < FEWEST:
        raise RecordingError(f"{recording.source}: expected at least {FEWEST} samples, found {len(time)}")
    step = float(np.median(steps))
    uneven = np.flatnonzero(np.abs(steps - step) > 0.5 * step)
    if step <= 0.0 or len(uneven):
        line = int(np.flatnonzero(finite)[uneven[0] + 1]) + 2 if len(uneven) else 3
        raise RecordingError(f"{recording.source}: line {line}: expected samples {step:g} s apart")
    rate = filtered_rate(force, step)[
        round(SETTLED * RATE_FILTER / step) :: max(1, round(INDEPENDENT * RATE_FILTER / step))
    ]
    every = step * max(1, round(INDEPENDENT * RATE_FILTER / step))
    signals = {"force": (force, step), "force_rate": (rate, every), "deflection": (deflection, step)}
    return {name: allan(_without_ramp(signal), 1.0 / period) for name, (signal, period) in signals.items()}


def write_parameters(path: Path, found: dict[str, dict[str, Allan]]) -> None:
    """A ROS parameter file with the noise of each transmission's estimator."""
    tree = {}
    for name, signals in found.items():
        noise = {f"{signal}_noise_std": float(f"{signals[signal].std:.6g}") for signal in ("force", "deflection")}
        tree[f"/**/{name.replace('transmission', 'estimator')}"] = {"ros__parameters": noise}
    notes = [
        f"# {name}: {signal} {one.std:.4g} {UNITS[signal]}, {one.verdict} (slope {one.slope:.2f})\n"
        for name, signals in found.items()
        for signal, one in signals.items()
    ]
    path.write_text("".join(notes) + yaml.safe_dump(tree, sort_keys=False))


def plot(path: Path, found: dict[str, dict[str, Allan]]) -> None:
    """Fig. 6: Allan variance over averaging time, beside the slope of white noise."""
    figure, axes = panels(len(found), 3, width=10.0, height=2.7 * len(found) + 0.4, title="Allan variance")
    for row, (name, signals) in zip(np.atleast_2d(axes), found.items(), strict=True):
        for axis, (signal, one) in zip(row, signals.items(), strict=True):
            axis.loglog(one.tau, one.deviation**2, "o-", color=SIDE_1, markersize=3)
            axis.loglog(one.tau, one.std**2 * one.tau[0] / one.tau, "--", color=MEASURED, label="white: slope -1")
            axis.set(title=f"{signal.replace('_', ' ')}: {one.verdict}", xlabel="averaging time [s]")
            axis.set_ylabel(f"{name}\n[({UNITS[signal]})²]" if signal == "force" else f"[({UNITS[signal]})²]")
            axis.legend()
    save(figure, path)


def main(argv: list[str] | None = None) -> int:
    """Run the command: 0, or 1 with one line on stderr."""
    arguments = _parser().parse_args(argv)
    try:
        found = {one.transmission: analyse(one) for one in read_recordings(arguments.input, arguments.transmission)}
        arguments.out.mkdir(parents=True, exist_ok=True)
        write_parameters(arguments.out / "noise.yaml", found)
        plot(arguments.out / "noise.png", found)
    except (BagError, RecordingError, TableError, OSError) as error:
        print(f"noise: {error}", file=sys.stderr)
        return 1
    for name, signals in found.items():
        table = [
            [s, f"{a.std:.4g}", f"{a.std**2:.4g}", UNITS[s], f"{a.density:.3g}", f"{a.slope:.2f}", a.verdict]
            for s, a in signals.items()
        ]
        show_table(name, HEADER, table, "Slope of the Allan variance: -1 for white noise.")
    print(f"wrote {arguments.out}/noise.yaml and noise.png")
    return 0


def _without_ramp(signal: Array) -> Array:
    line = np.linspace(-1.0, 1.0, len(signal))
    return np.asarray(signal - signal.mean() - line * float(line @ signal) / float(line @ line))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="noise", description="Allan deviation and noise parameters of a recording.")
    parser.add_argument(
        "input", type=Path, help="CSV (stamp,force,deflection; s, N, m) or bag, at rest or on a slow ramp"
    )
    parser.add_argument(
        "--transmission", metavar="NAME", help="of a bag: just this one; of a CSV: its name (transmission_1)"
    )
    parser.add_argument("--out", type=Path, default=Path("noise"), metavar="DIR", help="for noise.yaml and noise.png")
    return parser


if __name__ == "__main__":
    sys.exit(main())
