# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parallel tasks in forked processes: results, progress and failures."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from vsa_common.fork import ForkedTasks, forked_map


def test_results_are_in_the_order_of_the_tasks_and_every_step_is_reported():
    steps = []

    def task(name, count):
        def run(report):
            for _ in range(count):
                report(2.0)
            return name, os.getpid()

        return run

    results = ForkedTasks(task("slow", 50), task("fast", 3)).results(steps.append)
    assert [name for name, _ in results] == ["slow", "fast"]
    assert len({os.getpid(), *(process for _, process in results)}) == 3
    assert sum(steps) == 106.0


def test_the_exception_of_a_failed_task_is_raised(tmp_path):
    missing = tmp_path / "missing" / "file"
    with pytest.raises(OSError, match="missing/file"):
        ForkedTasks(lambda report: missing.touch(), lambda report: None).results()


def test_a_process_that_ends_without_a_result_is_an_error():
    with pytest.raises(OSError, match="without a result"):
        ForkedTasks(lambda report: os._exit(3)).results()


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_a_map_has_its_results_in_the_order_of_the_items(workers):
    steps = []
    assert forked_map(lambda item: item * item, range(4), workers, steps.append) == [0, 1, 4, 9]
    assert sum(steps) == 4
    assert forked_map(lambda item: item, [], workers, steps.append) == []


def wait_until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def running(pid):
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


TASKS = """
import os, pathlib, sys, time
from vsa_common.fork import ForkedTasks

def task(report):
    pathlib.Path(sys.argv[1]).write_text(f"{os.getpid()}.")
    time.sleep(60.0)

ForkedTasks(task).results()
"""
POOL = """
import os, pathlib, sys, time
from concurrent.futures import ProcessPoolExecutor
from vsa_common.fork import killed_with

def task(path):
    pathlib.Path(path).write_text(f"{os.getpid()}.")
    time.sleep(60.0)

with ProcessPoolExecutor(1, initializer=killed_with, initargs=(os.getpid(),)) as pool:
    pool.submit(task, sys.argv[1]).result()
"""


@pytest.mark.parametrize("script", [TASKS, POOL], ids=["tasks", "pool"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_forked_process_ends_with_the_process_that_started_it(tmp_path, script, number):
    path = tmp_path / "pid"
    command = subprocess.Popen([sys.executable, "-c", script, str(path)])
    assert wait_until(lambda: path.exists() and path.read_text().endswith("."))
    child = int(path.read_text().rstrip("."))
    assert running(child)
    command.send_signal(number)
    command.wait(10.0)
    assert wait_until(lambda: not running(child))


def test_a_task_ends_once_its_results_have_no_reader(tmp_path):
    def task(report):
        (tmp_path / "begun").touch()
        while True:
            report(1.0)

    tasks = ForkedTasks(task)
    assert wait_until((tmp_path / "begun").exists)
    del tasks
    assert wait_until(lambda: not multiprocessing.active_children())
