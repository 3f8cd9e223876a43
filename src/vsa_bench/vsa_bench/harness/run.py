# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One run: start the processes, run the rigs, record the outputs, stop the processes."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vsa_bench.harness.deployment import CONTROLLER_PRIORITY, Case, assigned_cores, rigs, suite, write_case
from vsa_bench.harness.observer import Observer
from vsa_bench.harness.score import Score, quantiles, score
from vsa_bench.harness.usage import cpu_seconds, resident_mb, stolen_seconds
from vsa_bench.harness.wake_latency import WakeLatency
from vsa_common.ros.realtime import RealTime, temporarily_applied
from vsa_common.ros.subprocesses import ProcessError
from vsa_tools.demo.harness import READY_S, SETTLE_S, ProcessHarness
from vsa_tools.demo.isolation import claim_domain

WARM_UP = 0.2  # share of the run before the first reading of the memory
DRAIN_S = 5.0  # time for queued messages at the end, besides half the run [s]

StartCompanions = Callable[[ProcessHarness], Sequence[str]]


@dataclass(frozen=True)
class _Usage:
    """Processor time of each process and of the hypervisor [% of a core], growth of the suite's memory [MB]."""

    cpu_percent: dict[str, float]
    stolen_percent: float
    grown_mb: float


def no_companions(_: ProcessHarness) -> list[str]:
    """Start nothing beside the suite."""
    return []


def run_case(case: Case, folder: Path, start_companions: StartCompanions = no_companions) -> dict[str, Any]:
    """The figures of one run; logs and the parameter file stay in `folder`. Raises ProcessError.

    `start_companions` starts further processes and returns the names of those whose processor time is measured.
    """
    domain = claim_domain()
    folder.mkdir(parents=True, exist_ok=True)
    parameters = folder / "parameters.yaml"
    write_case(parameters, case, domain.bus_port)
    with WakeLatency() as latency, ProcessHarness(domain.environment(), folder / "logs", "/bench") as harness:
        observer = Observer(harness.node, case)
        measured, simulated = suite(case), rigs(case)
        harness.start([*simulated, *measured], parameters)
        for namespace in case.namespaces:
            nodes = ("rig_simulator", "driver", "estimator_1", "estimator_2", "joint")
            harness.wait_until_active(*(f"/{namespace}/{node}" for node in nodes))
        _wait_until_connected(harness, observer)
        names = [one.name for one in [*simulated, *measured]] + list(start_companions(harness))
        pids = {name: harness.group[name].pid for name in names}
        with temporarily_applied(_subscriber_scheduling(case)):
            for namespace in case.namespaces:
                harness.request(f"/{namespace}/rig_simulator/start")
            latency.restart()
            usage = _measure(harness, case, pids, [one.name for one in measured])
            _drain(harness, observer, DRAIN_S + 0.5 * case.duration_s)
        machine = {
            "machine_late_ms": quantiles(1e3 * latency.seconds()),
            "stolen_percent": round(usage.stolen_percent, 1),
        }
        result = score([observer.joint_record(namespace) for namespace in case.namespaces])
    return figures(case, result, usage.cpu_percent, usage.grown_mb) | machine


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


def _measure(harness: ProcessHarness, case: Case, pids: dict[str, int], suite_names: list[str]) -> _Usage:
    """Spin for the duration of the case; processor time of all `pids` and this process, memory of the suite."""
    watched = pids | {"subscriber": os.getpid()}
    stolen = stolen_seconds()
    begin, used = time.monotonic(), {name: cpu_seconds(pid) for name, pid in watched.items()}
    harness.spin(WARM_UP * case.duration_s)
    resident = sum(resident_mb(pids[name]) for name in suite_names)
    harness.spin((1.0 - WARM_UP) * case.duration_s)
    grown = sum(resident_mb(pids[name]) for name in suite_names) - resident
    elapsed, stolen = time.monotonic() - begin, stolen_seconds() - stolen
    cpu = {name: 100.0 * (cpu_seconds(pid) - used[name]) / elapsed for name, pid in watched.items()}
    return _Usage(cpu, 100.0 * stolen / elapsed, grown)


def _subscriber_scheduling(case: Case) -> RealTime:
    """Scheduling of the subscriber: above all others, and on the rigs' core, where they have one."""
    cores = assigned_cores(case)
    return RealTime(priority=CONTROLLER_PRIORITY, cores=str(cores.outside) if cores else "")


def _wait_until_connected(harness: ProcessHarness, observer: Observer) -> None:
    end = time.monotonic() + READY_S
    while unconnected := observer.unconnected():
        if time.monotonic() > end:
            raise ProcessError(f"no publisher or no subscriber: {', '.join(unconnected)}")
        harness.spin(0.05)
    harness.spin(SETTLE_S)


def _drain(harness: ProcessHarness, observer: Observer, limit_s: float) -> None:
    end = time.monotonic() + limit_s
    while time.monotonic() < end and not observer.done():
        harness.spin(0.1)
    harness.spin_until_unchanged(observer.progress, end - time.monotonic())
