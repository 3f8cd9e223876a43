"""Long recordings drawn with few points: least and greatest of every stretch, so that no spike is lost."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_tools.report.columns import Floats

POINTS = 1000  # of a line; a page is about as many pixels wide
GAP = 0.25  # silence that a line does not bridge [s], unless samples are that rare


def extremes(time: Floats, value: Any, points: int = POINTS) -> tuple[Floats, Floats]:
    """At most about `points` of a series, in its order, with the extremes of every stretch; NaN in its gaps."""
    value = np.asarray(value, dtype=float)
    keep = np.isfinite(time) & np.isfinite(value)
    time, value = time[keep], value[keep]
    if len(time) > points:
        stretches, starts = _stretches(value, points // 2)
        picked = np.concatenate([starts + stretches.argmin(axis=1), starts + stretches.argmax(axis=1)])
        index = np.unique(np.minimum(np.append(picked, [0, len(value) - 1]), len(value) - 1))
    else:
        index = np.arange(len(time))
    return _broken(time, index, time[index], value[index])


def envelope(time: Floats, low: Any, high: Any, points: int = POINTS // 2) -> tuple[Floats, Floats, Floats]:
    """Least of `low` and greatest of `high` in at most about `points` stretches; NaN in the gaps."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    keep = np.isfinite(time) & np.isfinite(low) & np.isfinite(high)
    time, low, high = time[keep], low[keep], high[keep]
    if len(time) <= points:
        index = np.arange(len(time))
        return _broken(time, index, time, low, high)
    lows, starts = _stretches(low, points)
    highs, _ = _stretches(high, points)
    return _broken(time, starts, time[starts], lows.min(axis=1), highs.max(axis=1))


def cloud(x: Any, y: Any, bins: int = 150) -> tuple[Floats, Floats]:
    """Points of y against x: the least and the greatest y of every slice of x."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = np.isfinite(x) & np.isfinite(y)
    x, y = x[keep], y[keep]
    if len(x) <= 2 * bins or x.max() == x.min():
        return x, y
    slices = np.minimum(((x - x.min()) / (x.max() - x.min()) * bins).astype(int), bins - 1)
    order = np.lexsort((y, slices))
    firsts = np.flatnonzero(np.diff(slices[order], prepend=-1))
    picked = np.unique(np.concatenate([order[firsts], order[np.append(firsts[1:], len(order)) - 1]]))
    return x[picked], y[picked]


def _stretches(value: Floats, count: int) -> tuple[Floats, NDArray[np.intp]]:
    """`value` as rows of equal length (the last filled up with its last value) and where each begins."""
    length = -(-len(value) // count)
    rows = -(-len(value) // length)
    filled = np.pad(value, (0, rows * length - len(value)), mode="edge")
    return filled.reshape(rows, length), np.arange(rows) * length


def _broken(time: Floats, index: NDArray[np.intp], *columns: Floats) -> Any:
    """The columns with a NaN wherever `time` has a gap between two of the picked points."""
    if len(time) < 2:
        return columns
    steps = np.diff(time)
    limit = max(GAP, 10.0 * float(np.median(np.abs(steps))))
    gaps = np.concatenate([[0], np.cumsum(np.abs(steps) > limit)])[index]
    at = np.flatnonzero(np.diff(gaps)) + 1
    return tuple(np.insert(column, at, np.nan) for column in columns)
