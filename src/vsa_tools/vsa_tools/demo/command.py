"""A simulated variable-stiffness joint, measured over CAN, estimated, recorded and judged.

Every node runs as a process of its own with one parameter file, or, where a scenario controls, in one process. The
estimators start wrong on purpose; at the end a table compares start, estimate and truth.
"""

import argparse
import contextlib
import json
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
from vsa_tools.demo.harness import ProcessHarness, ProcessSpec
from vsa_tools.demo.isolation import IsolationError, claim_domain
from vsa_tools.demo.parameters import Layer, base_parameters, lay_over, write_parameters, wrong_starts
from vsa_tools.demo.report_process import Reporter
from vsa_tools.scenarios.scenario import Scenario, ScenarioError, load_scenario, scenario_names

RATE_HZ = 500  # two cores lose nothing at it with the recorder on
DURATION_S = 60.0
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
MADE = ("bag", "logs", "figures", "parameters.yaml", "truth.csv", "summary.json", "report.html", "report.pdf")
END_S = 5.0  # for the last samples to arrive on a busy machine
Arrivals = list[tuple[int, int]]


def main(args: Sequence[str] | None = None) -> int:
    """Entry point."""
    options = _parser().parse_args(args)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    try:
        summary = perform(options, load_scenario(options.scenario, options))
    except KeyboardInterrupt:
        print(f"demo: stopped; what was recorded until then is in {options.out / 'bag'}", file=sys.stderr)
        return 130
    except _expected() as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    lost = sum(side["samples_lost"] for side in summary["transmissions"].values())
    print(f"{options.out / 'bag'}, summary.json and report.html are there" + f"; {lost} samples were lost" * bool(lost))
    return 0


def perform(options: argparse.Namespace, scenario: Scenario) -> dict[str, Any]:
    """Bring the suite up, let the rig's clock run, take all down, judge; the content of summary.json."""
    folder: Path = options.out
    clear(folder)
    corner = claim_domain()
    parameters = write_run(folder, options, corner.bus_port, scenario.parameters())
    page = free_port(VIEW_PORT) if options.view else 0
    parts = [*(COMPOSED if scenario.composed else PROCESSES), *scenario.parts(), *([_view(page)] if page else [])]
    nodes = [node for part in parts for node in part.nodes or (part.name,)]
    waiting = [node for node in nodes if node not in ("driver", "view")]
    with contextlib.ExitStack() as ends:
        with (
            progress(options.duration, "starting") as bar,
            ProcessHarness(corner.environment(), folder / "logs") as stage,
        ):
            stage.start(parts, parameters)
            stage.wait_until_active(*waiting)
            stage.activate("driver")  # last, so that nothing it says is missed
            stage.wait_until_connected()
            if page:
                stage.wait_until_open(page)
                print(f"live page: http://127.0.0.1:{page}/", flush=True)
            stage.request("rig_simulator/start")
            scenario.begin(stage.node)
            _watch(stage, options.duration, bar)
            reporter = ends.enter_context(Reporter())  # gets ready while the others stop
        return conclude(folder, stage.arrivals_ns, scenario, reporter)


def conclude(folder: Path, arrivals_ns: Arrivals, scenario: Scenario, reporter: Reporter) -> dict[str, Any]:
    """Judge, show and report the run in `folder`; the content of summary.json."""
    from vsa_tools.evaluation.run_summary import show, summarise

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
    """The parameter file of this run."""
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
        },
        "driver": {"autostart": False, "bus": bus},
        "recorder": {"out": str(folder.resolve() / "bag")},
    }
    base = base_parameters()
    rig = lay_over(lay_over(base, run), changes)["rig_simulator"]
    write_parameters(path, base, run, wrong_starts(rig, options.seed), changes)
    return path


def clear(folder: Path) -> None:
    """Make `folder`, without what an earlier demo left there."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in MADE:
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def free_port(wanted: int) -> int:
    """TCP port `wanted` of this machine if nobody has it, else any other."""
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", wanted))
        except OSError:
            probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _view(port: int) -> ProcessSpec:
    return ProcessSpec("view", "vsa_tools", "view", ("--port", str(port)), nice=10)


def _watch(stage: ProcessHarness, duration: float, bar: Bar) -> None:
    step, done = 0.25, 0.0
    while done < duration:
        stage.spin(min(step, duration - done))
        done += step
        bar.advance(step, "measuring")
    bar.advance(0.0, "stopping")
    stage.spin_until_idle(END_S)


def _expected() -> tuple[type[Exception], ...]:
    """Errors that a line explains. Asked for when there is one: their libraries take long to load."""
    from vsa_common.io.bags import BagError
    from vsa_common.io.tables import TableError

    return ProcessError, IsolationError, ScenarioError, ConfigurationError, BagError, TableError, OSError


def _interrupt(*_: object) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):  # once is enough; what follows takes its time
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="demo", description=__doc__)
    add = parser.add_argument
    add("--duration", type=float, default=DURATION_S, metavar="S", help="time of motion (%(default)s s)")
    add("--rate", type=int, default=RATE_HZ, metavar="HZ", help="samples a second (%(default)s)")
    add("--out", type=Path, default=Path("vsa_demo"), metavar="DIR", help="folder for what is made (%(default)s)")
    add("--seed", type=int, default=1, metavar="N", help="of noise and wrong start values (%(default)s)")
    add("--view", action="store_true", help="show the live page meanwhile")
    names = ", ".join(scenario_names()) or "none yet"
    add("--scenario", default="", metavar="NAME", help=f"do something besides: {names}")
    return parser


if __name__ == "__main__":
    sys.exit(main())
