"""Limits in milliseconds hold for a suite that has its computer: here it comes before the machine's other work."""

import contextlib
import dataclasses
import functools
import time

from vsa_bringup.live_bench.lateness import Lateness
from vsa_bringup.processes import renice

NICE = -15
TRIALS = 6
ENOUGH_S = 90.0  # after which no further trial begins: a test has 300 s
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
    """The result of the first trial during which no core stood still for more than `allowed` [s]; of the best, if none.

    The host takes cores away from a virtual machine, half a second at a time: what then comes late says nothing of
    the suite. `prepare` is called between two trials.
    """
    results = []
    for last in _trials():
        before = stood()
        result = trial()
        results.append((stood() - before, result))
        if results[-1][0] <= allowed or last():
            break
        prepare()
    return min(results, key=lambda one: one[0])[1]


def timed(test):
    """A test whose samples come by the wall clock: what fails while a core stands still is tried again."""

    @functools.wraps(test)
    def trials(*args, **kwargs):
        with watched():
            for last in _trials():
                before = stood()
                try:
                    test(*args, **kwargs)
                    return
                except AssertionError:
                    if last() or stood() <= before:
                        raise

    return trials


def _trials():
    """For each trial, what tells at its end whether it was the last."""
    end = time.monotonic() + ENOUGH_S
    for left in reversed(range(TRIALS)):
        yield lambda left=left: not left or time.monotonic() > end
