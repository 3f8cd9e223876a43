# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A simulated variable-stiffness joint: measurement over CAN, estimation, recording, evaluation.

Each node runs in its own process with one parameter file; a scenario with control composes them in one process. The
estimators start with perturbed coefficients; at the end a table compares start, estimate and truth.
"""

import argparse
import contextlib
import json
import math
import shutil
import signal
import socket
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from vsa_common.config.configuration import ConfigurationError
from vsa_common.ros.subprocesses import ProcessError
from vsa_common.terminal import Bar, progress
from vsa_joint.settings import SIMULATED_RECOVERY_AMPLITUDE
from vsa_tools.demo.harness import ProcessHarness, ProcessSpec
from vsa_tools.demo.isolation import IsolationError, claim_domain
from vsa_tools.demo.parameters import Layer, base_parameters, merge, perturbed_initial_values, write_parameters
from vsa_tools.demo.report_process import Reporter
from vsa_tools.demo.rig_options import add_rig_options, estimator_changes, reader_of, rig_changes
from vsa_tools.demo.scenario import Scenario, ScenarioError, load_scenario, scenario_names

RATE_HZ = 500  # without loss on two cores, recorder included
DURATION_S = 60.0  # both estimators converge in it
RECORDER = ProcessSpec("recorder", "vsa_tools", "record", nice=5)
RIG = ProcessSpec("rig_simulator", "vsa_simulator", "rig_simulator")
NODES = ("estimator_1", "estimator_2", "joint", "driver")
COMPOSED = (RECORDER, ProcessSpec("composed", "vsa_bringup", "composed", nodes=NODES), RIG)
PROCESSES = (
    RECORDER,
    ProcessSpec("estimator_1", "vsa_estimator", "estimator"),
    ProcessSpec("estimator_2", "vsa_estimator", "estimator"),
    ProcessSpec("joint", "vsa_joint", "joint"),
    RIG,
    ProcessSpec("driver", "vsa_driver", "driver"),
)
VIEW_PORT = 8080
OUTPUTS = (
    "bag", "logs", "figures", "parameters.yaml", "pushes.yaml", "truth.csv", "summary.json", "control.json",
    "coefficients.yaml", "report.html", "report.pdf",
)  # fmt: skip
DRAIN_S = 5.0  # [s] limit for the last samples to arrive, on a machine under full load
Arrivals = list[tuple[int, int]]


def main(args: Sequence[str] | None = None) -> int:
    """Entry point."""
    options = _parser().parse_args(args)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    try:
        scenario = load_scenario(options.scenario, options)
        summary = run(options, scenario)
    except KeyboardInterrupt:
        print(f"demo: interrupted; the recording is in {options.out / 'bag'}", file=sys.stderr)
        return 130
    except _expected() as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    lost = sum(side["samples_lost"] for side in summary["transmissions"].values())
    print(f"wrote {options.out / 'bag'}, summary.json and report.html" + f"; {lost} samples lost" * bool(lost))
    return exit_code(scenario.failures(summary.get("scenario", {})))


def exit_code(failures: Sequence[str]) -> int:
    """1 if there are failures, each of which is printed; else 0."""
    for failure in failures:
        print(f"demo: {failure}", file=sys.stderr)
    return 1 if failures else 0


def run(options: argparse.Namespace, scenario: Scenario) -> dict[str, Any]:
    """Start the suite, run the rig's clock, stop all processes, evaluate. Returns the content of summary.json."""
    folder: Path = options.out
    clear(folder)
    domain = claim_domain()
    parameters = write_run(folder, options, domain.bus_port, scenario.parameters())
    page = free_port(VIEW_PORT) if options.view else 0
    processes = [
        *(COMPOSED if scenario.composed else PROCESSES),
        *scenario.processes(),
        *([_view(page)] if page else []),
    ]
    nodes = [node for process in processes for node in process.nodes or (process.name,)]
    waiting = [node for node in nodes if node not in ("driver", "view")]
    with contextlib.ExitStack() as ends:
        with (
            progress(options.duration, "starting") as bar,
            ProcessHarness(domain.environment(), folder / "logs") as harness,
        ):
            harness.start(processes, parameters)
            harness.start_loops(options.busy, parameters)
            harness.wait_until_active(*waiting)
            harness.activate("driver")  # last: all subscribers receive its first message
            harness.wait_until_connected()
            if page:
                harness.wait_until_open(page)
                print(f"live page: http://127.0.0.1:{page}/", flush=True)
            harness.request("rig_simulator/start")
            scenario.begin(harness.node)
            _watch(harness, options.duration, bar)
            reporter = ends.enter_context(Reporter())  # loads its libraries while the nodes stop
        return evaluate(folder, harness.arrivals_ns, scenario, reporter)


def evaluate(folder: Path, arrivals_ns: Arrivals, scenario: Scenario, reporter: Reporter) -> dict[str, Any]:
    """Evaluate the run in `folder`, print its tables, write its report. Returns the content of summary.json."""
    from vsa_tools.evaluation.run_summary import summarise
    from vsa_tools.evaluation.run_table import show

    with progress(None, "reading the bag"):
        summary = summarise(folder, arrivals_ns)
    figures = scenario.evaluate(folder)
    if figures:
        summary["scenario"] = figures
    (folder / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    show(summary)
    with progress(None, "writing the report"):
        reporter.write(folder)
    return summary


def write_run(folder: Path, options: argparse.Namespace, bus_port: int, changes: Layer) -> Path:
    """Write the parameter file of this run; returns its path."""
    path = folder / "parameters.yaml"
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={bus_port}"]}
    run: dict[str, Mapping[str, Any]] = {
        "rig_simulator": {
            "rate_hz": options.rate,
            "seed": options.seed,
            "duration": options.duration,
            "truth_file": str(folder.resolve() / "truth.csv"),
            "autostart_clock": False,
            "bus": bus,
            **rig_changes(options),
        },
        "driver": {"autostart": False, "bus": bus},
        "recorder": {"out": str(folder.resolve() / "bag")},
        "stiffness_controller": {"recovery_amplitude": SIMULATED_RECOVERY_AMPLITUDE},
        **estimator_changes(options),
    }
    base = base_parameters()
    rig = merge(merge(base, run), changes)["rig_simulator"]
    write_parameters(path, base, run, perturbed_initial_values(rig, options.seed), changes)
    return path


def clear(folder: Path) -> None:
    """Create `folder`; remove the outputs of an earlier demo from it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in OUTPUTS:
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def free_port(wanted: int) -> int:
    """TCP port `wanted` of this machine if it is free, else any free port."""
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", wanted))
        except OSError:
            probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _view(port: int) -> ProcessSpec:
    return ProcessSpec("view", "vsa_tools", "view", ("--port", str(port)), nice=10)


def _watch(harness: ProcessHarness, duration: float, bar: Bar) -> None:
    step, done = 0.25, 0.0
    while done < duration:
        harness.spin(min(step, duration - done))
        done += step
        bar.advance(step, "measuring")
    bar.advance(0.0, "stopping")
    harness.spin_until_idle(DRAIN_S)


def _expected() -> tuple[type[Exception], ...]:
    """Errors that end the demo with one line. Imported on demand: their libraries load slowly."""
    from vsa_common.io.bags import BagError
    from vsa_common.io.tables import TableError

    return ProcessError, IsolationError, ScenarioError, ConfigurationError, BagError, TableError, OSError


def _interrupt(*_: object) -> None:
    for number in (
        signal.SIGINT,
        signal.SIGTERM,
    ):  # the shutdown that follows takes seconds and must not be interrupted
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


def _duration(text: str) -> float:
    seconds = float(text)
    if not 0.0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text} s: must be above 0 s")
    return seconds


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="demo", description=__doc__)
    add = parser.add_argument
    add("--duration", type=_duration, default=DURATION_S, metavar="S", help="time of motion (%(default)s s)")
    add("--rate", type=reader_of("rate_hz"), default=RATE_HZ, metavar="HZ", help="samples per second (%(default)s)")
    add("--out", type=Path, default=Path("vsa_demo"), metavar="DIR", help="output folder (%(default)s)")
    add(
        "--seed",
        type=reader_of("seed"),
        default=1,
        metavar="N",
        help="seed of noise and start values (%(default)s)",
    )
    add("--view", action="store_true", help="serve the live page during the run")
    add(
        "--busy",
        type=int,
        choices=range(65),
        default=0,
        metavar="N",
        help="busy loops beside it, as of a loaded machine",
    )
    names = ", ".join(scenario_names()) or "none"
    add("--scenario", default="", metavar="NAME", help=f"scenario besides the plain motion: {names}")
    add_rig_options(parser)
    return parser


if __name__ == "__main__":
    sys.exit(main())
