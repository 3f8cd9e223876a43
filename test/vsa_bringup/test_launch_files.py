# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Launch files as `ros2 launch` runs them: by the launch system where it is installed, else by its stand-in."""

import importlib.util
import itertools
import os
import re
import signal
import sys
import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from lifecycle import observer, wait_until_active
from lifecycle_msgs.srv import GetState
from vsa_common.io.bags import read
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.subprocesses import Group

pytestmark = pytest.mark.live

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "src/vsa_bringup/launch"
DOMAIN = 20 + (os.getpid() + 30) % 80
ENVIRONMENT = os.environ | {
    "ROS_DOMAIN_ID": str(DOMAIN),
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "PYTHONUNBUFFERED": "1",
}
NUMBERS = itertools.count()
NODES = ("driver", "estimator_1", "estimator_2", "joint")


class Launch:
    """A launch file that runs."""

    def __init__(self, group, name, *arguments):
        command = [sys.executable, ROOT / "test/shared/launch_file.py", FOLDER / f"{name}.launch.py", *arguments]
        self.process = group.start(f"launch_{next(NUMBERS)}", command)

    def log(self):
        return self.process.log.read_text()

    def wait_until_active(self, *nodes):
        wait_until_active(DOMAIN, *nodes, alive=lambda: self.process.code is None)

    def pids(self, executable):
        """Process ids of an executable, in the order of their starts."""
        pattern = rf"\[{executable}(?:-\d+)?\]: process started with pid \[(\d+)\]"
        return [int(pid) for pid in re.findall(pattern, self.log())]

    def until(self, condition, timeout=60.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, self.log()
            time.sleep(0.05)

    def stop(self):
        """End by SIGINT; exit code."""
        self.process.signal(signal.SIGINT)
        return self.process.wait(30.0)


@pytest.fixture
def launch(tmp_path):
    with Group(tmp_path, ENVIRONMENT) as group:
        yield lambda name, *arguments: Launch(group, name, "robot_description:=false", *arguments)


@pytest.mark.skipif(
    importlib.util.find_spec("launch_ros") is None, reason="launch_ros is not installed: its stand-in runs"
)
def test_the_launch_system_is_the_installed_one():
    import launch_ros.actions

    assert "site-packages" in launch_ros.actions.__file__ or "dist-packages" in launch_ros.actions.__file__


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["config:=typo.yaml"], "typo.yaml: No such file or directory"),
        (["namspace:=left"], "namspace: no such argument; did you mean namespace?"),
        (["autostart:=yes"], "autostart = 'yes': must be one of true, false"),
    ],
)
@pytest.mark.parametrize("name", ["joint", "simulated", "composed"])
def test_a_refused_argument_ends_the_launch_with_one_line_and_starts_no_process(launch, name, arguments, expected):
    one = launch(name, *arguments)
    assert one.process.wait(60.0) == 1
    lines = [line for line in one.log().splitlines() if "[launch]" in line and "[INFO]" not in line]
    assert len(lines) == 1
    assert lines[0].endswith(expected)
    assert "process started" not in one.log()


@pytest.fixture
def slow_rig(tmp_path):
    """Argument with a parameter file of a low rate, with names for one of two joints."""
    text = (ROOT / "src/vsa_bringup/config/paper_rig.yaml").read_text().replace("rate_hz: 500", "rate_hz: 100")
    names = "{joint: {name: elbow}, motors: {names: [flexor, extensor]}}"
    (tmp_path / "rig.yaml").write_text(f"{text}\n/right/driver: {{ros__parameters: {names}}}\n")
    return f"config:={tmp_path / 'rig.yaml'}"


def test_two_simulated_joints_share_no_bus_and_differ_in_their_messages(launch, slow_rig, tmp_path):
    spaces, started = ("left", "right"), []
    for space in spaces:
        started.append(launch("simulated", slow_rig, f"namespace:={space}", f"record:={tmp_path / space}"))
        started[-1].wait_until_active(*(f"/{space}/{name}" for name in (*NODES, "rig_simulator", "recorder")))
    with observer(DOMAIN) as (node, until):
        samples, health = {space: [] for space in spaces}, {}
        for space, received in samples.items():
            node.create_subscription(WrenchStamped, f"/{space}/transmission_1/force", received.append, RELIABLE)
        node.create_subscription(
            DiagnosticArray, "/diagnostics", lambda m: health.update({s.name: s for s in m.status}), RELIABLE
        )
        until(lambda: all(len(received) > 300 for received in samples.values()))
        health.clear()
        tasks = [f"/{space}/driver: transmission_{i}" for space in spaces for i in (1, 2)]
        until(lambda: health.keys() >= {*tasks})
    for task in tasks:  # with two rigs on one bus nearly every counter would be lost or repeated
        counts = {item.key: item.value for item in health[task].values}
        wrong = sum(int(counts[key]) for key in ("lost", "duplicates", "late", "restarts"))
        assert wrong < 0.05 * int(counts["samples"]), counts
    assert [one.stop() for one in started] == [0, 0]
    frames, names = {}, {}
    for space in spaces:
        for topic, _, message in read(tmp_path / space):
            bare = topic.removeprefix(f"/{space}/")
            if hasattr(message, "header") and bare != "/diagnostics":
                frames.setdefault(bare, {}).setdefault(space, set()).add(message.header.frame_id)
            if hasattr(message, "name") and bare in ("joint_states", "motor_states"):
                names.setdefault(bare, {}).setdefault(space, set()).add(tuple(message.name))
    assert names == {
        "joint_states": {"left": {("joint",)}, "right": {("elbow",)}},
        "motor_states": {"left": {("motor_1", "motor_2")}, "right": {("flexor", "extensor")}},
    }
    assert frames.keys() >= {"joint_impedance", "joint_states", "motor_states", "transmission_2/impedance"}
    for of_spaces in frames.values():
        for space, ids in of_spaces.items():
            assert all(frame.startswith(f"{space}/") for frame in ids)


def test_controller_autostart_and_exit_handler(launch, slow_rig):
    one = launch("joint", slow_rig, "autostart:=false", "controller:=true", "on_exit:=shutdown")
    names = [f"/vsa/{name}" for name in (*NODES, "stiffness_controller")]
    with observer(DOMAIN) as (node, until):
        clients = [node.create_client(GetState, f"{name}/get_state") for name in names]
        until(lambda: all(client.service_is_ready() for client in clients))
        futures = [client.call_async(GetState.Request()) for client in clients]
        until(lambda: all(future.done() for future in futures))
        assert {future.result().current_state.label for future in futures} == {"unconfigured"}
    (pid,) = one.pids("joint")
    os.kill(pid, signal.SIGKILL)
    assert one.process.wait(30.0) == 0
    assert not any(Path("/proc", str(pid)).exists() for pid in one.pids("estimator") + one.pids("driver"))


def test_composed_has_a_namespace_and_is_started_again(launch, slow_rig):
    one = launch("composed", slow_rig, "namespace:=left", "on_exit:=respawn")
    nodes = [f"/left/{name}" for name in NODES]
    one.wait_until_active(*nodes)
    os.kill(one.pids("composed")[0], signal.SIGKILL)
    one.until(lambda: len(one.pids("composed")) == 2)
    one.wait_until_active(*nodes)
    assert one.stop() == 0
