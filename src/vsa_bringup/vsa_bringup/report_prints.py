"""Work beside the work: copies of this process that draw while it goes on."""

import multiprocessing
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection


@contextmanager
def beside(*works: Callable[[], None]) -> Iterator[None]:
    """Run each work in a copy of this process while the block runs. Raises OSError where one of them failed."""
    copies = multiprocessing.get_context("fork")  # the figures are there already and need not be sent
    running = []
    for work in works:
        reader, writer = copies.Pipe(duplex=False)
        process = copies.Process(target=_run, args=(work, writer), daemon=True)
        process.start()
        writer.close()
        running.append((process, reader))
    yield
    for process, reader in running:
        try:
            reason = reader.recv()
        except EOFError:
            reason = "ended without a word"
        process.join()
        if reason:
            raise OSError(reason)


def _run(work: Callable[[], None], writer: Connection) -> None:
    try:
        work()
    except OSError as error:
        writer.send(str(error))
    else:
        writer.send("")
