"""Real-time hints to the kernel. One that is not permitted is said, and the node works without it."""

import ctypes
import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from threadpoolctl import threadpool_limits
from vsa_common.config.configuration import flag, quantity, string

_MCL_CURRENT, _MCL_FUTURE = 1, 2  # <sys/mman.h>
_PR_SET_TIMERSLACK = 29  # <linux/prctl.h>
_MOST_CORES = 4096
_LIBC = ctypes.CDLL(None, use_errno=True)


@dataclass(frozen=True)
class RealTime:
    """What a process may ask of the kernel."""

    priority: int = quantity(0, "", 0, 99, "SCHED_FIFO priority of the whole process; 0: the ordinary scheduler")
    nice: int = quantity(0, "", -20, 19, "weight in the ordinary scheduler, -20 is the most; 0 leaves it")
    cores: str = string("", "run on these cores alone, like 1 or 2-3 or 1,3; empty leaves it to the kernel")
    busy: bool = flag(False, "look for work without ever sleeping: takes a core, which is never cold then")
    rest: float = quantity(
        0.0, "s", 0.0, 0.05, "rest between turns of a thread that takes a quarter of a core; 0: none"
    )
    lock_memory: bool = flag(False, "keep the process in memory: no sample waits for the disk")


def limit_blas_threads() -> None:
    """Linear algebra in the thread that asks for it: helpers on busy cores keep a sample waiting for 100 ms."""
    threadpool_limits(limits=1)


def set_timer_slack() -> None:
    """End waits of this thread, and of those that it starts, when they should: by default the kernel adds 50 us."""
    _LIBC.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)


def apply_hints(hints: RealTime) -> list[str]:
    """Apply `hints` to every thread of this process; why, with the remedy, for each that was refused."""
    refusals = []
    if hints.nice:
        refusals += _asked(f"nice = {hints.nice}", "CAP_SYS_NICE or LimitNICE=", lambda: _renice(hints.nice))
    if hints.priority:
        wish = f"priority = {hints.priority}"
        refusals += _asked(wish, "CAP_SYS_NICE or LimitRTPRIO=", lambda: _schedule(hints.priority))
    if hints.cores:
        refusals += _asked(f"cores = {hints.cores!r}", "one that is there", lambda: _stay(cores(hints.cores)))
    if hints.lock_memory:
        refusals += _asked("lock_memory", "CAP_IPC_LOCK or LimitMEMLOCK=", _lock)
    return refusals


@contextmanager
def temporarily_applied(hints: RealTime) -> Iterator[list[str]]:
    """`apply_hints` hints about cores and priority; who was there before has its own back in the end."""
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
    """Numbers from a list as taskset has it. Raises OSError for one that is none.

    >>> sorted(cores("1,4-6"))
    [1, 4, 5, 6]
    """
    try:
        spans = [[int(end) for end in part.split("-", 1)] for part in text.split(",")]
    except ValueError:
        spans = [[_MOST_CORES]]
    if any(span[-1] >= _MOST_CORES for span in spans):
        raise OSError(errno.EINVAL, "no list of cores")
    return {core for span in spans for core in range(span[0], span[-1] + 1)}


def _asked(wish: str, remedy: str, ask: Callable[[], None]) -> list[str]:
    try:
        ask()
    except OSError as error:
        return [f"realtime.{wish} is not permitted ({error.strerror}), going on without; {remedy} would permit it"]
    return []


def _threads() -> list[int]:
    return [int(task.name) for task in Path("/proc/self/task").iterdir()]


def _renice(nice: int) -> None:
    for thread in _threads():
        os.setpriority(os.PRIO_PROCESS, thread, nice)


def _schedule(priority: int) -> None:
    for thread in _threads():  # later ones inherit it
        os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority))


def _stay(numbers: set[int]) -> None:
    for thread in _threads():
        os.sched_setaffinity(thread, numbers)


def _lock() -> None:
    if _LIBC.mlockall(_MCL_CURRENT | _MCL_FUTURE):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
