# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The simulated rig as its own process: real frames, real services, real signals."""

import os
import signal
import subprocess
import sys
import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from services import answer_of
from std_srvs.srv import Trigger
from vsa_driver.can.bus import BusConfig, open_bus
from vsa_driver.can.frames import RIG_DBC, FrameSet
from vsa_msgs.srv import InjectFailure

pytestmark = pytest.mark.live

DOMAIN = 20 + os.getpid() % 80
BUS = BusConfig(channel="239.74.163.72", options=("hop_limit=0", f"port={40000 + os.getpid() % 1000}"))
READ = FrameSet(RIG_DBC).message("Transmission1").reader("Force", "RollingCounter")


def start(*parameters):
    words = [f"bus.channel:={BUS.channel}", f"bus.options:=['{BUS.options[0]}','{BUS.options[1]}']", *parameters]
    arguments = [word for parameter in words for word in ("-p", parameter)]
    return subprocess.Popen(
        [sys.executable, "-m", "vsa_simulator.node", "--ros-args", *arguments],
        env=os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        stderr=subprocess.PIPE,
        text=True,
    )


class Client:
    """A receiver on the bus and a client of the rig's services."""

    def __init__(self):
        self.bus = open_bus(BUS)
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("client", namespace="vsa", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def call(self, kind, name, **fields):
        return answer_of(self.node, self.until, kind, f"rig_simulator/{name}", kind.Request(**fields))

    def until(self, condition):
        end = time.monotonic() + 60.0
        while not condition():
            assert time.monotonic() < end, "timeout"
            self.executor.spin_once(timeout_sec=0.01)

    def samples(self, until):
        """(force, counter) of transmission 1 up to the first for which `until` is true, for at most 60 s."""
        received, end = [], time.monotonic() + 60.0
        while time.monotonic() < end:
            frame = self.bus.receive(0.5)
            if frame is not None and frame.arbitration_id == 0x101:
                received.append(READ(bytes(frame.data)))
                if until(received[-1]):
                    return received
        raise AssertionError(f"not found among {len(received)} samples")

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()
        self.bus.close()


@pytest.fixture(scope="module")
def client():
    client = Client()
    yield client
    client.close()


def test_a_run_of_the_rig_with_clock_failures_and_end(client, tmp_path):
    truth, scenario = tmp_path / "truth.csv", tmp_path / "scenario.yaml"
    scenario.write_text("- {at: 0.2, failure: force wrong -i 1 -v 100 -t 0.1}\n")
    rig = start("rate_hz:=200", f"truth_file:={truth}", f"scenario:={scenario}", "autostart_clock:=false")
    try:
        assert client.call(Trigger, "start").success
        received = client.samples(lambda sample: sample[1] >= 80)
        counters = [counter for _, counter in received]
        assert counters == list(range(counters[-1] + 1))  # no sample before the start of the clock, no gap
        assert [counter for force, counter in received if force > 100.0] == list(range(40, 60))

        refused = client.call(InjectFailure, "failure", failure="force brocken")
        assert not refused.success
        assert "no failure type 'brocken'" in refused.message
        injected = client.call(InjectFailure, "failure", failure="failure force off -i 1 -t 0.1")
        assert (injected.success, injected.message) == (True, "force off -i 1 -t 0.1")
        received = client.samples(lambda sample: sample[0] == 0.0)
        received += client.samples(lambda sample: sample[0] != 0.0)
        assert sum(force == 0.0 for force, _ in received) == 20

        assert client.call(Trigger, "stop").message.startswith("clock stopped at sample ")
    finally:
        rig.send_signal(signal.SIGINT)
        errors = rig.communicate(timeout=20)[1]
    assert rig.returncode == 0
    assert "Traceback" not in errors
    assert "failure force wrong -i 1 -t 0.1 -v 100 from sample 40, 0.200 s" in errors
    lines = truth.read_text().splitlines()
    while (frame := client.bus.receive(0.1)) is not None:
        if frame.arbitration_id == 0x101:
            received.append(READ(bytes(frame.data)))
    assert len(lines) - 1 == received[-1][1] + 1  # a row for every sample that was sent
    assert lines[-1].startswith(f"{received[-1][1]},")


def test_a_rig_with_a_duration_is_idle_afterwards_and_ends_by_sigterm(client, tmp_path):
    truth = tmp_path / "truth.csv"
    rig = start("rate_hz:=200", "duration:=0.5", f"truth_file:={truth}")
    try:
        client.samples(lambda sample: sample[1] == 99)
        assert next(line for line in rig.stderr if "done: " in line).split("done: ")[1].startswith("100 samples, ")
        rest = [frame.arbitration_id for frame in iter(lambda: client.bus.receive(0.2), None)]
        assert set(rest) <= {0x102}  # of the last sample
        assert rig.poll() is None
    finally:
        rig.send_signal(signal.SIGTERM)
        errors = rig.communicate(timeout=20)[1]
    assert (rig.returncode, errors) == (0, "")
    assert len(truth.read_text().splitlines()) == 101


def test_a_failed_start_is_reported_in_one_line():
    reasons = {
        "transmission_2.k2:=-1.0": "transmission_2.k2 = -1.0 1/m: must be within 20.0 to 1000.0 1/m",
        "bus.interface:=nonsense": "cannot open CAN bus nonsense",
        "truth_file:=/nowhere/t.csv": "truth_file = '/nowhere/t.csv': No such file or directory",
        "scenario:=/nowhere.yaml": "scenario = '/nowhere.yaml': ",
    }
    for rig, reason in [(start(parameter), reason) for parameter, reason in reasons.items()]:
        lines = rig.communicate(timeout=120)[1].splitlines()
        assert rig.returncode == 1
        assert "Traceback" not in "".join(lines)
        assert len([line for line in lines if reason in line]) == 1
