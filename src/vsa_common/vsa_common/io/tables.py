# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""CSV files as numpy arrays, read and written by polars."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

Columns = dict[str, NDArray[np.float64]]


class TableError(ValueError):
    """A CSV file cannot be used; one line that names the file, the line and the expected content."""


def read_columns(path: str | Path, names: Sequence[str], optional: Sequence[str] = (), *, cut: bool = False) -> Columns:
    """The columns `names` of a CSV file with a header, and those of `optional` that exist.

    An empty cell is NaN: a missing sample. With `cut` the file may end within a line, which is not read.
    Raises TableError if the file cannot be read, lacks a column, has no row, or contains a cell that is not a number.
    """
    text = _read_text(path, cut)
    missing = [name for name in names if name not in text.columns]
    if missing:
        found = " ".join(", ".join(text.columns).split()) or "nothing"
        raise TableError(f"{path}: line 1: expected the columns {', '.join(names)}; found {found}")
    if text.height == 0:
        raise TableError(f"{path}: line 2: expected a row of numbers, found the end of the file")
    wanted = [*names, *(name for name in optional if name in text.columns)]
    return {name: _numbers(path, text[name]) for name in wanted}


def write_columns(path: str | Path, columns: Mapping[str, Any]) -> None:
    """Write arrays of equal length as the columns of a CSV file; booleans as 0 or 1, strings as they are.

    Raises TableError where the file cannot be written.
    """
    arrays = {name: np.asarray(column) for name, column in columns.items()}
    flags_as_numbers = {
        name: array.astype(np.int64) if array.dtype == np.bool_ else array for name, array in arrays.items()
    }
    try:
        pl.DataFrame(flags_as_numbers).write_csv(path)
    except OSError as error:
        raise TableError(f"cannot write {path}: {error.strerror or error}") from error


def _read_text(path: str | Path, cut: bool) -> pl.DataFrame:
    try:
        return pl.read_csv(_complete_lines(path) if cut else path, infer_schema=False)
    except OSError as error:
        raise TableError(f"cannot read {path}: {error.strerror or error}") from error
    except pl.exceptions.NoDataError as error:
        raise TableError(f"{path}: line 1: expected a header with column names, found an empty file") from error
    except pl.exceptions.PolarsError as error:
        raise TableError(_locate(path, error)) from error


def _complete_lines(path: str | Path) -> bytes:
    content = Path(path).read_bytes()
    return content[: content.rfind(b"\n") + 1]


def _locate(path: str | Path, error: Exception) -> str:
    """Error text: the first line that is not UTF-8 or has more fields than the header."""
    fields = 0
    for number, line in enumerate(Path(path).read_bytes().splitlines(), 1):
        try:
            cells = line.decode().count(",") + 1
        except UnicodeDecodeError:
            return f"{path}: line {number}: expected UTF-8 text"
        fields = fields or cells
        if cells > fields:
            return f"{path}: line {number}: expected {fields} fields, found {cells}"
    return f"{path}: expected a CSV file: {' '.join(str(error).split())}"


def _numbers(path: str | Path, cells: pl.Series) -> NDArray[np.float64]:
    stripped = cells.str.strip_chars()
    numbers = stripped.cast(pl.Float64, strict=False)
    wrong = (numbers.is_null() & (stripped.fill_null("") != "")).arg_true()
    if len(wrong):
        row = int(wrong[0])
        raise TableError(f"{path}: line {row + 2}: expected a number in column {cells.name}, found {cells[row]!r}")
    return numbers.fill_null(float("nan")).to_numpy().copy()
