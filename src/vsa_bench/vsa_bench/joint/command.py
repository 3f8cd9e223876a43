# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench joint`: impedance of the joint, identified independently of the estimators, against the estimate."""

import argparse
import json
import sys
from dataclasses import asdict, astuple
from itertools import product
from pathlib import Path

from vsa_bench.joint.case import Case
from vsa_bench.joint.experiment import run
from vsa_bench.joint.plot import plot
from vsa_bench.joint.recorded import identify_bag
from vsa_bench.joint.report import HEADER, NOTE, case_json, rows, summary
from vsa_common.config.configuration import load
from vsa_common.fork import forked_map
from vsa_common.io.bags import BagError
from vsa_common.terminal import progress, show_table
from vsa_joint.experiment.excitation import PERIOD
from vsa_joint.settings import JointConfig
from vsa_simulator.laws.springs import EXPONENTIAL, SPRINGS

FORCES = (19.5, 30.0, 50.0, 80.0, 120.0)  # N, levels of co-contraction
TENDONS = (2e4, 1e5, 2e6)  # N/m
FRICTIONS = (0.3, 0.5)  # N
SEEDS = 2


def main(argv: list[str] | None = None) -> int:
    """Run the experiment; exit code 0, 1 for a bag or configuration that is not usable, or 130 after Ctrl-C."""
    arguments = _arguments(argv)
    if arguments.bag:
        return _from_bag(arguments)
    try:
        cases = _cases(arguments)
        with progress(len(cases), "experiments", count=True) as bar:
            outcomes = forked_map(run, cases, arguments.jobs, bar.advance)
    except KeyboardInterrupt:
        print("bench joint: stopped", file=sys.stderr)
        return 130
    spring = "" if arguments.spring == EXPONENTIAL else f", {arguments.spring} spring"
    show_table(f"Joint impedance: experiment and estimate{spring}", HEADER, rows(outcomes), NOTE, texts=0)
    print(summary(outcomes))
    if arguments.json:
        arguments.json.write_text(json.dumps({"cases": [case_json(o) for o in outcomes]}, indent=1) + "\n")
    if arguments.plot:
        plot(outcomes, arguments.plot)
    return 0


def _from_bag(arguments: argparse.Namespace) -> int:
    try:
        config = load(arguments.config, "joint", JointConfig) if arguments.config else JointConfig()
        identified = identify_bag(arguments.bag, config.joint, arguments.period)
    except (BagError, ValueError) as error:
        print(f"bench joint: {error}", file=sys.stderr)
        return 1
    units = {"stiffness": "N m/rad", "damping": "N m s/rad", "inertia": "kg m^2"}
    table = [
        [name, f"{value:.4g}", f"{value - 1.96 * std:.4g} to {value + 1.96 * std:.4g}", units[name]]
        for name, value, std in zip(units, astuple(identified.impedance), astuple(identified.std), strict=True)
    ]
    note = f"dry friction {1e3 * identified.friction:.3g} mN m, residual {1e3 * identified.residual:.3g} mN m rms"
    show_table("Joint impedance from torque and angle", ("", "value", "95 % interval", ""), table, note)
    if arguments.json:
        result = {
            "identified": asdict(identified.impedance),
            "identified_std": asdict(identified.std),
            "friction": identified.friction,
        }
        arguments.json.write_text(json.dumps(result, indent=1) + "\n")
    return 0


def _cases(arguments: argparse.Namespace) -> list[Case]:
    forces, tendons, seeds = arguments.force, [1e3 * k for k in arguments.tendon], arguments.seeds
    if arguments.quick:
        forces, tendons, seeds = [50.0], [1e5], 1
    chosen = []
    for friction in arguments.friction:
        repeats = seeds if friction else 1
        first = arguments.seed + (1000 if friction == max(FRICTIONS) else 0)
        chosen += [
            Case(force, tendon, friction, first + repeat, arguments.spring)
            for tendon, force, repeat in product(tendons, forces, range(repeats))
        ]
    return chosen


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench joint",
        description="Held motors, external torque on the joint: impedance from torque and angle alone, against the "
        "truth of the simulated rig, the reflections and the live estimate. Faster than real time.",
    )
    parser.add_argument(
        "--force", nargs="+", type=float, default=list(FORCES), metavar="N", help="force while the motors are held"
    )
    parser.add_argument("--tendon", nargs="+", type=float, default=[1e-3 * k for k in TENDONS], metavar="N/mm")
    parser.add_argument(
        "--friction", nargs="+", type=float, default=[0.0, *FRICTIONS], metavar="N", help="of each transmission"
    )
    parser.add_argument(
        "--spring", choices=[EXPONENTIAL, *SPRINGS], default=EXPONENTIAL, help="elastic law of both transmissions"
    )
    parser.add_argument(
        "--seeds", type=int, default=SEEDS, metavar="COUNT", help=f"runs a case with friction ({SEEDS})"
    )
    parser.add_argument("--seed", type=int, default=1, help="first seed (1)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    parser.add_argument(
        "--quick", action="store_true", help="one force and tendon, with and without friction: within a minute"
    )
    parser.add_argument(
        "--bag", type=Path, help="no simulation: identify from external_torque and joint_states of a bag"
    )
    parser.add_argument(
        "--period", type=float, default=PERIOD, metavar="S", help="period of the bag's torque (%(default)s)"
    )
    parser.add_argument(
        "--config", type=Path, metavar="YAML", help="configuration with section `joint`: geometry for the bag"
    )
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="png, svg or pdf")
    return parser.parse_args(argv)


if __name__ == "__main__":
    sys.exit(main())
