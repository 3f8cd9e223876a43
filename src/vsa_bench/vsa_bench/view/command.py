# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench view`: processor time of the live page beside a running suite, and delay with and without it."""

import argparse
import json
import shutil
import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from vsa_bench.harness.deployment import COMPOSED, SEPARATE, Case
from vsa_bench.harness.run import StartCompanions, no_companions, run_case
from vsa_bench.live.report import OUTSIDE
from vsa_common.ros.subprocesses import ProcessError, executable
from vsa_common.terminal import progress, show_table
from vsa_tools.demo.command import free_port
from vsa_tools.demo.harness import ProcessHarness
from vsa_tools.demo.isolation import IsolationError

START_UP_S = 4.0  # of server and browser, not measured
SERVER = "view"
BROWSER = "--headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run --window-size=1400,1000"
NONE, ELSEWHERE, HERE = "no page", "page on another computer", "page in Chromium here"
HEADER = ("", "server [%]", "suite [%]", "sent", "lost", "p50 [ms]", "p99", "p99.9", "max")
NOTE = (
    "Delay from the capture stamp of a sample's later CAN frame to its joint message in another process; processor "
    "time in % of a core. The page on another computer is a client without rendering; Chromium renders in software."
)


def main(args: list[str] | None = None) -> int:
    """Run the command; its exit code: 1, with one line on stderr, where a process fails; 130 after Ctrl-C."""
    options = _parser().parse_args(args)
    case = Case(options.mode, options.rate, 1, options.duration)
    runs: list[dict[str, Any]] = []
    try:
        with tempfile.TemporaryDirectory() as scratch, progress(3 * options.repeat, "", count=True) as bar:
            logs = options.logs or Path(scratch)
            pages = companions(case, Path(scratch))
            for i in range(options.repeat):
                for page, start_companions in pages.items():
                    bar.advance(0, page)
                    run = run_case(case, logs / f"{page.replace(' ', '_')}_{i}", start_companions)
                    runs.append({"page": page, **run})
                    bar.advance(1)
    except KeyboardInterrupt:
        print("bench view: stopped", file=sys.stderr)
        return 130
    except (ProcessError, IsolationError, PermissionError) as error:
        print(f"bench view: {error}", file=sys.stderr)
        return 1
    if HERE not in pages:
        print(
            "bench view: without chromium, which is not installed (Debian: apt install chromium)",
            file=sys.stderr,
        )
    title = f"{case.mode} at {case.rate_hz} Hz, medians of {options.repeat} x {case.duration_s:g} s"
    show_table(title, HEADER, [row(page, [run for run in runs if run["page"] == page]) for page in pages], NOTE)
    if options.json:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps({"runs": runs}, indent=1) + "\n")
    return 0


def row(page: str, runs: list[dict[str, Any]]) -> list[str]:
    """One line of the table: medians over the runs with that page, and the sum of their lost samples."""
    server = [run["cpu_percent"].get(SERVER, np.nan) for run in runs]
    suite = [
        sum(percent for name, percent in run["cpu_percent"].items() if not name.endswith((*OUTSIDE, SERVER)))
        for run in runs
    ]
    delays = [[run["latency_ms"][name] for run in runs] for name in runs[0]["latency_ms"]]
    counts = [str(sum(run[name] for run in runs)) for name in ("samples_sent", "samples_lost")]
    return [
        page,
        "-" if page == NONE else f"{np.median(server):.1f}",
        f"{np.median(suite):.0f}",
        *counts,
        *("-" if None in values else f"{np.median(values):.2f}" for values in delays),
    ]


def companions(case: Case, scratch: Path) -> dict[str, StartCompanions]:
    """What starts the processes beside the suite, by name, in the order in which they are measured."""
    reader = [sys.executable, "-m", "vsa_tools.view.server"]
    pages: dict[str, StartCompanions] = {NONE: no_companions, ELSEWHERE: partial(_serve, case, reader)}
    browser = shutil.which("chromium")
    if browser:
        command = [browser, *BROWSER.split(), "--remote-debugging-port=0", f"--user-data-dir={scratch / 'browser'}"]
        pages[HERE] = partial(_serve, case, command)
    return pages


def _serve(case: Case, client: list[str], harness: ProcessHarness) -> list[str]:
    """Start the page's server, and `client` with the page's address; the name of the server."""
    port = free_port(8080)
    namespace = f"/{case.namespaces[0]}"
    harness.group.start(SERVER, [executable("vsa_tools", "view"), "--port", str(port), "--namespace", namespace])
    harness.wait_until_open(port)
    harness.group.start("client", [*client, f"http://127.0.0.1:{port}"])
    harness.spin(START_UP_S)
    return [SERVER]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bench view", description=__doc__)
    parser.add_argument("--rate", type=int, default=1000, metavar="HZ", help="samples a second (%(default)s)")
    parser.add_argument(
        "--mode", choices=(SEPARATE, COMPOSED), default=COMPOSED, help="deployment of the nodes (%(default)s)"
    )
    parser.add_argument("--duration", type=float, default=15.0, metavar="S", help="of a run (%(default)g)")
    parser.add_argument("--repeat", type=int, default=2, metavar="N", help="runs of each kind, in turn (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    parser.add_argument("--logs", type=Path, metavar="DIR", help="keep the output of the processes there")
    return parser
