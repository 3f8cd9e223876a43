"""Limits in milliseconds hold for a suite that has its computer: here it comes before the machine's other work."""

import contextlib
import dataclasses
import os
from pathlib import Path

from vsa_bringup.processes import renice

NICE = -15
STOLEN, TRIALS = 0.03, 6  # s that the host may take from the machine during a trial, and how often one is made
RIG = {"realtime": {"priority": 50}}  # where permitted: a real rig is no process that waits for others


@contextlib.contextmanager
def favoured():
    """Weight for the processes of a suite, ours included; the ordinary one where another is not permitted."""
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


def stolen():
    """Time that the host has taken from this machine's cores so far [s]; 0 where the kernel does not say."""
    total = Path("/proc/stat").read_text().split("\n", 1)[0].split()
    return int(total[8]) / os.sysconf("SC_CLK_TCK")


def undisturbed(trial, prepare, allowed=STOLEN):
    """The result of the first trial during which the machine was not taken away; of the last one, if none was so.

    A virtual machine may stand still for half a second: what then comes late says nothing of the suite. `prepare` is
    called between two trials.
    """
    for left in reversed(range(TRIALS)):
        before = stolen()
        result = trial()
        if stolen() - before < allowed or not left:
            return result
        prepare()
    raise AssertionError("no trial")
