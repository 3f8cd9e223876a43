# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tables of a report: Table I, the joint, and the health of the run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vsa_common.types import ResetReason, Status
from vsa_tools.report.columns import Floats, Series
from vsa_tools.report.data import Joint, Transmission
from vsa_tools.report.truth import Truth, Truths

Z95 = 1.96  # half width of the 95 % interval in standard deviations [1]


class Unit(NamedTuple):
    """Title and SI unit of a coefficient, and the factor to its unit in N, mm and s."""

    title: str
    unit: str
    factor: float
    small_unit: str


COEFFICIENTS = {
    "k2": Unit("k2, exponent", "1/m", 1e-3, "1/mm"),
    "d2": Unit("d2, cubic damping", "N s³/m³", 1e-9, "N s³/mm³"),
    "inertia": Unit("m, inertia", "kg", 1.0, "kg"),
    "d1": Unit("d1, linear damping", "N s/m", 1e-3, "N s/mm"),
    "force_offset": Unit("F0, force offset", "N", 1.0, "N"),
    "coulomb_friction": Unit("d0, Coulomb friction", "N", 1.0, "N"),
}


@dataclass(frozen=True)
class Table:
    """Title, column names and rows of text."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def number(value: float, digits: int = 4) -> str:
    """A number with `digits` significant digits; a dash for NaN or infinity."""
    return f"{value:.{digits}g}" if np.isfinite(value) else "–"


def table_1(joint: Joint, truth: Truths) -> Table:
    """Coefficients at the end of the run with their 95 % intervals: the paper's Table I, and d1, F0 and d0."""
    rows = [
        _coefficient(side.name, side.state, name, truth.get((joint.name, side.name)))
        for side in joint.transmissions
        if side.state is not None
        for name in COEFFICIENTS
    ]
    columns = ["", "quantity", "estimate", "± 95 %", "unit", "in N, mm, s", "truth", "error"]
    if not any(key[0] == joint.name for key in truth):
        columns, rows = columns[:6], [row[:6] for row in rows]
    reasons = [line for side in joint.transmissions if side.state for line in _not_valid(side)]
    return Table("Table I: coefficients at the end of the run", columns, rows, "; ".join(reasons))


def _coefficient(side: str, state: Series, name: str, truth: Truth | None) -> list[str]:
    title, unit, factor, small_unit = COEFFICIENTS[name]
    value, half = float(state[name][-1]), Z95 * float(state.std(name)[-1])
    estimate = number(value) if state.valid(name)[-1] else f"({number(value)})"
    true = truth.coefficients.get(name, np.nan) if truth else np.nan
    error = f"{1e2 * (value / true - 1.0):+.2f} %" if np.isfinite(true) and true else "–"
    small = f"{number(factor * value)} ± {number(factor * half, 2)} {small_unit}"
    return [side, title, estimate, number(half, 2), unit, small, number(true), error]


def _not_valid(side: Transmission) -> list[str]:
    """Note on the values in brackets, with the estimator's reasons."""
    assert side.state
    names = [name for name in COEFFICIENTS if not side.state.valid(name)[-1]]
    reasons = [line for line in side.state.texts.get("observability", ()) if line]
    why = f" ({'; '.join(reasons)})" if reasons else ""
    return [f"{side.name}: in brackets, not valid at the end: {', '.join(names)}{why}"] if names else []


def joint_table(joint: Joint) -> Table | None:
    """Range, median and median standard deviation of the joint's impedance while it is valid."""
    series = joint.impedance
    if series is None:
        return None
    rows = []
    for name, title, unit in (
        ("stiffness", "K, stiffness (11)", "N m/rad"),
        ("damping", "D, damping (13)", "N m s/rad"),
        ("inertia", "J, inertia (12)", "kg m²"),
    ):
        valid = series.valid(name)
        value, std = series[name][valid], series.std(name)[valid]
        fraction = f"{1e2 * np.mean(valid):.1f} %"
        if not len(value):
            rows.append([title, "–", "–", "–", unit, fraction])
            continue
        low, middle, high = np.quantile(value, [0.0, 0.5, 1.0])
        rows.append(
            [title, f"{number(low)} … {number(high)}", number(middle), number(float(np.median(std)), 2), unit, fraction]
        )
    return Table("Joint impedance while valid", ["quantity", "range", "median", "std", "unit", "valid"], rows)


def health_table(joint: Joint) -> Table:
    """Samples, losses, rejections, resets and validity of each transmission."""
    names = [side.name for side in joint.transmissions]
    values = [_health(side) for side in joint.transmissions]
    titles = dict.fromkeys(title for side in values for title in side)
    rows = [[title, *(side.get(title, "–") for side in values)] for title in titles]
    return Table("Health of the run", ["", *names], rows)


def _health(side: Transmission) -> dict[str, str]:
    values: dict[str, str] = {}
    samples = side.force or side.impedance
    if samples is not None and len(samples) > 1:
        steps = np.diff(samples.stamp_ns) * 1e-9
        steps = steps[steps > 0.0]
        values["samples"] = str(len(samples))
        values["sample rate"] = f"{1.0 / np.median(steps):.1f} Hz" if len(steps) else "–"
    if side.counters:
        counted = np.array(sorted(set(side.counters.values())))
        values["lost on the bus, by counter"] = str(int(counted[-1] - counted[0] + 1 - len(counted)))
    if side.state is not None:
        state = side.state
        for name, title in (
            ("samples_fused", "samples fused"),
            ("samples_dropped", "samples dropped"),
            ("force_rejected", "force rejected by the gate"),
            ("deflection_rejected", "deflection rejected by the gate"),
        ):
            values[title] = number(float(state[name][-1]), 12)
        values["force noise in use"] = f"{number(state['force_noise_std'][-1], 3)} N"
        values["deflection noise in use"] = f"{number(1e3 * state['deflection_noise_std'][-1], 3)} mm"
    if side.impedance is not None:
        values |= _validity(side.impedance)
    return values


def _validity(series: Series) -> dict[str, str]:
    values = {}
    resets, reason = float(series["reset_count"][-1]), series["reset_reason"][-1]
    values["resets"] = number(resets, 12) + (f", last: {enum_name(ResetReason, reason)}" if resets else "")
    valid = series.valid("stiffness")
    first = series.time[valid][:1]
    values["stiffness first valid after"] = f"{first[0]:.2f} s" if len(first) else "never"
    values["stiffness valid"] = f"{1e2 * np.mean(valid):.1f} % of the samples"
    values["status at the end"] = enum_name(Status, series["status"][-1])
    values |= {f"delay to the recorder, {k}": v for k, v in delays(series).items()}
    return values


def delays(series: Series) -> dict[str, str]:
    """Delay from the sensor's stamp to the recorder; empty where both clocks differ."""
    delay_s = delay(series)
    if not len(delay_s):
        return {}
    p50, p99 = np.quantile(delay_s, [0.5, 0.99])
    return {"p50": f"{1e3 * p50:.2f} ms", "p99": f"{1e3 * p99:.2f} ms", "max": f"{1e3 * delay_s.max():.2f} ms"}


def delay(series: Series) -> Floats:
    """Receive time minus stamp [s]; empty where the clocks differ (other host, replay)."""
    delay_s: Floats = (series.receive_ns - series.stamp_ns).astype(np.float64) * 1e-9
    return delay_s if -0.001 < np.median(delay_s) < 60.0 else np.empty(0)


def enum_name(kind: type[Status] | type[ResetReason], value: float) -> str:
    """Name of an enumeration's value; the number where the value is not defined."""
    try:
        return kind(int(value)).name
    except ValueError:
        return number(value)
