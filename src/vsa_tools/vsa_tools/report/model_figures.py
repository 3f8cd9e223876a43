# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of the identified model: laws of stiffness and damping (Fig. 9), Allan variance of innovations (Fig. 6)."""

from typing import Any

import numpy as np
from vsa_common.figures import MEASURED, SIDES, TRUTH, panels
from vsa_common.types import Status
from vsa_estimator.offline.allan import allan
from vsa_tools.report.columns import Floats, Series
from vsa_tools.report.data import Joint, Transmission
from vsa_tools.report.downsampling import cloud
from vsa_tools.report.truth import Truths

SETTLING_FRACTION = 0.3  # of the run [1], excluded from the Allan variance: the estimates converge
MIN_SAMPLES = 32  # innovations for an Allan variance [1]: five octaves of averaging time


def figure_laws(joint: Joint, truth: Truths) -> Any:
    """Fig. 9: stiffness over position and damping over velocity, one row for each transmission with an impedance."""
    sides = [side for side in joint.transmissions if side.impedance]
    figure, rows = panels(len(sides), 2, height=2.7 * len(sides) + 0.3)
    for row, side, color in zip(np.atleast_2d(rows), sides, SIDES, strict=False):
        _law(row[0], side, "deflection", "stiffness", ("position [mm]", "stiffness [N/mm]"), color)
        _law(row[1], side, "velocity", "damping", ("velocity [mm/s]", "damping [N s/mm]"), color)
        row[0].set_title(side.name)
        side_truth = truth.get((joint.name, side.name))
        if side_truth is not None:
            for axes, across, up in ((row[0], "deflection", "stiffness"), (row[1], "velocity", "damping")):
                x, y = cloud(1e3 * side_truth.columns[across], 1e-3 * side_truth.columns[up])
                order = np.argsort(x)
                axes.plot(x[order], y[order], "--", color=TRUTH, linewidth=0.9, label="truth")
        row[0].legend()
    return figure


def _law(axes: Any, side: Transmission, across: str, up: str, labels: tuple[str, str], color: str) -> None:
    series, state = side.impedance, side.state
    assert series is not None
    usable = series.valid(up) & series.valid(across)
    x, y = cloud(1e3 * series[across][usable], 1e-3 * series[up][usable])
    axes.plot(x, y, ".", color=color, markersize=2.5, label="estimated")
    axes.set(xlabel=labels[0], ylabel=labels[1])
    if state is not None and len(x) > 1 and state.valid("k2" if up == "stiffness" else "d2")[-1]:
        along = np.linspace(1e-3 * x.min(), 1e-3 * x.max(), 200)
        axes.plot(1e3 * along, 1e-3 * _LAWS[up](state, along), color=MEASURED, linewidth=1.0, label="law at the end")


def _stiffness_law(state: Series, deflection: Floats) -> Floats:
    k2, reference = state["k2"][-1], state["deflection_reference"][-1]
    return np.exp(state["ln_stiffness_reference"][-1] + k2 * (deflection - reference))


def _damping_law(state: Series, velocity: Floats) -> Floats:
    d1, d2 = state["d1"][-1], state["d2"][-1]
    return np.maximum(d1 + 3.0 * d2 * velocity**2, 0.0)


_LAWS = {"stiffness": _stiffness_law, "damping": _damping_law}


def figure_allan(joint: Joint) -> Any:
    """Fig. 6: Allan variance of the innovations over the last 70 % of the run."""
    figure, (left, right) = panels(1, 2, height=2.9)
    for axes, name, unit in ((left, "force_innovation", "N²"), (right, "deflection_innovation", "m²")):
        axes.set_title(name.replace("_", " "))
        axes.set(xlabel="averaging time [s]", ylabel=f"Allan variance [{unit}]", xscale="log", yscale="log")
        for side, color in zip(joint.transmissions, SIDES, strict=False):
            if side.state is not None:
                _draw_allan(axes, side.state, name, side.name, color)
        if axes.get_legend_handles_labels()[1]:
            axes.legend()
    return figure


def _draw_allan(axes: Any, state: Series, name: str, label: str, color: str) -> None:
    time = state.time
    # With any other status the message repeats the last innovation.
    updated = np.isin(state["status"], (Status.VALID, Status.DEGRADED))
    settled = (time > SETTLING_FRACTION * np.nanmax(time, initial=0.0)) & updated & np.isfinite(state[name])
    if np.count_nonzero(settled) < MIN_SAMPLES:
        return
    found = allan(state[name][settled], 1.0 / float(np.median(np.diff(time[settled]))))
    variance = found.deviation**2
    axes.plot(found.tau, variance, "o-", color=color, markersize=3, label=f"{label}: {found.classification}")
    axes.plot(found.tau, variance[0] * found.tau[0] / found.tau, "--", color=MEASURED, linewidth=0.8)
