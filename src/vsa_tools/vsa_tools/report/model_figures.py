# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of the identified model: laws of stiffness and damping (Fig. 9), residual, Allan variance (Fig. 6)."""

from typing import Any

import numpy as np
from vsa_common.figures import MEASURED, SIDES, TRUTH, band, limits, panels
from vsa_common.types import Status
from vsa_estimator.offline.allan import allan
from vsa_estimator.offline.elastic_law import Z95, KnotLaw
from vsa_tools.report.columns import Floats, Series
from vsa_tools.report.data import Joint, Transmission
from vsa_tools.report.downsampling import cloud
from vsa_tools.report.truth import Truths

SETTLING_FRACTION = 0.3  # of the run [1], excluded from the Allan variance: the estimates converge
MIN_SAMPLES = 32  # innovations for an Allan variance [1]: five octaves of averaging time
BINS = 40  # of deflection and speed, for medians
MIN_BIN_SAMPLES = 5  # samples of a median
STDS = 3.0  # standard deviations of the velocity beyond which its sign is known


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
    if state is None or len(x) < 2:
        return
    along = np.linspace(1e-3 * x.min(), 1e-3 * x.max(), 200)
    law = elastic_law(state) if up == "stiffness" else None
    if law is not None:
        low, high = law.band(along)
        band(axes, 1e3 * along, 1e-3 * low, 1e-3 * high, MEASURED)
        axes.plot(1e3 * along, 1e-3 * law.stiffness(along), color=MEASURED, linewidth=1.0, label="law at the end")
        limits(axes, y)
    elif state.valid("k2" if up == "stiffness" else "d2")[-1]:
        axes.plot(1e3 * along, 1e-3 * _LAWS[up](state, along), color=MEASURED, linewidth=1.0, label="law at the end")


def _stiffness_law(state: Series, deflection: Floats) -> Floats:
    """Law by the coefficients: of a bag whose states have no elastic law."""
    k2, reference = state["k2"][-1], state["deflection_reference"][-1]
    return np.exp(state["ln_stiffness_reference"][-1] + k2 * (deflection - reference))


def _damping_law(state: Series, velocity: Floats) -> Floats:
    d1, d2 = state["d1"][-1], state["d2"][-1]
    return np.maximum(d1 + 3.0 * d2 * velocity**2, 0.0)


_LAWS = {"stiffness": _stiffness_law, "damping": _damping_law}


def elastic_law(state: Series | None) -> KnotLaw | None:
    """The law of the last state in which it was valid; None where there is none, as in a bag of an older version."""
    fields = state.flagged if state is not None else {}
    if len(fields.get("elastic_deflection", ())) < 2:
        return None
    knots, ln_stiffness = (np.array(fields[f"elastic_{name}"]) for name in ("deflection", "ln_stiffness"))
    covariance = np.reshape(fields["elastic_ln_stiffness_covariance"], (len(knots), len(knots)))
    return KnotLaw(knots, ln_stiffness, covariance, float(fields["elastic_force"]))


def figure_elastic_law(joint: Joint) -> Any | None:
    """One row for each transmission with an elastic law: force over deflection, residual over deflection and speed."""
    pairs = ((side, color, elastic_law(side.state)) for side, color in zip(joint.transmissions, SIDES, strict=False))
    sides = [(side, color, law) for side, color, law in pairs if law is not None and side.impedance is not None]
    if not sides:
        return None
    figure, rows = panels(len(sides), 3, height=2.6 * len(sides) + 0.3)
    for row, (side, color, law) in zip(np.atleast_2d(rows), sides, strict=True):
        _draw(row, side, law, color)
    return figure


def residual(side: Transmission, law: KnotLaw) -> tuple[Floats, Floats, Floats]:
    """Deflection [m], velocity [m/s], and measured minus modelled force [N], of the samples with a known direction.

    The model: elastic law and Coulomb friction of the last valid state, the published inertia, and a damper whose force
    is the integral of the published damping over the speed.
    """
    assert side.impedance
    assert side.state
    series, state = side.impedance, side.state.flagged
    x, v, a = (series[name] for name in ("deflection", "velocity", "acceleration"))
    used = series.valid("force") & series.valid("velocity") & (np.abs(v) > STDS * series.std("velocity"))
    x, v, a = x[used], v[used], a[used]
    speed, damping = _medians(np.abs(series["velocity"]), series["damping"], series.valid("damping"))
    model = law.force(x) + state["coulomb_friction"] * np.sign(v) + series["inertia"][used] * a
    if len(speed):
        model += np.sign(v) * _integral(speed, damping, np.abs(v))
    return x, v, series["force"][used] - model


def _integral(speed: Floats, damping: Floats, at: Floats) -> Floats:
    """Integral of the damping from zero to the speeds `at` [N]; constant beyond the first and last of `speed` [m/s]."""
    grid = np.linspace(0.0, max(float(at.max(initial=0.0)), float(speed[-1])), 10 * BINS)
    values = np.interp(grid, speed, damping)
    force = np.r_[0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(grid))]
    return np.interp(at, grid, force)


def _medians(x: Floats, y: Floats, used: Any) -> tuple[Floats, Floats]:
    """Medians of y in bins of x that have enough of the samples `used`, at the medians of x."""
    x, y = x[used], y[used]
    if not len(x):
        return x, y
    bins = np.minimum(((x - x.min()) / (np.ptp(x) or 1.0) * BINS).astype(int), BINS - 1)
    kept = [bins == i for i in range(BINS) if np.count_nonzero(bins == i) >= MIN_BIN_SAMPLES]
    return np.array([np.median(x[one]) for one in kept]), np.array([np.median(y[one]) for one in kept])


def _draw(row: Any, side: Transmission, law: KnotLaw, color: str) -> None:
    assert side.impedance
    assert side.state
    x, v, left = residual(side, law)
    along = np.linspace(x.min(), x.max(), 200) if len(x) else law.deflection
    name = side.state.flagged["elastic_law"]
    across, force = cloud(1e3 * side.impedance["deflection"], side.impedance["force"])
    row[0].plot(across, force, ".", color=MEASURED, markersize=2, label="measured")
    row[0].plot(1e3 * along, law.force(along), color=color, label="elastic law")
    row[0].set(xlabel="position [mm]", ylabel="force [N]", title=f"{side.name}: {name}")
    row[0].legend()
    noise = Z95 * side.state.flagged["force_noise_std"]
    for axes, abscissa, label in ((row[1], 1e3 * x, "position [mm]"), (row[2], 1e3 * v, "velocity [mm/s]")):
        axes.axhspan(-noise, noise, color=MEASURED, alpha=0.25, linewidth=0.0)
        axes.axhline(0.0, color=TRUTH, linewidth=0.6)
        axes.plot(*cloud(abscissa, left), ".", color=color, markersize=2)
        axes.plot(*_medians(abscissa, left, np.isfinite(left)), color=TRUTH, linewidth=1.0)
        axes.set(xlabel=label, ylabel="residual [N]")
        limits(axes, left, noise, -noise)


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
    updated = np.isin(state["status"], (Status.VALID, Status.DEGRADED, Status.MODEL_INADEQUATE))
    settled = (time > SETTLING_FRACTION * np.nanmax(time, initial=0.0)) & updated & np.isfinite(state[name])
    if np.count_nonzero(settled) < MIN_SAMPLES:
        return
    found = allan(state[name][settled], 1.0 / float(np.median(np.diff(time[settled]))))
    variance = found.deviation**2
    axes.plot(found.tau, variance, "o-", color=color, markersize=3, label=f"{label}: {found.classification}")
    axes.plot(found.tau, variance[0] * found.tau[0] / found.tau, "--", color=MEASURED, linewidth=0.8)
