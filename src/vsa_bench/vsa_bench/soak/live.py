"""The whole suite for a long time, with memory and file descriptors of every process watched."""

import os
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

from vsa_bench.harness.usage import resident_mb
from vsa_common.ros.node import RELIABLE
from vsa_common.terminal import progress
from vsa_msgs.msg import EstimatorState
from vsa_tools.demo.command import PROCESSES
from vsa_tools.demo.harness import ProcessHarness
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, write_parameters

RATE_HZ = 500
WARM_S = 30.0  # or a fifth of the time: until then a process still makes itself at home
LOOK_S = 1.0
DRAIN_S = 5.0


def soak_live(seconds: float) -> dict[str, Any]:
    """Figures of `seconds` [s] of rig, driver, estimators and joint. Raises ProcessError where one of them dies."""
    parts = [part for part in PROCESSES if part.name != "recorder"]
    corner = claim_domain()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={corner.bus_port}"]}
        rig = {"rate_hz": RATE_HZ, "autostart_clock": False, "duration": seconds, "bus": bus}
        changes = {"rig_simulator": rig, "driver": {"autostart": False, "bus": bus}}
        write_parameters(folder / "parameters.yaml", base_parameters(), changes)
        with progress(seconds, "starting") as bar, ProcessHarness(corner.environment(), folder / "logs") as stage:
            states: dict[str, EstimatorState] = {}
            for i in (1, 2):
                topic, name = f"transmission_{i}/estimator_state", f"estimator_{i}"
                stage.node.create_subscription(EstimatorState, topic, partial(states.__setitem__, name), RELIABLE)
            stage.start(parts, folder / "parameters.yaml")
            stage.wait_until_active(*(part.name for part in parts if part.name != "driver"))
            stage.activate("driver")
            stage.wait_until_connected(recorded=False)
            pids = {part.name: stage.group[part.name].pid for part in parts}
            stage.request("rig_simulator/start")
            begin, warm = time.monotonic(), min(WARM_S, 0.2 * seconds)
            before: dict[str, tuple[float, int]] = {}
            while (elapsed := time.monotonic() - begin) < seconds:
                stage.spin(min(LOOK_S, seconds - elapsed))
                stage.arrivals_ns.clear()
                bar.advance(LOOK_S, "soaking")
                if not before and elapsed > warm:
                    before = {name: _usage(pid) for name, pid in pids.items()}
            stage.spin_until_idle(DRAIN_S)
            after = {name: _usage(pid) for name, pid in pids.items()}
            sent = round(seconds * RATE_HZ)
            lost = {name: sent - int(state.samples_fused) for name, state in states.items()}
    return {
        "seconds": seconds,
        "samples_sent": sent,
        "samples_lost": sum(lost.values()),
        "resets": sum(int(state.reset_count) for state in states.values()),
        "valid_at_end": all(state.k2_valid for state in states.values()),
        "rss_growth_mb": {name: round(after[name][0] - before[name][0], 2) for name in pids},
        "descriptors_growth": {name: after[name][1] - before[name][1] for name in pids},
    }


def _usage(pid: int) -> tuple[float, int]:
    """Memory [MB] and open file descriptors of a process."""
    return resident_mb(pid), len(os.listdir(f"/proc/{pid}/fd"))
