# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Priority of the suite over other processes of the machine, for tests with limits in milliseconds."""

import contextlib
import dataclasses

from vsa_common.ros.realtime import renice

NICE = -15
RIG = {"realtime": {"priority": 50}}  # where permitted: a real rig does not compete for the processor


@contextlib.contextmanager
def raised_priority():
    """Raise the priority of this process for a block; the nice value for the suite, 0 where it is not permitted."""
    try:
        renice(NICE)
    except PermissionError:
        yield 0
        return
    try:
        yield NICE
    finally:
        renice(0)


def with_nice(processes, nice):
    """The same processes with that nice value; one with a positive value of its own keeps it."""
    return [dataclasses.replace(one, nice=one.nice if one.nice > 0 else nice) for one in processes]
