# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elements of the report's figures: panels over time, and the force rate of section VI."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from vsa_common.figures import band, limits, stack
from vsa_estimator.force_rate.rate_filter import RateFilter
from vsa_tools.report.columns import Floats
from vsa_tools.report.downsampling import envelope, extremes

Plot = Callable[[Any], None]  # draws one panel into its axes


class Panel:
    """One panel over time, downsampled."""

    def __init__(self, axes: Any, label: str) -> None:
        self._axes = axes
        axes.set_ylabel(label)

    def line(self, time: Floats, value: Any, color: str, label: str = "", style: str = "-", width: float = 1.1) -> None:
        """A series; `label` for the legend."""
        x, y = extremes(time, value)
        self._axes.plot(x, y, style, color=color, linewidth=width, label=label or None)

    def band(self, time: Floats, low: Any, high: Any, color: str) -> None:
        """An interval around a series."""
        band(self._axes, *envelope(time, low, high), color)

    def invalid(self, time: Floats, flag: Any) -> None:
        """Grey background where `flag` is set, also for one sample."""
        x, _, flagged = envelope(time, np.zeros(len(time)), np.asarray(flag, dtype=float))
        if len(x) > 1 and np.nanmax(flagged, initial=0.0) > 0.0:
            across = self._axes.get_xaxis_transform()
            self._axes.fill_between(
                x,
                0.0,
                1.0,
                where=flagged > 0.5,
                step="post",
                transform=across,
                color="#ececec",
                linewidth=0.0,
                zorder=-2,
            )

    def strip(self, time: Floats, flag: Any, row: int, color: str, label: str) -> None:
        """A bar in row `row` where `flag` is set."""
        x, _, flagged = envelope(time, np.zeros(len(time)), np.asarray(flag, dtype=float))
        self._axes.fill_between(
            x, row - 0.35, row + 0.35, where=flagged > 0.5, step="post", color=color, linewidth=0.0, label=label or None
        )

    def fit(self, *values: Any) -> None:
        """Scale the y axis to these values alone."""
        limits(self._axes, *values)

    def legend(self) -> None:
        """Legend of the labelled lines."""
        if self._axes.get_legend_handles_labels()[1]:
            self._axes.legend(loc="upper right", ncols=3, frameon=True, framealpha=0.8, edgecolor="none", borderpad=0.2)


def stacked(plots: Sequence[Plot], duration: float, height: float = 1.5) -> Any:
    """A figure of `plots` above each other with a common time axis of `duration` [s]; `height` of each in inches."""
    figure, all_axes = stack(len(plots), height=height, duration=duration)
    for axes, plot in zip(all_axes, plots, strict=True):
        plot(axes)
    return figure


def interval(name: str, value: Floats, std: Floats, deviations: float = 2.0) -> tuple[Floats, Floats]:
    """Limits of the interval of `deviations` standard deviations; of stiffness it is symmetric in the logarithm."""
    if name != "stiffness":
        return value - deviations * std, value + deviations * std
    spread = np.exp(np.minimum(deviations * std / np.maximum(value, 1e-12), 50.0))
    return value / spread, value * spread


def force_rate(time: Floats, force: Floats) -> Floats:
    """Force rate [N/s] by a first-order filter, as in Fig. 7 of the paper; NaN where the time does not advance."""
    rate, rate_filter, before = np.full(len(time), np.nan), RateFilter(), np.nan
    for k, (now, value) in enumerate(zip(time.tolist(), force.tolist(), strict=True)):
        if not np.isfinite(value):
            continue
        if now > before:
            rate[k] = rate_filter.add(value, now - before)
        elif not now >= before:  # the first sample, or the stamps restart
            rate_filter = RateFilter()
            rate_filter.add(value, 0.0)
        before = now
    return rate
