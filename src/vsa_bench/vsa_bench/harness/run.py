"""One run: the processes come up, the rigs run, everything is heard, the processes end."""

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from vsa_bench.harness.delay import Lateness
from vsa_bench.harness.deployment import CONTROLLER_PRIORITY, Case, apart, rigs, suite, write_case
from vsa_bench.harness.observer import Observer
from vsa_bench.harness.score import Score, quantiles, score
from vsa_bench.harness.usage import cpu_seconds, resident_mb, stolen_seconds
from vsa_common.ros.realtime import RealTime, temporarily_applied
from vsa_common.ros.subprocesses import ProcessError
from vsa_tools.demo.harness import READY_S, SETTLE_S, ProcessHarness
from vsa_tools.demo.isolation import claim_domain

WARM_UP = 0.2  # share of the run after which memory is looked at first
DRAIN_S = 5.0  # that what is queued up may take at the end, besides half the run


def nobody(_: ProcessHarness) -> list[str]:
    """Nothing runs besides."""
    return []


def perform(case: Case, folder: Path, besides: Callable[[ProcessHarness], Sequence[str]] = nobody) -> dict[str, Any]:
    """The figures of one run; logs and the parameter file stay in `folder`. Raises ProcessError.

    `besides` starts what else shall run and names the processes whose processor time is wanted.
    """
    corner = claim_domain()
    folder.mkdir(parents=True, exist_ok=True)
    parameters = folder / "parameters.yaml"
    write_case(parameters, case, corner.bus_port)
    with Lateness() as lateness, ProcessHarness(corner.environment(), folder / "logs", "/bench") as stage:
        observer = Observer(stage.node, case)
        members, simulated = suite(case), rigs(case)
        stage.start([*simulated, *members], parameters)
        for space in case.namespaces:
            nodes = ("rig_simulator", "driver", "estimator_1", "estimator_2", "joint")
            stage.wait_until_active(*(f"/{space}/{node}" for node in nodes))
        _until_connected(stage, observer)
        names = [part.name for part in [*simulated, *members]] + list(besides(stage))
        pids = {name: stage.group[name].pid for name in names}
        watched = pids | {"subscriber": os.getpid()}
        with temporarily_applied(_controller(case)):
            for space in case.namespaces:
                stage.request(f"/{space}/rig_simulator/start")
            lateness.forget()
            stolen = stolen_seconds()
            begin, used = time.monotonic(), {name: cpu_seconds(pid) for name, pid in watched.items()}
            stage.spin(WARM_UP * case.duration_s)
            resident = sum(resident_mb(pids[part.name]) for part in members)
            stage.spin((1.0 - WARM_UP) * case.duration_s)
            grown = sum(resident_mb(pids[part.name]) for part in members) - resident
            elapsed, stolen = time.monotonic() - begin, stolen_seconds() - stolen
            cpu = {name: 100.0 * (cpu_seconds(pid) - used[name]) / elapsed for name, pid in watched.items()}
            _drain(stage, observer, DRAIN_S + 0.5 * case.duration_s)
        machine = {
            "machine_late_ms": quantiles(1e3 * lateness.seconds()),
            "stolen_percent": round(100.0 * stolen / elapsed, 1),
        }
        result = score([observer.heard(space) for space in case.namespaces])
    return figures(case, result, cpu, grown) | machine


def figures(case: Case, result: Score, cpu: dict[str, float], grown_mb: float) -> dict[str, Any]:
    """The suite's part of one run, as the JSON file has it."""
    return {
        "mode": case.mode,
        "rate_hz": case.rate_hz,
        "joints": case.joints,
        "duration_s": case.duration_s,
        "samples_sent": result.sent,
        "samples_fused": result.fused,
        "samples_lost": result.lost,
        "sustained": result.sustained,
        "latency_ms": result.latency_ms,
        "cpu_percent": {name: round(percent, 1) for name, percent in cpu.items()},
        "rss_growth_mb": round(grown_mb, 2),
    }


def _controller(case: Case) -> RealTime:
    """What the subscriber asks for: before all others, and on the rigs' core, where they have one."""
    places = apart(case)
    return RealTime(priority=CONTROLLER_PRIORITY, cores=str(places[0]) if places else "")


def _until_connected(stage: ProcessHarness, observer: Observer) -> None:
    end = time.monotonic() + READY_S
    while lonely := observer.unconnected():
        if time.monotonic() > end:
            raise ProcessError(f"nobody reads or writes {', '.join(lonely)}")
        stage.spin(0.05)
    stage.spin(SETTLE_S)


def _drain(stage: ProcessHarness, observer: Observer, limit_s: float) -> None:
    end = time.monotonic() + limit_s
    while time.monotonic() < end and not observer.done():
        stage.spin(0.1)
    stage.spin_until_unchanged(observer.progress, end - time.monotonic())
