# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tables and progress bars on a terminal, drawn by rich."""

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

PIPE_WIDTH = 200  # columns where the output is a file or a pipe


class Bar:
    """A progress bar; no output where stderr is not a terminal."""

    def __init__(self, progress: Progress, total: float | None, text: str) -> None:
        self._progress = progress
        self._task = progress.add_task(text, total=total)

    def advance(self, steps: float = 1.0, text: str | None = None) -> None:
        """Advance by `steps`; `text` replaces the description."""
        self._progress.update(self._task, advance=steps, description=text)


@contextmanager
def progress(total: float | None, text: str, count: bool = False) -> Iterator[Bar]:
    """A bar on stderr while the block runs, no output when stderr is not a terminal; `count`: steps instead of percent.

    `total` None: the number of steps is not defined.
    """
    columns = (MofNCompleteColumn() if count else TaskProgressColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        *columns,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as bars:
        yield Bar(bars, total, text)


def show_table(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], note: str = "", texts: int = 1
) -> None:
    """Print a table to stdout; the first `texts` columns are text, the others are numbers."""
    table = Table(title=title, title_justify="left", caption=note or None, caption_justify="left")
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i < texts else "right", no_wrap=i < texts)
    for row in rows:
        table.add_row(*row)
    console = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH)
    console.print(table)


class Page(NamedTuple):
    """One table of a report; its first `texts` columns are text."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str
    texts: int


def show_pages(pages: Iterable[Page]) -> None:
    """Print tables to the terminal."""
    for page in pages:
        show_table(page.title, page.header, page.rows, page.note, page.texts)


def markdown(pages: Iterable[Page]) -> str:
    """Tables as sections of a document."""
    lines = []
    for page in pages:
        lines += [f"### {page.title[:1].upper()}{page.title[1:]}", "", *([page.note, ""] if page.note else [])]
        lines += [f"| {' | '.join(page.header)} |", "|---" * len(page.header) + "|"]
        lines += [f"| {' | '.join(row)} |" for row in page.rows] + [""]
    return "\n".join(lines)
