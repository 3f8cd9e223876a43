# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench faults`: delay, isolation and recovery for each fault, and false alarms on healthy motion."""

import argparse
import os
import secrets
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from vsa_bench.estimation.methods import precompile
from vsa_bench.faults.cases import (
    DEFAULT,
    FAULT_CASES,
    FAULTS,
    HEALTHY,
    HEALTHY_CASES,
    QUICK_FAULTS,
    QUICK_HEALTHY,
    RATES_HZ,
    TRANSMISSIONS,
    chosen_faults,
    chosen_healthy,
)
from vsa_bench.faults.motions import FAULT_MOTIONS, HEALTHY_MOTIONS
from vsa_bench.faults.run import RECORDED, RECORDED_COLUMNS, run_fault, run_healthy, run_recorded
from vsa_bench.faults.stamps import STAMPS
from vsa_bench.faults.table import pages
from vsa_bench.mismatch.command import run_or_read, shared_data
from vsa_common.blas import limit_blas_threads
from vsa_common.fork import forked_map
from vsa_common.io.tables import TableError, read_columns
from vsa_common.terminal import progress

SEEDS, QUICK_SEEDS = 3, 1
HOURS, QUICK_HOURS = 100.0, 0.4
RECORDING_S, MIN_RECORDING_S = 600.0, 60.0  # length of the healthy recordings, at most and at least
NAMES = (*FAULTS, HEALTHY, *TRANSMISSIONS, *STAMPS)

Task = tuple[str, Callable[[], dict[str, Any]]]  # label, function


class NoCaseError(ValueError):
    """The options exclude every case."""


def main(argv: list[str] | None = None) -> int:
    """Run the command; its exit code."""
    return run_or_read("faults", _arguments(argv), _run, pages, (TableError, NoCaseError))


def _run(arguments: argparse.Namespace) -> dict[str, Any]:
    base = secrets.randbits(31) if arguments.seed is None else arguments.seed
    faults, healthy = _fault_tasks(arguments, base), _healthy_tasks(arguments, base)
    if not faults and not healthy:
        raise NoCaseError("no case has the given --case, --motion and --rate; without --quick there are more")
    limit_blas_threads()
    precompile("force")
    tasks = [*faults, *healthy]
    with progress(len(tasks), "runs", count=True) as bar:
        results = forked_map(_run_one, tasks, arguments.workers, bar.advance)
    return {"seed": base, "faults": results[: len(faults)], "healthy": results[len(faults) :]}


def _run_one(task: Task) -> dict[str, Any]:
    label, function = task
    try:
        return function()
    except Exception as error:
        raise RuntimeError(f"{label}: {error!r}") from error


def _fault_tasks(arguments: argparse.Namespace, base: int) -> list[Task]:
    cases = QUICK_FAULTS if arguments.quick else FAULT_CASES
    count = arguments.seeds or (QUICK_SEEDS if arguments.quick else SEEDS)
    return [
        (f"{case.label}, seed {seed}", partial(run_fault, case, seed, arguments.transmission))
        for case in chosen_faults(cases, arguments.case, arguments.motion, arguments.rate)
        for seed in np.random.SeedSequence(base).generate_state(count).tolist()
    ]


def _healthy_tasks(arguments: argparse.Namespace, base: int) -> list[Task]:
    """Healthy recordings of equal length, with a seed each, and the real one where it exists.

    Of cases that are too many for the hours some are drawn.
    """
    available = QUICK_HEALTHY if arguments.quick else HEALTHY_CASES
    cases = list(chosen_healthy(available, arguments.case, arguments.motion, arguments.rate))
    hours = arguments.hours or (QUICK_HOURS if arguments.quick else HOURS)
    count = max(1, int(3600.0 * hours / MIN_RECORDING_S))
    if count < len(cases):
        chosen = np.random.default_rng([base, 2]).choice(len(cases), count, replace=False)
        cases = [cases[i] for i in sorted(chosen.tolist())]
    tasks: list[Task] = []
    if cases:
        rounds = max(1, round(3600.0 * hours / (len(cases) * RECORDING_S)))
        seconds = 3600.0 * hours / (len(cases) * rounds)
        seeds = np.random.SeedSequence([base, 1]).generate_state(rounds * len(cases)).tolist()
        tasks = [
            (f"{case.label}, seed {seed}", partial(run_healthy, case, seed, seconds))
            for case, seed in zip(cases * rounds, seeds, strict=True)
        ]
    folder = arguments.recordings or shared_data()
    if folder and (folder / RECORDED).is_file() and not arguments.case:
        tasks.append((RECORDED, partial(run_recorded, read_columns(folder / RECORDED, RECORDED_COLUMNS))))
    return tasks


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench faults",
        description="Detection delay, isolation, undetected error and recovery for each fault at 100, 500 and 1000 Hz, "
        "and false alarms on healthy motion, of the estimator in its default configuration from wrong start values.",
    )
    _add_selection(parser)
    parser.add_argument(
        "--workers", type=int, default=len(os.sched_getaffinity(0)), metavar="N", help="processes (%(default)s)"
    )
    parser.add_argument(
        "--recordings", type=Path, metavar="FOLDER", help=f"folder of {RECORDED}; default: ../shared/data if it exists"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="all figures of all runs")
    parser.add_argument("--from", dest="from_json", type=Path, metavar="FILE", help="no run: tables of a former --json")
    parser.add_argument("--markdown", action="store_true", help="print the tables as Markdown")
    return parser.parse_args(argv)


def _add_selection(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--case", nargs="+", default=[], choices=NAMES, metavar="NAME",
        help=f"faults, or healthy recordings by transmission or stamps: {', '.join(NAMES)}",
    )  # fmt: skip
    parser.add_argument(
        "--transmission", default=DEFAULT, choices=TRANSMISSIONS, metavar="NAME",
        help=f"transmission of the faults: {', '.join(TRANSMISSIONS)} (%(default)s)",
    )  # fmt: skip
    motions = list(dict.fromkeys((*FAULT_MOTIONS, *HEALTHY_MOTIONS)))
    parser.add_argument("--motion", nargs="+", default=[], choices=motions)
    parser.add_argument("--rate", nargs="+", type=int, default=[], choices=RATES_HZ, metavar="HZ")
    parser.add_argument(
        "--seeds", type=int, metavar="COUNT", help=f"runs a fault ({SEEDS}; {QUICK_SEEDS} with --quick)"
    )
    parser.add_argument("--seed", type=int, help="base of the seeds; random by default")
    parser.add_argument(
        "--hours", type=float, metavar="H", help=f"of healthy motion in all ({HOURS:g}; {QUICK_HOURS:g} with --quick)"
    )
    parser.add_argument("--quick", action="store_true", help="100 Hz, one seed, minutes of healthy motion")


if __name__ == "__main__":
    sys.exit(main())
