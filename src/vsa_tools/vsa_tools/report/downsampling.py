# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Downsampling for plots: minimum and maximum of every interval, so that every spike remains."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_tools.report.columns import Floats

POINTS = 1000  # of a line [1]: the width of a page in pixels
GAP_S = 0.25  # a longer gap interrupts a line [s]: visible in the plot; 10 sample periods at low rates


def extremes(time: Floats, value: Any, points: int = POINTS) -> tuple[Floats, Floats]:
    """About `points` points of a series, in its order: minimum and maximum of every interval; NaN in gaps."""
    value = np.asarray(value, dtype=float)
    keep = np.isfinite(time) & np.isfinite(value)
    time, value = time[keep], value[keep]
    if len(time) > points:
        intervals, starts = _intervals(value, points // 2)
        picked = np.concatenate([starts + intervals.argmin(axis=1), starts + intervals.argmax(axis=1)])
        index = np.unique(np.minimum(np.append(picked, [0, len(value) - 1]), len(value) - 1))
    else:
        index = np.arange(len(time))
    return _with_gaps(time, index, time[index], value[index])


def envelope(time: Floats, low: Any, high: Any, points: int = POINTS // 2) -> tuple[Floats, Floats, Floats]:
    """Minimum of `low` and maximum of `high` in about `points` intervals; NaN in gaps."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    keep = np.isfinite(time) & np.isfinite(low) & np.isfinite(high)
    time, low, high = time[keep], low[keep], high[keep]
    if len(time) <= points:
        index = np.arange(len(time))
        return _with_gaps(time, index, time, low, high)
    lows, starts = _intervals(low, points)
    highs, _ = _intervals(high, points)
    return _with_gaps(time, starts, time[starts], lows.min(axis=1), highs.max(axis=1))


def cloud(x: Any, y: Any, bins: int = 150) -> tuple[Floats, Floats]:
    """Points of y against x: minimum and maximum of y in every bin of x."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = np.isfinite(x) & np.isfinite(y)
    x, y = x[keep], y[keep]
    if len(x) <= 2 * bins or x.max() == x.min():
        return x, y
    bin_of = np.minimum(((x - x.min()) / (x.max() - x.min()) * bins).astype(int), bins - 1)
    order = np.lexsort((y, bin_of))
    firsts = np.flatnonzero(np.diff(bin_of[order], prepend=-1))
    picked = np.unique(np.concatenate([order[firsts], order[np.append(firsts[1:], len(order)) - 1]]))
    return x[picked], y[picked]


def _intervals(value: Floats, count: int) -> tuple[Floats, NDArray[np.intp]]:
    """`value` as rows of equal length (the last one padded with its last value), and the index where each begins."""
    length = -(-len(value) // count)
    rows = -(-len(value) // length)
    filled = np.pad(value, (0, rows * length - len(value)), mode="edge")
    return filled.reshape(rows, length), np.arange(rows) * length


def _with_gaps(time: Floats, index: NDArray[np.intp], *columns: Floats) -> Any:
    """The columns with a NaN where `time` has a gap between two selected points."""
    if len(time) < 2:
        return columns
    steps = np.diff(time)
    limit = max(GAP_S, 10.0 * float(np.median(np.abs(steps))))
    gaps = np.concatenate([[0], np.cumsum(np.abs(steps) > limit)])[index]
    at = np.flatnonzero(np.diff(gaps)) + 1
    return tuple(np.insert(column, at, np.nan) for column in columns)
