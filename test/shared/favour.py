"""Limits in milliseconds hold for a suite that has its computer: here it comes before the machine's other work."""

import contextlib
import dataclasses

from vsa_common.ros.subprocesses import renice

NICE = -15
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
