"""Limits in milliseconds hold for a suite that has its computer: here it comes before the machine's other work."""

import contextlib
import dataclasses

from vsa_bringup.live_bench.lateness import Lateness
from vsa_bringup.processes import renice

NICE = -15
TRIALS = 6
HICCUP = 0.02  # s by which a process that comes before all others may wake too late
RIG = {"realtime": {"priority": 50}}  # where permitted: a real rig is no process that waits for others

_WATCHES = []


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
    with Lateness() as watch:
        _WATCHES.append(watch)
        try:
            yield
        finally:
            _WATCHES.remove(watch)


def stood():
    """How long cores have stood still since `watched` [s]."""
    return sum(float(late[late > HICCUP].sum()) for late in (watch.seconds() for watch in _WATCHES))


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
