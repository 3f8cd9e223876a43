# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Driver on one host, estimators and joint on another: effects of a slow, lossy and cut network."""

import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from host import undisturbed
from network_wire import Wire, permitted
from priority import RIG, raised_priority
from vsa_common.io import bags
from vsa_common.ros.subprocesses import executable, renice
from vsa_tools.demo.parameters import base_parameters, write_parameters
from vsa_tools.scenarios.fault_evaluation import undetected_error
from vsa_tools.scenarios.faults import FaultRecording

pytestmark = [pytest.mark.live, pytest.mark.skipif(not permitted(), reason="network namespaces are not permitted here")]

RATE = 200
INITIALIZATION, UNDISTURBED, SLOW, LOSSY, CUT, AFTER = 18.0, 2.0, 3.0, 3.0, 3.0, 6.0  # [s]
SUSPENDED = 0.04  # [s] permitted suspension of the cores, in sum
ON_HOSTS = (
    {"driver": ("vsa_driver", "driver"), "rig_simulator": ("vsa_simulator", "rig_simulator")},
    {
        "recorder": ("vsa_tools", "record"),
        "estimator_1": ("vsa_estimator", "estimator"),
        "estimator_2": ("vsa_estimator", "estimator"),
        "joint": ("vsa_joint", "joint"),
    },
)
EVERYTHING = type("Everything", (), {"begin": 0.0, "until": float("inf")})


class Run:
    """Times of the network's disturbances and the recording of the second host."""

    def __init__(self, folder, times, wire):
        self.recording = FaultRecording(folder)
        self.times, self.dropped, self.carried = times, wire.dropped, wire.carried
        messages = bags.read(folder / "bag", ["/vsa/joint_impedance"])
        rows = [(receive * 1e-9, m.stiffness_valid, m.header.stamp.sec + m.header.stamp.nanosec * 1e-9)
                for _, receive, m in messages]  # fmt: skip
        self.received, valid, self.stamped = np.array(rows, dtype=float).T
        self.valid = valid > 0

    def during(self, name, late=0.0):
        begin, end = self.times[name]
        return (self.received > begin + late) & (self.received < end)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("two_hosts")
    parameters = folder / "parameters.yaml"
    rig = {"rate_hz": RATE, "truth_file": str(folder / "truth.csv"), **RIG}
    write_parameters(parameters, base_parameters(), {"rig_simulator": rig, "recorder": {"out": str(folder / "bag")}})
    environment = os.environ | {"ROS_DOMAIN_ID": "77", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    environment.pop("ROS_LOCALHOST_ONLY", None)
    processes, times = [], {}

    def spend(name, seconds, **changes):
        for key, value in changes.items():
            setattr(wire, key, value)
        begin = time.time()
        time.sleep(seconds)  # duration of this state of the network
        times[name] = begin, time.time()

    with raised_priority() as nice, Wire() as wire:
        try:
            for host in (1, 0):
                for name, where in ON_HOSTS[host].items():
                    ros = ["--ros-args", "-r", f"__node:={name}", "--params-file", str(parameters)]
                    command = wire.command(host, [executable(*where), *ros])
                    own = {"start_new_session": True, "preexec_fn": lambda: renice(nice), "env": environment}
                    processes.append(subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **own))
            bag, end = folder / "bag" / "bag.mcap", time.monotonic() + 60.0
            while not bag.exists() or bag.stat().st_size < 200_000:
                assert time.monotonic() < end, [p.poll() for p in processes]
                time.sleep(0.1)
            shared = ["/dev/shm/fastrtps" in Path(f"/proc/{p.pid}/maps").read_text() for p in processes]
            spend("initialization", INITIALIZATION)
            undisturbed(lambda: spend("undisturbed", UNDISTURBED), lambda: None, SUSPENDED)
            undisturbed(lambda: spend("slow", SLOW, delay=0.03, jitter=0.01), lambda: None, 0.1)
            spend("lossy", LOSSY, delay=0.0, jitter=0.0, loss=0.05)
            wire.loss = 0.0
            undisturbed(
                lambda: [spend("cut", CUT, cut=True), spend("after", AFTER, cut=False)], lambda: None, SUSPENDED
            )
        finally:
            for process in processes:
                process.send_signal(signal.SIGINT)
            codes = [process.wait(15) for process in processes]
    assert codes == [0] * len(processes)
    assert not any(shared)
    return Run(folder, times, wire)


def test_estimates_cross_the_network_and_are_valid(run):
    assert run.carried > 1000
    assert run.valid[run.during("undisturbed")].all()


def test_a_slow_network_only_delays_estimates(run):
    slow = run.during("slow", late=0.5)
    assert run.valid[slow].mean() > 0.95
    assert np.median(run.received[slow] - run.stamped[slow]) > 0.03


def test_lost_packets_are_repeated(run):
    lossy = run.during("lossy", late=0.5)
    assert run.dropped > 10
    assert np.unique(run.stamped[lossy]).size > 0.8 * RATE * (LOSSY - 0.5)
    assert run.valid[lossy].mean() > 0.5


def test_a_cut_link_is_invalid_in_time_and_reported_until_its_repair(run):
    begin, _ = run.times["cut"]
    invalid = run.received[(run.received > begin) & ~run.valid]
    assert invalid[0] - begin < 0.1
    assert not run.valid[run.during("cut", late=0.3)].any()
    assert run.during("cut", late=0.3).sum() > 50  # the status is still published
    assert run.valid[run.during("after", late=AFTER - 1.0)].all()


def test_at_no_time_was_a_stiffness_valid_and_wrong(run):
    for name, source in run.recording.sources.items():
        assert undetected_error(source, EVERYTHING)[0] <= 0.1, name
