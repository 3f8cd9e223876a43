# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench estimation`: formulations, peers and the Cramer-Rao bound on the same simulated recordings."""

import argparse
import json
import secrets
import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from vsa_bench.estimation.bound import equivalent_jerk_density, posterior_bound
from vsa_bench.estimation.cases import DEFAULT, FORCE_NOISE, HEAVY_INERTIA, QUICK, RIGS, Case, case
from vsa_bench.estimation.methods import METHODS
from vsa_bench.estimation.recordings import record
from vsa_bench.estimation.report import HEADER, NOTE, plot, rows
from vsa_bench.estimation.score import score
from vsa_bench.estimation.starts import draw
from vsa_common.terminal import progress, show_table
from vsa_simulator.rig.single_transmission import MOTIONS

SEEDS, QUICK_SEEDS = 20, 2
AXES = ("transmission", "rig", "motion", "mass", "rate_hz", "deflection_noise_mm", "coulomb_friction_n", "start")


def run_case(one: Case, seeds: list[int], methods: Sequence[str], seconds: float) -> dict[str, dict[str, Any]]:
    """Scores of all methods on one case, by method."""
    recording = record(one, seeds, seconds)
    starts = [draw(one, float(recording.truth.deflection[0]), seed) for seed in seeds]
    tracks = {name: METHODS[name](recording, starts) for name in methods}
    densities = [tracks[name].jerk_density for name in methods if np.isfinite(tracks[name].jerk_density)]
    bound = posterior_bound(
        recording, starts[0], densities[0] if densities else equivalent_jerk_density(recording.truth)
    )
    return {name: score(track, recording, bound) for name, track in tracks.items()}


def main(argv: list[str] | None = None) -> int:
    """Run the command; its exit code."""
    arguments = _arguments(argv)
    cases = _cases(arguments)
    base = secrets.randbits(31) if arguments.seed is None else arguments.seed
    count = arguments.seeds or (QUICK_SEEDS if arguments.quick else SEEDS)
    seeds = np.random.SeedSequence(base).generate_state(count).tolist()
    results: list[dict[str, dict[str, Any]]] = []
    with progress(len(cases), "", count=True) as bar:
        for one in cases:
            bar.advance(0, one.label)
            results.append(run_case(one, seeds, arguments.method, arguments.seconds))
            bar.advance(1)
    show_table(f"{count} seeds a case, from seed {base}", HEADER, rows(cases, results), NOTE, texts=2)
    report = {
        "seed": base,
        "seconds": arguments.seconds,
        "cases": [
            asdict(one) | {"seeds": seeds, "methods": result} for one, result in zip(cases, results, strict=True)
        ],
    }
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(report, indent=1) + "\n")
    if arguments.plot:
        plot(cases, results, arguments.plot)
    return 0


def _cases(arguments: argparse.Namespace) -> list[Case]:
    given = {axis: getattr(arguments, axis) for axis in AXES if getattr(arguments, axis) is not None}
    if not given:
        chosen = list(QUICK if arguments.quick else DEFAULT)
    else:
        values = {"transmission": ["transmission_1"], "motion": ["multisine"]} | given
        chosen = [case(**dict(zip(values, one, strict=True))) for one in product(*values.values())]
    if arguments.force_noise_n is not None:
        chosen = [replace(one, force_noise_n=arguments.force_noise_n) for one in chosen]
    return chosen


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench estimation",
        description="Estimators, peers and the posterior Cramer-Rao bound on the same simulated recordings. "
        "Without a choice of cases: a subset that covers all axes. With one: every combination of the given values.",
    )
    group = parser.add_argument_group("cases, each option with one value or several")
    group.add_argument("--transmission", nargs="+", choices=sorted(RIGS["paper"]))
    group.add_argument("--rig", nargs="+", choices=sorted(RIGS))
    group.add_argument("--motion", nargs="+", choices=list(MOTIONS))
    group.add_argument("--mass", nargs="+", choices=["light", "heavy"], help=f"heavy: a rod of {HEAVY_INERTIA:g} kg")
    group.add_argument("--rate", nargs="+", type=int, dest="rate_hz", metavar="HZ", help="100 or 1000")
    group.add_argument(
        "--noise", nargs="+", type=float, dest="deflection_noise_mm", metavar="MM", help="of deflection; "
        + ", ".join(f"{mm:g} mm goes with {n:g} N of force noise" for mm, n in FORCE_NOISE.items()),
    )  # fmt: skip
    group.add_argument(
        "--friction", nargs="+", type=float, dest="coulomb_friction_n", metavar="N", help="default: the rig's own"
    )
    group.add_argument("--start", nargs="+", choices=["good", "bad"])
    parser.add_argument(
        "--force-noise",
        type=float,
        dest="force_noise_n",
        metavar="N",
        help="default: that of --noise",
    )
    parser.add_argument("--method", nargs="+", choices=list(METHODS), default=list(METHODS))
    parser.add_argument("--seeds", type=int, metavar="COUNT", help=f"runs a case ({SEEDS}; {QUICK_SEEDS} with --quick)")
    parser.add_argument("--seed", type=int, help="base of the seeds; random by default")
    parser.add_argument("--seconds", type=float, default=60.0, help="length of a recording (60)")
    parser.add_argument("--quick", action="store_true", help="two cases, two seeds: within a minute")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="png, svg or pdf")
    return parser.parse_args(argv)


if __name__ == "__main__":
    sys.exit(main())
