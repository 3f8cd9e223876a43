"""Limits in milliseconds hold for a suite that has its computer: here it comes before the machine's other work."""

import contextlib
import dataclasses
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from vsa_bringup.processes import renice

NICE = -15
TRIALS = 6
HICCUP = 0.02  # s by which a process that comes before all others may wake too late
RIG = {"realtime": {"priority": 50}}  # where permitted: a real rig is no process that waits for others

WATCH = """
import os, sys, time
os.sched_setaffinity(0, {int(sys.argv[1])})
try:
    os.setpriority(os.PRIO_PROCESS, 0, -20)
except PermissionError:
    pass
last, parent = time.monotonic(), os.getppid()
while os.getppid() == parent:
    time.sleep(0.002)
    last, late = time.monotonic(), time.monotonic() - last - 0.002
    if late > float(sys.argv[3]):
        with open(sys.argv[2], "a") as log:
            print(late, file=log)
"""
_LOGS = []


@contextlib.contextmanager
def favoured():
    """Weight for the processes of a suite, ours included; the ordinary one where another is not permitted."""
    with watched():
        try:
            renice(NICE)
        except PermissionError:
            yield 0
            return
        try:
            yield NICE
        finally:
            renice(0)


def with_weight(parts, nice):
    """The same parts, with that weight; those that shall come last stay behind."""
    return [dataclasses.replace(part, nice=part.nice if part.nice > 0 else nice) for part in parts]


@contextlib.contextmanager
def watched():
    """Note, for `undisturbed`, how long each core stands still meanwhile."""
    with tempfile.TemporaryDirectory() as folder:
        logs = {core: Path(folder) / str(core) for core in os.sched_getaffinity(0)}
        command = [sys.executable, "-S", "-c", WATCH]
        watches = [subprocess.Popen([*command, str(core), str(log), str(HICCUP)]) for core, log in logs.items()]
        _LOGS.extend(logs.values())
        try:
            yield
        finally:
            _LOGS.clear()
            for watch in watches:
                watch.kill()
                watch.wait()


def stood():
    """How long cores have stood still since `watched` [s]."""
    return sum(float(line) for log in _LOGS if log.exists() for line in log.read_text().split())


def undisturbed(trial, prepare, allowed=0.0):
    """The result of the first trial during which no core stood still for more than `allowed` [s]; of the last, if none.

    The host takes cores away from a virtual machine, half a second at a time: what then comes late says nothing of
    the suite. `prepare` is called between two trials.
    """
    for left in reversed(range(TRIALS)):
        before = stood()
        result = trial()
        if stood() - before <= allowed or not left:
            return result
        prepare()
    raise AssertionError("no trial")
