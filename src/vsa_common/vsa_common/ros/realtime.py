# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Real-time hints to the kernel. A refused hint is reported, and the node runs without it."""

import ctypes
import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from vsa_common.config.configuration import flag, quantity, string

_MCL_CURRENT, _MCL_FUTURE = 1, 2  # <sys/mman.h>
_PR_SET_TIMERSLACK = 29  # <linux/prctl.h>
_MAX_CORES = 4096
_LIBC = ctypes.CDLL(None, use_errno=True)


@dataclass(frozen=True)
class RealTime:
    """Scheduling and memory of a process."""

    priority: int = quantity(0, "", 0, 99, "SCHED_FIFO priority of the whole process; 0: the ordinary scheduler")
    nice: int = quantity(0, "", -20, 19, "weight of process and session in the scheduler, -20 is the most; 0 leaves it")
    cores: str = string("", "run on these cores only, like 1 or 2-3 or 1,3; empty: any core")
    busy: bool = flag(False, "poll for messages without sleeping: takes a whole core, whose caches stay warm")
    rest: float = quantity(
        0.0, "s", 0.0, 0.05, "pause between turns of a thread that takes a quarter of a core; 0: none"
    )
    lock_memory: bool = flag(False, "lock the process in memory: no page fault delays a sample")


def set_timer_slack() -> None:
    """Timer slack of 1 ns for this thread and those that it starts; the kernel's default extends each wait by 50 us."""
    _LIBC.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)


def renice(nice: int) -> None:
    """Set the nice value of every thread of this process and of its session. Raises PermissionError."""
    for thread in _threads():
        os.setpriority(os.PRIO_PROCESS, thread, nice)
    with suppress(OSError):  # with autogroups the kernel weighs sessions, not processes
        Path("/proc/self/autogroup").write_text(str(nice))


def apply_hints(hints: RealTime) -> list[str]:
    """Apply `hints` to every thread of this process; for each refused hint a line with reason and remedy."""
    refusals = []
    if hints.nice:
        refusals += _attempt(f"nice = {hints.nice}", "CAP_SYS_NICE or LimitNICE=", lambda: renice(hints.nice))
    if hints.priority:
        hint = f"priority = {hints.priority}"
        refusals += _attempt(hint, "CAP_SYS_NICE or LimitRTPRIO=", lambda: _schedule(hints.priority))
    if hints.cores:
        refusals += _attempt(f"cores = {hints.cores!r}", "an existing core", lambda: _set_cores(cores(hints.cores)))
    if hints.lock_memory:
        refusals += _attempt("lock_memory", "CAP_IPC_LOCK or LimitMEMLOCK=", _lock_memory)
    return refusals


@contextmanager
def temporarily_applied(hints: RealTime) -> Iterator[list[str]]:
    """`apply_hints` for a block; at its end each thread that existed before has its former cores and priority."""
    before = {
        thread: (os.sched_getaffinity(thread), os.sched_getscheduler(thread), os.sched_getparam(thread))
        for thread in _threads()
    }
    try:
        yield apply_hints(hints)
    finally:
        for thread, (affinity, scheduler, parameters) in before.items():
            with suppress(ProcessLookupError):
                os.sched_setaffinity(thread, affinity)
                os.sched_setscheduler(thread, scheduler, parameters)


def cores(text: str) -> set[int]:
    """Core numbers from a list in the syntax of taskset. Raises OSError for any other text.

    >>> sorted(cores("1,4-6"))
    [1, 4, 5, 6]
    """
    try:
        spans = [[int(end) for end in part.split("-", 1)] for part in text.split(",")]
    except ValueError:
        spans = [[_MAX_CORES]]
    if any(span[-1] >= _MAX_CORES for span in spans):
        raise OSError(errno.EINVAL, "not a list of cores")
    return {core for span in spans for core in range(span[0], span[-1] + 1)}


def _attempt(hint: str, remedy: str, apply: Callable[[], None]) -> list[str]:
    try:
        apply()
    except OSError as error:
        return [f"realtime.{hint} is not permitted ({error.strerror}) and is ignored; {remedy} would permit it"]
    return []


def _threads() -> list[int]:
    return [int(task.name) for task in Path("/proc/self/task").iterdir()]


def _schedule(priority: int) -> None:
    for thread in _threads():  # threads created later inherit it
        os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority))


def _set_cores(numbers: set[int]) -> None:
    for thread in _threads():
        os.sched_setaffinity(thread, numbers)


def _lock_memory() -> None:
    if _LIBC.mlockall(_MCL_CURRENT | _MCL_FUTURE):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
