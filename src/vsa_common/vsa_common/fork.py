"""Works at once: each in a copy of this process, which has all that this one has and need not be sent it.

All but its threads: a work must not touch polars, whose own would be waited for without end.
"""

import multiprocessing
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection, wait
from typing import Generic, TypeVar

Result = TypeVar("Result")
ReportProgress = Callable[[float], None]  # so many steps are done


class ForkedTasks(Generic[Result]):
    """Works under way. Each is given a function to tell its steps with; what it returns must be picklable."""

    def __init__(self, *works: Callable[[ReportProgress], Result]) -> None:
        """Start them."""
        fork = multiprocessing.get_context("fork")
        self._readers: list[Connection] = []
        for work in works:
            reader, writer = fork.Pipe(duplex=False)
            fork.Process(target=_run, args=(work, writer), daemon=True).start()
            writer.close()
            self._readers.append(reader)

    def results(self, tell: ReportProgress = lambda steps: None) -> Sequence[Result]:
        """What each returned, in order; steps go to `tell`. Raises what a work raised, OSError for one that died."""
        found: dict[Connection, Result] = {}
        while waiting := [reader for reader in self._readers if reader not in found]:
            for reader in wait(waiting):
                assert isinstance(reader, Connection)
                try:
                    kind, value = reader.recv()
                except EOFError:
                    raise OSError("a copy of this process ended without a word") from None
                if kind == "failed":
                    raise value
                if kind == "done":
                    found[reader] = value
                else:
                    tell(value)
        return [found[reader] for reader in self._readers]


def _run(work: Callable[[ReportProgress], Result], writer: Connection) -> None:
    try:
        writer.send(("done", work(lambda steps: writer.send(("steps", steps)))))
    except Exception as error:  # whatever it is, it is for the process that waits
        writer.send(("failed", error))
