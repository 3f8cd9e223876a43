# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench live`: sustained rate, delay and cost of the suite."""

import argparse
import json
import os
import platform
import sys
import tempfile
from itertools import product
from pathlib import Path
from typing import Any

from vsa_bench.harness.deployment import COMPOSED, MODES, SEPARATE, STANDARD_EXECUTOR, Case
from vsa_bench.harness.run import run_case
from vsa_bench.live.report import HEADER, NOTE, plot, row
from vsa_common.ros.realtime import renice
from vsa_common.ros.subprocesses import ProcessError
from vsa_common.terminal import progress, show_table
from vsa_tools.demo.isolation import IsolationError

RATES = (100, 200, 500, 1000, 2000)
DURATION_S, QUICK_S = 10.0, 15.0
DEFAULT = (
    *((mode, rate, 1) for mode in (SEPARATE, COMPOSED) for rate in RATES),
    *((STANDARD_EXECUTOR, rate, 1) for rate in (500, 1000)),
    (SEPARATE, 500, 2),
    *((COMPOSED, rate, 2) for rate in (500, 1000)),
)
QUICK = ((SEPARATE, 1000, 1), (COMPOSED, 1000, 1))


def main(argv: list[str] | None = None) -> int:
    """Run the command; its exit code."""
    options = _arguments(argv)
    runs: list[dict[str, Any]] = []
    cases = _cases(options)
    try:
        renice(options.nice)
        with tempfile.TemporaryDirectory() as scratch, progress(len(cases), "", count=True) as bar:
            for i, case in enumerate(cases):
                bar.advance(0, f"{case.mode}, {case.joints} x {case.rate_hz} Hz")
                runs.append(run_case(case, (options.logs or Path(scratch)) / str(i)))
                bar.advance(1)
    except KeyboardInterrupt:
        print("bench live: stopped", file=sys.stderr)
        return 130
    except (ProcessError, IsolationError, PermissionError) as error:
        print(f"bench live: {error}", file=sys.stderr)
        return 1
    cores, seconds = len(os.sched_getaffinity(0)), f"{cases[0].duration_s:g}"
    show_table(f"{cores} cores, {seconds} s a run", HEADER, [row(run) for run in runs], NOTE)
    if options.json:
        machine = {
            "cores": cores,
            "nice": options.nice,
            "kernel": platform.release(),
            "python": platform.python_version(),
        }
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps({"machine": machine, "runs": runs}, indent=1) + "\n")
    if options.plot:
        plot(runs, options.plot)
    return 0


def _cases(options: argparse.Namespace) -> list[Case]:
    duration = options.duration or (QUICK_S if options.quick else DURATION_S)
    chosen = QUICK if options.quick else DEFAULT
    if options.mode or options.rate or options.joints:
        chosen = tuple(product(options.mode or (SEPARATE, COMPOSED), options.rate or (1000,), options.joints or (1,)))
    return [Case(*one, duration, options.nice, options.asleep) for one in chosen for _ in range(options.repeat)]


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench live",
        description="Simulated rigs on a CAN bus interface; the suite as separate processes, composed in one, and "
        "under rclpy's standard executor: samples, delays, processor time and memory. Without a choice of runs: a "
        "subset that covers all modes and rates. With one: every combination of the given values.",
    )
    parser.add_argument("--mode", nargs="+", choices=MODES)
    parser.add_argument("--rate", nargs="+", type=int, metavar="HZ", help="samples a second")
    parser.add_argument("--joints", nargs="+", type=int, choices=range(1, 9), metavar="N")
    parser.add_argument("--duration", type=float, metavar="S", help=f"of a run ({DURATION_S:g})")
    parser.add_argument("--repeat", type=int, default=1, metavar="N", help="runs of each kind")
    parser.add_argument("--nice", type=int, default=0, metavar="N", help="-20 to 19, of every process of the suite")
    parser.add_argument("--asleep", action="store_true", help="composed without realtime.busy: blocks while it waits")
    parser.add_argument("--quick", action="store_true", help="1 kHz, separate and composed: within a minute")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="png, svg or pdf")
    parser.add_argument("--logs", type=Path, metavar="DIR", help="keep the output of the nodes there")
    return parser.parse_args(argv)


if __name__ == "__main__":
    sys.exit(main())
