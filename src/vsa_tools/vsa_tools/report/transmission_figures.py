# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of one transmission over time: motion (Fig. 7), impedance (Fig. 8), coefficients (Table I)."""

from typing import Any

import numpy as np
from vsa_common.figures import MEASURED, SIDES, TRUTH, limits
from vsa_tools.report.columns import Series
from vsa_tools.report.data import Joint, Transmission
from vsa_tools.report.panels import Panel, Plot, force_rate, interval, stacked
from vsa_tools.report.truth import Truth, Truths


def figure_motion(side: Transmission, truth: Truth | None, color: str, duration: float) -> Any:
    """Fig. 7: force, force rate, position, residual, velocity and acceleration."""
    plots: list[Plot] = []
    force = side.force or side.impedance
    if force is not None:
        time, values = force.time, force["force"]
        plots.append(lambda axes: Panel(axes, "force [N]").line(time, values, color))
        plots.append(lambda axes: Panel(axes, "force rate [N/s]").line(time, force_rate(time, values), color))
    if side.encoder is not None or side.impedance is not None:
        plots.append(lambda axes: _position(axes, side, color))
    if side.impedance is not None:
        if side.encoder is not None:
            plots.append(lambda axes: _residual(axes, side, color))
        plots.append(_quantity(side.impedance, "velocity", "velocity [mm/s]", 1e3, truth, color))
        plots.append(_quantity(side.impedance, "acceleration", "acceleration [mm/s²]", 1e3, truth, color))
    return stacked(plots, duration)


def figure_impedance(side: Transmission, truth: Truth | None, color: str, duration: float) -> Any:
    """Fig. 8: stiffness, damping and mass."""
    series = side.impedance
    assert series is not None
    plots = [
        _quantity(series, "stiffness", "stiffness [N/mm]", 1e-3, truth, color),
        _quantity(series, "damping", "damping [N s/mm]", 1e-3, truth, color),
        _quantity(series, "inertia", "mass [kg]", 1.0, truth, color),
    ]
    return stacked(plots, duration, height=2.1)


def figure_coefficients(joint: Joint, truth: Truths, duration: float) -> Any:
    """Table I over time: k2, d2 and m of every transmission."""
    plots: list[Plot] = []
    for name, label, scale in (("k2", "k2 [1/mm]", 1e-3), ("d2", "d2 [N s³/mm³]", 1e-9), ("inertia", "m [kg]", 1.0)):
        for i, side in enumerate(joint.transmissions):
            if side.state is not None:
                side_truth = truth.get((joint.name, side.name))
                true = side_truth.coefficients.get(name, np.nan) if side_truth else np.nan
                text = label.replace(" [", f" of {side.name[-1]} [")
                estimate = _quantity(side.state, name, text, scale, None, SIDES[i % len(SIDES)])
                plots.append(_with_level(estimate, scale * true))
    return stacked(plots, duration, height=1.45)


def _position(axes: Any, side: Transmission, color: str) -> None:
    panel = Panel(axes, "position [mm]")
    if side.encoder is not None:
        panel.line(side.encoder.time, 1e3 * side.encoder["position"], MEASURED, "measured", width=2.4)
    if side.impedance is not None:
        panel.line(side.impedance.time, 1e3 * side.impedance["deflection"], color, "estimated")
    panel.legend()


def _residual(axes: Any, side: Transmission, color: str) -> None:
    """Measured minus estimated position of the same stamp [µm]."""
    assert side.encoder
    assert side.impedance
    _, of_encoder, of_estimate = np.intersect1d(side.encoder.stamp_ns, side.impedance.stamp_ns, return_indices=True)
    residual = side.encoder["position"][of_encoder] - side.impedance["deflection"][of_estimate]
    Panel(axes, "residual [µm]").line(side.impedance.time[of_estimate], 1e6 * residual, color)


def _quantity(series: Series, name: str, label: str, scale: float, truth: Truth | None, color: str) -> Plot:
    """An estimate with its band of 2 standard deviations, its validity and its truth; `scale` from SI to the label."""

    def draw(axes: Any) -> None:
        panel = Panel(axes, label)
        value, std = scale * series[name], scale * series.std(name)
        panel.band(series.time, *interval(name, value, std), color)
        panel.line(series.time, value, color, "estimated" if truth else "")
        shown = [value[series.valid(name)] if series.valid(name).any() else value]
        if truth is not None:
            shown.append(scale * truth.columns[name])
            panel.line(truth.time, shown[-1], TRUTH, "truth", style="--")
            panel.legend()
        panel.invalid(series.time, ~series.valid(name))
        panel.fit(*shown)

    return draw


def _with_level(plot: Plot, level: float) -> Plot:
    """`plot` and a dashed horizontal line at `level`, within the axes; no line for NaN."""

    def draw(axes: Any) -> None:
        plot(axes)
        if np.isfinite(level):
            axes.axhline(level, color=TRUTH, linestyle="--", linewidth=0.9)
            low, high = axes.get_ylim()
            if not low < level < high:
                limits(axes, (low, high, level))

    return draw
