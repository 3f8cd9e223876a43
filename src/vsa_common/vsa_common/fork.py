# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parallel tasks in forked processes, which inherit the memory of this one; only results are transferred.

A forked process is killed at the end of the one that started it.

Threads are not inherited: a task must not use polars, whose thread pool would block without end.
"""

import contextlib
import ctypes
import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from functools import partial
from multiprocessing.connection import Connection, wait
from typing import Generic, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
_PR_SET_PDEATHSIG = 1
ReportProgress = Callable[[float], None]  # argument: number of steps done


def killed_with(parent: int) -> None:
    """Request SIGKILL for this process at the end of the thread of `parent` that started it, whatever ends that."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # the parent ended before the request
        os._exit(1)


class ForkedTasks(Generic[Result]):
    """Tasks in progress. Each gets a function to report its steps with; its result must be picklable."""

    def __init__(self, *tasks: Callable[[ReportProgress], Result]) -> None:
        """Start the tasks."""
        fork = multiprocessing.get_context("fork")
        self._readers: list[Connection] = []
        for task in tasks:
            reader, writer = fork.Pipe(duplex=False)
            arguments = (task, writer, [*self._readers, reader], os.getpid())
            fork.Process(target=_run, args=arguments, daemon=True).start()
            writer.close()
            self._readers.append(reader)

    def results(self, report: ReportProgress = lambda steps: None) -> Sequence[Result]:
        """Results in the order of the tasks; steps are passed to `report`.

        Raises the exception of a task that failed, OSError for a process that ended without a result.
        """
        found: dict[Connection, Result] = {}
        while waiting := [reader for reader in self._readers if reader not in found]:
            for reader in wait(waiting):
                assert isinstance(reader, Connection)
                try:
                    kind, value = reader.recv()
                except EOFError:
                    raise OSError("a forked process ended without a result") from None
                if kind == "failed":
                    raise value
                if kind == "done":
                    found[reader] = value
                else:
                    report(value)
        return [found[reader] for reader in self._readers]


def forked_map(
    function: Callable[[Item], Result], items: Sequence[Item], workers: int, report: ReportProgress
) -> list[Result]:
    """`function` of each item, in their order, by up to `workers` processes; a step is reported for each.

    Item k is computed by process k % workers. Raises what `ForkedTasks.results` raises.
    """
    parts = [items[first::workers] for first in range(min(workers, len(items)))]
    by_part = ForkedTasks(*(partial(_map_part, function, part) for part in parts)).results(report)
    return [by_part[k % len(parts)][k // len(parts)] for k in range(len(items))]


def _map_part(function: Callable[[Item], Result], items: Sequence[Item], report: ReportProgress) -> list[Result]:
    results = []
    for one in items:
        results.append(function(one))
        report(1)
    return results


def _run(
    task: Callable[[ReportProgress], Result], writer: Connection, readers: Sequence[Connection], parent: int
) -> None:
    killed_with(parent)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C is reported by the parent alone
    for reader in readers:  # only the parent reads: without it a send fails in place of waiting for ever
        reader.close()
    try:
        writer.send(("done", task(lambda steps: writer.send(("steps", steps)))))
    except Exception as error:  # raised again by `results` in the parent
        with contextlib.suppress(BrokenPipeError):  # the parent reads no more
            writer.send(("failed", error))
