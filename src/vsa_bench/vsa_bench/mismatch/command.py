# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench mismatch`: the estimator beside peers where transmission or sensors are not the paper's."""

import argparse
import json
import os
import secrets
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from vsa_bench.estimation.methods import precompile
from vsa_bench.mismatch.cases import ALL, DEFAULT_LAW, GROUP_OF, LAWS, MOTIONS, QUICK, RATES_HZ, VARIANTS, Case, chosen
from vsa_bench.mismatch.drawn import DrawnCase, draw
from vsa_bench.mismatch.recorded import compare_all
from vsa_bench.mismatch.run import run_case
from vsa_bench.mismatch.table import pages
from vsa_common.blas import limit_blas_threads
from vsa_common.fork import forked_map
from vsa_common.terminal import Page, markdown, progress, show_pages

SEEDS, QUICK_SEEDS = 3, 1
SECONDS = 60.0
SHARED_DATA = Path("shared", "data")


def main(argv: list[str] | None = None) -> int:
    """Run the command; its exit code."""
    return run_or_read("mismatch", _arguments(argv), _run, pages)


def run_or_read(
    name: str,
    arguments: argparse.Namespace,
    run: Callable[[argparse.Namespace], dict[str, Any]],
    pages_of: Callable[[dict[str, Any]], Iterable[Page]],
    errors: tuple[type[Exception], ...] = (),
) -> int:
    """Run bench `name`, or read the report --from a file; write --json, show the pages of the report; the exit code.

    `errors` of bad input give one line, beside those of files.
    """
    expected: tuple[type[Exception], ...] = (OSError, json.JSONDecodeError, *errors)
    try:
        report = json.loads(arguments.from_json.read_text()) if arguments.from_json else run(arguments)
    except expected as error:
        print(f"bench {name}: {error}", file=sys.stderr)
        return 1
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(report, indent=1) + "\n")
    if arguments.markdown:
        print(markdown(pages_of(report)))
    else:
        show_pages(pages_of(report))
    return 0


def _run(arguments: argparse.Namespace) -> dict[str, Any]:
    base = secrets.randbits(31) if arguments.seed is None else arguments.seed
    cases: list[Case | DrawnCase] = [
        replace(one, elastic_law=arguments.elastic_law)
        for one in chosen(QUICK if arguments.quick else ALL, arguments.case, arguments.motion, arguments.rate)
    ]
    if arguments.drawn:
        rates_hz = arguments.rate or RATES_HZ
        cases = [draw(base, number, rates_hz, arguments.elastic_law) for number in range(arguments.drawn)]
    count = arguments.seeds or (QUICK_SEEDS if arguments.quick or arguments.drawn else SEEDS)
    seeds = np.random.SeedSequence(base).generate_state(count).tolist()
    results = run_cases(cases, seeds, arguments.seconds, arguments.workers)
    without = arguments.no_recordings or (arguments.drawn and not arguments.recordings)
    recorded = [] if without else _recorded(arguments.recordings or shared_data(), arguments.elastic_law)
    report = {"seed": base, "seconds": arguments.seconds, "elastic_law": arguments.elastic_law}
    return {**report, "cases": results, "recorded": recorded}


def _recorded(folder: Path | None, elastic_law: str) -> list[dict[str, Any]]:
    """Figures of the real recordings; a line on stderr for what is not usable."""
    if folder is None or not folder.is_dir():
        print(f"bench mismatch: no folder {folder or SHARED_DATA}: without real recordings", file=sys.stderr)
        return []
    entries, skipped = compare_all(folder, elastic_law)
    for line in skipped:
        print(f"bench mismatch: {line}", file=sys.stderr)
    return entries


def run_cases(
    cases: Sequence[Case | DrawnCase], seeds: Sequence[int], seconds: float, workers: int
) -> list[dict[str, Any]]:
    """Figures of all cases, in their order, from `workers` processes."""
    limit_blas_threads()
    precompile("force")
    with progress(len(cases), "cases", count=True) as bar:
        return forked_map(partial(_run_one, seeds=seeds, seconds=seconds), cases, workers, bar.advance)


def _run_one(case: Case | DrawnCase, seeds: Sequence[int], seconds: float) -> dict[str, Any]:
    try:
        return run_case(case, seeds, seconds)
    except Exception as error:
        raise RuntimeError(f"{case.label}, seeds {list(seeds)}: {error!r}") from error


def shared_data() -> Path | None:
    """`shared/data` in the current folder or in one above it; None without one."""
    return next((one / SHARED_DATA for one in (Path.cwd(), *Path.cwd().parents) if (one / SHARED_DATA).is_dir()), None)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench mismatch",
        description="Estimator and peers on transmissions and sensors that differ from the paper's, from wrong start "
        "values, in the default configuration. Every case in five motions at 100 Hz and 1 kHz.",
    )
    parser.add_argument(
        "--elastic-law", choices=LAWS, default=DEFAULT_LAW, help="parameter elastic_law of the estimator (%(default)s)"
    )
    _add_choice_of_cases(parser)
    parser.add_argument(
        "--seeds", type=int, metavar="COUNT", help=f"runs a case ({SEEDS}; {QUICK_SEEDS} with --quick or --drawn)"
    )
    parser.add_argument("--seed", type=int, help="base of the seeds; random by default")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="length of a recording (%(default)g)")
    parser.add_argument("--quick", action="store_true", help=f"{len(QUICK)} cases, one seed: within two minutes")
    parser.add_argument(
        "--workers", type=int, default=len(os.sched_getaffinity(0)), metavar="N", help="processes (%(default)s)"
    )
    parser.add_argument(
        "--recordings", type=Path, metavar="FOLDER", help="real recordings; default: ../shared/data where it exists"
    )
    parser.add_argument("--no-recordings", action="store_true", help="simulated cases only")
    parser.add_argument("--json", type=Path, metavar="FILE", help="all figures of all seeds")
    parser.add_argument("--from", dest="from_json", type=Path, metavar="FILE", help="no run: tables of a former --json")
    parser.add_argument("--markdown", action="store_true", help="print the tables as Markdown")
    arguments = parser.parse_args(argv)
    if arguments.drawn is not None and (arguments.drawn < 1 or arguments.case or arguments.motion or arguments.quick):
        parser.error("--drawn is at least 1, and goes without --case, --motion and --quick")
    if not list(chosen(QUICK if arguments.quick else ALL, arguments.case, arguments.motion, arguments.rate)):
        parser.error("no case has the given --case, --motion and --rate; without --quick there are more")
    return arguments


def _add_choice_of_cases(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--case", nargs="+", default=[], choices=[*VARIANTS, *GROUP_OF], metavar="NAME",
        help=f"cases or groups: {', '.join([*VARIANTS, *GROUP_OF])}",
    )  # fmt: skip
    parser.add_argument("--motion", nargs="+", default=[], choices=list(MOTIONS))
    parser.add_argument("--rate", nargs="+", type=int, default=[], choices=RATES_HZ, metavar="HZ", help="100 or 1000")
    parser.add_argument(
        "--drawn", type=int, metavar="COUNT",
        help="instead of the listed cases COUNT random ones: laws, up to two sensor errors and a motion of their own",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
