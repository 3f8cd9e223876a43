# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Child processes end on request and after the death of their parent."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from vsa_common.ros.subprocesses import Group, Process, ProcessError, executable

pytestmark = pytest.mark.live

PYTHON = sys.executable
IGNORES_SIGNALS = "trap '' INT TERM; echo ready; while :; do sleep 0.1; done"


@pytest.fixture
def group(tmp_path):
    with Group(tmp_path, os.environ) as processes:
        yield processes


def wait_for(condition, seconds: float = 10.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.02)
    return False


def alive(pid: int) -> bool:
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def test_a_process_ends_on_request_and_its_output_is_kept(group):
    process = group.start("printer", ["sh", "-c", "echo hello; exec sleep 100"])
    assert wait_for(lambda: "hello" in process.tail())
    group.stop("printer")
    assert process.code == -signal.SIGINT


def test_a_process_that_ignores_signals_is_killed_with_its_children(group, monkeypatch):
    monkeypatch.setattr("vsa_common.ros.subprocesses.STOP_S", 0.2)
    process = group.start("ignoring", ["sh", "-c", IGNORES_SIGNALS])
    assert wait_for(lambda: "ready" in process.tail())
    group.stop("ignoring")
    assert process.code == -signal.SIGKILL
    assert wait_for(
        lambda: subprocess.run(["pgrep", "-g", str(process.pid)], stdout=subprocess.DEVNULL).returncode != 0
    )


def test_a_process_that_fails_is_named_with_the_end_of_its_log(group):
    process = group.start("broken", ["sh", "-c", "echo no such bus; exit 3"])
    assert process.wait(10.0) == 3
    with pytest.raises(ProcessError, match=r"broken ended with code 3:\n  no such bus"):
        group.check()


def test_exit_code_0_is_no_error(group):
    group.start("brief", ["true"]).wait(10.0)
    group.check()


@pytest.mark.parametrize("command", ["exec sleep 100", IGNORES_SIGNALS])
def test_children_end_after_their_parent_was_killed(tmp_path, command):
    script = (
        "import os, sys, time; from pathlib import Path; from vsa_common.ros.subprocesses import Group\n"
        f"g = Group(Path({str(tmp_path)!r}), os.environ)\n"
        f"print(g.start('child', ['sh', '-c', {command!r}]).pid, flush=True); time.sleep(100)"
    )
    parent = subprocess.Popen([PYTHON, "-c", script], stdout=subprocess.PIPE, text=True)
    child = int(parent.stdout.readline())
    assert alive(child)
    parent.kill()
    parent.wait()
    assert wait_for(lambda: not alive(child), 5.0)


@pytest.mark.parametrize("nice", [0, 3])
def test_a_process_without_the_right_to_its_nice_value_runs_at_that_of_its_parent(tmp_path, monkeypatch, nice):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("vsa_common.ros.realtime.os.setpriority", refuse)
    process = Process("quiet", ["true"], tmp_path / "log", os.environ, nice)
    assert process.wait(10.0) == 0


def test_an_unknown_executable_is_rejected_by_name():
    with pytest.raises(ProcessError, match="no_such_package"):
        executable("no_such_package", "node")
