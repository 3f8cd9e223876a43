# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The whole suite for a long time; memory and open file descriptors of every process."""

import os
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from vsa_bench.harness.usage import resident_mb
from vsa_common.ros.node import RELIABLE
from vsa_common.terminal import Bar, progress
from vsa_msgs.msg import EstimatorState
from vsa_tools.demo.command import PROCESSES
from vsa_tools.demo.harness import ProcessHarness
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, write_parameters

RATE_HZ = 500
WARM_UP_S = 30.0  # or a fifth of the time: a process still allocates until then
PERIOD_S = 1.0
DRAIN_S = 5.0


class Usage(NamedTuple):
    """Resources of a process."""

    resident_mb: float
    descriptors: int


def soak_live(seconds: float) -> dict[str, Any]:
    """Figures of `seconds` [s] of rig, driver, estimators and joint. Raises ProcessError where a process ends."""
    processes = [one for one in PROCESSES if one.name != "recorder"]
    domain = claim_domain()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        _write_parameters(folder / "parameters.yaml", seconds, domain.bus_port)
        with progress(seconds, "starting") as bar, ProcessHarness(domain.environment(), folder / "logs") as harness:
            states = _subscribe_states(harness)
            harness.start(processes, folder / "parameters.yaml")
            harness.wait_until_active(*(one.name for one in processes if one.name != "driver"))
            harness.activate("driver")
            harness.wait_until_connected(recorded=False)
            pids = {one.name: harness.group[one.name].pid for one in processes}
            harness.request("rig_simulator/start")
            before = _run(harness, bar, pids, seconds)
            harness.spin_until_idle(DRAIN_S)
            after = {name: _usage(pid) for name, pid in pids.items()}
            sent = round(seconds * RATE_HZ)
            lost = {name: sent - int(state.samples_fused) for name, state in states.items()}
    return {
        "seconds": seconds,
        "samples_sent": sent,
        "samples_lost": sum(lost.values()),
        "resets": sum(int(state.reset_count) for state in states.values()),
        "valid_at_end": all(state.k2_valid for state in states.values()),
        "rss_growth_mb": {name: round(after[name].resident_mb - before[name].resident_mb, 2) for name in pids},
        "descriptors_growth": {name: after[name].descriptors - before[name].descriptors for name in pids},
    }


def _write_parameters(path: Path, seconds: float, bus_port: int) -> None:
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={bus_port}"]}
    rig = {"rate_hz": RATE_HZ, "autostart_clock": False, "duration": seconds, "bus": bus}
    write_parameters(path, base_parameters(), {"rig_simulator": rig, "driver": {"autostart": False, "bus": bus}})


def _subscribe_states(harness: ProcessHarness) -> dict[str, EstimatorState]:
    """The last state of each estimator, by node; the subscriptions fill it."""
    states: dict[str, EstimatorState] = {}
    for i in (1, 2):
        topic, name = f"transmission_{i}/estimator_state", f"estimator_{i}"
        harness.node.create_subscription(EstimatorState, topic, partial(states.__setitem__, name), RELIABLE)
    return states


def _run(harness: ProcessHarness, bar: Bar, pids: dict[str, int], seconds: float) -> dict[str, Usage]:
    """Spin for `seconds` [s]; the usage of each process after the warm-up."""
    begin, warm_up_s = time.monotonic(), min(WARM_UP_S, 0.2 * seconds)
    warm: dict[str, Usage] = {}
    while (elapsed := time.monotonic() - begin) < seconds:
        harness.spin(min(PERIOD_S, seconds - elapsed))
        harness.arrivals_ns.clear()
        bar.advance(PERIOD_S, "soaking")
        if not warm and elapsed > warm_up_s:
            warm = {name: _usage(pid) for name, pid in pids.items()}
    return warm


def _usage(pid: int) -> Usage:
    return Usage(resident_mb(pid), len(os.listdir(f"/proc/{pid}/fd")))
