# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of the joint: its impedance, and the health of the run."""

from typing import Any

import numpy as np
from vsa_common.figures import JOINT, MEASURED, SIDES, TRUTH
from vsa_common.types import Status
from vsa_tools.report.columns import Series
from vsa_tools.report.data import Joint
from vsa_tools.report.panels import Panel, Plot, interval, stacked
from vsa_tools.report.tables import delay

_STATUS_COLORS = {
    Status.INITIALIZING: "#d0d0d0",
    Status.CONVERGING: "#8ec1e8",
    Status.VALID: "#3aa17e",
    Status.DEGRADED: "#e8b23a",
    Status.STALE: "#b48ac9",
    Status.FAULT: "#c8372d",
    Status.MODEL_INADEQUATE: "#d98f66",
}


def figure_joint(joint: Joint, duration: float) -> Any:
    """Stiffness, damping, inertia, tensions; angle and external torque if recorded."""
    series = joint.impedance
    assert series is not None
    plots: list[Plot] = [
        lambda axes: _banded(axes, series, "stiffness", "K [N m/rad]"),
        lambda axes: _banded(axes, series, "damping", "D [N m s/rad]"),
        lambda axes: _banded(axes, series, "inertia", "J [kg m²]"),
        lambda axes: _tensions(axes, series),
    ]
    if joint.angle is not None:
        angle = joint.angle
        plots.append(lambda axes: Panel(axes, "angle [rad]").line(angle.time, angle["position"], JOINT))
    if joint.torque is not None:
        torque = joint.torque
        plots.append(lambda axes: Panel(axes, "torque [N m]").line(torque.time, torque["torque"], JOINT))
    return stacked(plots, duration)


def _banded(axes: Any, series: Series, name: str, label: str) -> None:
    panel = Panel(axes, label)
    value, std, valid = series[name], series.std(name), series.valid(name)
    panel.band(series.time, *interval(name, value, std), JOINT)
    panel.line(series.time, value, JOINT)
    panel.invalid(series.time, ~valid)
    panel.fit(value[valid] if valid.any() else value)


def _tensions(axes: Any, series: Series) -> None:
    panel = Panel(axes, "tension [N]")
    for i, color in enumerate(SIDES, 1):
        panel.line(series.time, series[f"tension_{i}"], color, f"tendon {i}")
    panel.line(series.time, series["co_contraction"], TRUTH, "co-contraction", style=":")
    panel.legend()


def figure_health(joint: Joint, duration: float) -> Any:
    """Status of every estimate, delay to the recorder, normalised innovation squared."""
    estimates = [(side.name, side.impedance) for side in joint.transmissions if side.impedance]
    if joint.impedance is not None:
        estimates.append(("joint", joint.impedance))
    late = [(name, one) for name, one in estimates if len(delay(one))]
    states = [(side.name, side.state) for side in joint.transmissions if side.state]
    plots: list[Plot] = []
    if estimates:
        plots.append(lambda axes: _strips(axes, estimates))
    if late:
        plots.append(lambda axes: _delays(axes, late))
    if states:
        plots.append(lambda axes: _innovations(axes, states))
    if not plots:
        plots.append(lambda axes: _rates(axes, joint))
    return stacked(plots, duration, height=1.6)


def _strips(axes: Any, estimates: list[tuple[str, Series]]) -> None:
    axes.grid(False)
    seen: set[Status] = set()
    for row, (_, series) in enumerate(reversed(estimates)):
        for status in Status:
            samples = series["status"] == status
            if samples.any():
                label = "" if status in seen else status.name
                Panel(axes, "").strip(series.time, samples, row, _STATUS_COLORS[status], label)
                seen.add(status)
    axes.set_yticks(
        range(len(estimates)), [name.replace("transmission_", "trans. ") for name, _ in reversed(estimates)]
    )
    axes.set_ylim(-0.6, len(estimates) - 0.1)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=6)


def _delays(axes: Any, late: list[tuple[str, Series]]) -> None:
    panel = Panel(axes, "delay [ms]")
    for (name, series), color in zip(late, (*SIDES, JOINT), strict=False):
        panel.line(series.time, 1e3 * delay(series), JOINT if name == "joint" else color, name)
    axes.set_yscale("log")
    panel.legend()


def _innovations(axes: Any, states: list[tuple[str, Series]]) -> None:
    panel = Panel(axes, "NIS of force")
    for (name, state), color in zip(states, SIDES, strict=False):
        panel.line(state.time, np.maximum(state["normalised_innovation_squared"], 1e-3), color, name)
    axes.axhline(1.0, color=MEASURED, linestyle="--", linewidth=0.8)
    axes.set_yscale("log")
    panel.legend()


def _rates(axes: Any, joint: Joint) -> None:
    """Sample steps, for a recording of sensors alone."""
    panel = Panel(axes, "sample step [ms]")
    for side, color in zip(joint.transmissions, SIDES, strict=False):
        series = side.force or side.encoder
        if series is not None and len(series) > 1:
            panel.line(series.time[1:], np.diff(series.stamp_ns) * 1e-6, color, side.name)
    panel.legend()
