"""The figures of a report, named after the paper's."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from vsa_common.figures import MEASURED, SIDES, TRUTH, panels, set_title, stack
from vsa_common.types import Status
from vsa_estimator.offline.allan import allan
from vsa_tools.report.columns import Floats, Series
from vsa_tools.report.data import Joint, Run, Side
from vsa_tools.report.downsampling import cloud
from vsa_tools.report.joint_figures import figure_health, figure_joint
from vsa_tools.report.panels import Panel, force_rate
from vsa_tools.report.truth import Truth, Truths


@dataclass(frozen=True)
class Plate:
    """One figure with the name of its files and what to say below it."""

    name: str
    title: str
    caption: str
    figure: Any


def plates(run: Run, truth: Truths) -> Iterator[Plate]:
    """Every figure that the recording has something for, joint by joint."""
    for joint in run.joints:
        several = len(run.joints) > 1
        mark = f"{joint.name.strip('/').replace('/', '_')}_" if several else ""
        for name, title, caption, figure in _figures(joint, run.duration, truth):
            set_title(figure, title + (f" ({joint.name})" if several else ""))
            yield Plate(mark + name, title, caption, figure)


def _figures(joint: Joint, duration: float, truth: Truths) -> Iterator[tuple[str, str, str, Any]]:
    for side, color in zip(joint.sides, SIDES, strict=False):
        known = truth.get((joint.name, side.name))
        if side.force or side.impedance or side.encoder:
            motion = _motion(side, known, color, duration)
            yield f"fig7_{side.name}", f"Fig. 7: motion of {side.name}", _CAPTION_7, motion
        if side.impedance:
            impedance = _impedance(side, known, color, duration)
            yield f"fig8_{side.name}", f"Fig. 8: impedance of {side.name}", _CAPTION_8, impedance
    moving = [side for side in joint.sides if side.impedance]
    if moving:
        laws = _laws(joint, moving, truth)
        yield "fig9", "Fig. 9: stiffness against position, damping against velocity", _CAPTION_9, laws
    if any(side.state for side in joint.sides):
        yield "table1", "Table I: coefficients on their way", _CAPTION_T, _coefficients(joint, truth, duration)
        yield "fig6", "Fig. 6: Allan variance of what the model leaves unexplained", _CAPTION_6, _allan(joint)
    if joint.impedance:
        yield "joint", "Joint: impedance, (10) to (13)", _CAPTION_J, figure_joint(joint, duration)
    yield "health", "Health: status, delay, gate", _CAPTION_H, figure_health(joint, duration)


_CAPTION_7 = (
    "Measured force and its rate (first-order filter, 0.19 s as section VI implies), measured and estimated position "
    "with their difference, estimated velocity and acceleration. Bands: 2 standard deviations. Grey ground: not valid."
)
_CAPTION_8 = (
    "Generalised stiffness, damping and inertia, (8), with bands of 2 standard deviations. Grey ground: not valid. "
    "Dashed: the simulated rig's truth, where it is known."
)
_CAPTION_9 = (
    "Dots: estimates while valid, least and greatest in each slice. "
    "Line: the law, (3) and (5), with the coefficients at the end."
)
_CAPTION_T = "k2, d2 and m with bands of 2 standard deviations. Grey ground: not valid."
_CAPTION_6 = (
    "Innovations of force and deflection. White noise has slope -1 (dashed); a curve that leaves it upwards is motion "
    "that the model does not explain. `./vsa noise` gives the sensors' own noise from a recording at rest."
)
_CAPTION_J = "Stiffness, damping and inertia at the joint with 2 sd bands, tendon tensions, angle and torque."
_CAPTION_H = (
    "Status of every estimate over time; delay from the sensor's stamp to the recorder; normalised innovation squared, "
    "which is 1 on average for an honest filter and far above where the gate rejects."
)


def _motion(side: Side, truth: Truth | None, color: str, duration: float) -> Any:
    """Fig. 7."""
    steps: list[Callable[[Any], None]] = []
    force = side.force or side.impedance
    if force is not None:
        time, values = force.time, force["force"]
        steps.append(lambda axes: Panel(axes, "force [N]").line(time, values, color))
        steps.append(lambda axes: Panel(axes, "force rate [N/s]").line(time, force_rate(time, values), color))
    if side.encoder is not None or side.impedance is not None:
        steps.append(lambda axes: _position(axes, side, color))
    if side.impedance is not None:
        if side.encoder is not None:
            steps.append(lambda axes: _residual(axes, side, color))
        steps.append(lambda axes: _quantity(axes, side.impedance, "velocity", "velocity [mm/s]", 1e3, truth, color))
        steps.append(
            lambda axes: _quantity(axes, side.impedance, "acceleration", "acceleration [mm/s²]", 1e3, truth, color)
        )
    return _stack(steps, duration)


def _position(axes: Any, side: Side, color: str) -> None:
    panel = Panel(axes, "position [mm]")
    if side.encoder is not None:
        panel.line(side.encoder.time, 1e3 * side.encoder["position"], MEASURED, "measured", width=2.4)
    if side.impedance is not None:
        panel.line(side.impedance.time, 1e3 * side.impedance["deflection"], color, "estimated")
    panel.legend()


def _residual(axes: Any, side: Side, color: str) -> None:
    """Measured less estimated position of the same stamp, in micrometres."""
    assert side.encoder
    assert side.impedance
    _, of_encoder, of_estimate = np.intersect1d(side.encoder.stamp_ns, side.impedance.stamp_ns, return_indices=True)
    left = side.encoder["position"][of_encoder] - side.impedance["deflection"][of_estimate]
    Panel(axes, "residual [µm]").line(side.impedance.time[of_estimate], 1e6 * left, color)


def _impedance(side: Side, truth: Truth | None, color: str, duration: float) -> Any:
    """Fig. 8."""
    series = side.impedance
    return _stack(
        [
            lambda axes: _quantity(axes, series, "stiffness", "stiffness [N/mm]", 1e-3, truth, color),
            lambda axes: _quantity(axes, series, "damping", "damping [N s/mm]", 1e-3, truth, color),
            lambda axes: _quantity(axes, series, "inertia", "mass [kg]", 1.0, truth, color),
        ],
        duration,
        height=2.1,
    )


def _quantity(
    axes: Any, series: Series | None, name: str, label: str, scale: float, truth: Truth | None, color: str
) -> None:
    """An estimate with its band, its validity and its truth."""
    assert series is not None
    panel = Panel(axes, label)
    value, std = scale * series[name], scale * series.std(name)
    if name == "stiffness":  # its interval holds in the log domain
        spread = np.exp(np.minimum(2.0 * std / np.maximum(value, 1e-12), 50.0))
        panel.band(series.time, value / spread, value * spread, color)
    else:
        panel.band(series.time, value - 2.0 * std, value + 2.0 * std, color)
    panel.line(series.time, value, color, "estimated" if truth else "")
    if truth is not None:
        panel.line(truth.time, scale * truth.columns[name], TRUTH, "truth", style="--")
        panel.legend()
    panel.invalid(series.time, ~series.valid(name))
    panel.fit(value[series.valid(name)] if series.valid(name).any() else value)


def _coefficients(joint: Joint, truth: Truths, duration: float) -> Any:
    """Table I over time."""
    steps: list[Callable[[Any], None]] = []
    for name, label, scale in (("k2", "k2 [1/mm]", 1e-3), ("d2", "d2 [N s³/mm³]", 1e-9), ("inertia", "m [kg]", 1.0)):
        for i, side in enumerate(joint.sides):
            if side.state is not None:
                known = truth.get((joint.name, side.name))
                true = known.coefficients.get(name, np.nan) if known else np.nan
                text = label.replace(" [", f" of {side.name[-1]} [")
                steps.append(_convergence(side.state, name, text, scale, true, SIDES[i % len(SIDES)]))
    return _stack(steps, duration, height=1.45)


def _convergence(state: Series, name: str, label: str, scale: float, true: float, color: str) -> Callable[[Any], None]:
    def draw(axes: Any) -> None:
        _quantity(axes, state, name, label, scale, None, color)
        if np.isfinite(true):
            axes.axhline(scale * true, color=TRUTH, linestyle="--", linewidth=0.9)

    return draw


def _laws(joint: Joint, sides: list[Side], truth: Truths) -> Any:
    """Fig. 9, a row a transmission."""
    figure, rows = panels(len(sides), 2, height=2.7 * len(sides) + 0.3)
    for row, side, color in zip(np.atleast_2d(rows), sides, SIDES, strict=False):
        _law(row[0], side, "deflection", "stiffness", ("position [mm]", "stiffness [N/mm]"), color)
        _law(row[1], side, "velocity", "damping", ("velocity [mm/s]", "damping [N s/mm]"), color)
        row[0].set_title(side.name)
        known = truth.get((joint.name, side.name))
        if known is not None:
            for axes, across, up in ((row[0], "deflection", "stiffness"), (row[1], "velocity", "damping")):
                x, y = cloud(1e3 * known.columns[across], 1e-3 * known.columns[up])
                order = np.argsort(x)
                axes.plot(x[order], y[order], "--", color=TRUTH, linewidth=0.9, label="truth")
        row[0].legend()
    return figure


def _law(axes: Any, side: Side, across: str, up: str, labels: tuple[str, str], color: str) -> None:
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


def _allan(joint: Joint) -> Any:
    """Fig. 6, of the last 70 % of the run."""
    figure, (left, right) = panels(1, 2, height=2.9)
    for axes, name, unit in ((left, "force_innovation", "N²"), (right, "deflection_innovation", "m²")):
        axes.set_title(name.replace("_", " "))
        axes.set(xlabel="averaging time [s]", ylabel=f"Allan variance [{unit}]", xscale="log", yscale="log")
        for side, color in zip(joint.sides, SIDES, strict=False):
            if side.state is not None:
                _draw_allan(axes, side.state, name, side.name, color)
        if axes.get_legend_handles_labels()[1]:
            axes.legend()
    return figure


def _draw_allan(axes: Any, state: Series, name: str, label: str, color: str) -> None:
    time = state.time
    known = np.isin(state["status"], (Status.VALID, Status.DEGRADED))  # others repeat their last innovation
    settled = (time > 0.3 * np.nanmax(time, initial=0.0)) & known & np.isfinite(state[name])
    if np.count_nonzero(settled) < 32:
        return
    found = allan(state[name][settled], 1.0 / float(np.median(np.diff(time[settled]))))
    variance = found.deviation**2
    axes.plot(found.tau, variance, "o-", color=color, markersize=3, label=f"{label}: {found.classification}")
    axes.plot(found.tau, variance[0] * found.tau[0] / found.tau, "--", color=MEASURED, linewidth=0.8)


def _stack(steps: list[Callable[[Any], None]], duration: float, height: float = 1.5) -> Any:
    figure, axes = stack(len(steps), height=height, duration=duration)
    for one, step in zip(axes, steps, strict=True):
        step(one)
    return figure
