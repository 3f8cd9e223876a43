"""The numbers of a report: Table I, the joint, and how healthy the run was."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from vsa_common.types import ResetReason, Status
from vsa_tools.report.columns import Floats, Series
from vsa_tools.report.data import Joint, Side
from vsa_tools.report.truth import Truth, Truths

Z95 = 1.96

COEFFICIENTS = {  # name: title, unit, factor to N, mm, s, that unit
    "k2": ("k2, exponent", "1/m", 1e-3, "1/mm"),
    "d2": ("d2, cubic damping", "N s³/m³", 1e-9, "N s³/mm³"),
    "inertia": ("m, inertia", "kg", 1.0, "kg"),
    "d1": ("d1, linear damping", "N s/m", 1e-3, "N s/mm"),
    "force_offset": ("F0, force offset", "N", 1.0, "N"),
    "coulomb_friction": ("d0, Coulomb friction", "N", 1.0, "N"),
}


@dataclass(frozen=True)
class Table:
    """A heading, the columns' names and rows of text."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def number(value: float, digits: int = 4) -> str:
    """A number as people read it; a dash where there is none."""
    return f"{value:.{digits}g}" if np.isfinite(value) else "–"


def table_1(joint: Joint, truth: Truths) -> Table:
    """Coefficients at the end of the run with their 95 % intervals: the paper's Table I, and d1, F0 and d0."""
    rows = []
    for side in joint.sides:
        if side.state is None:
            continue
        known = truth.get((joint.name, side.name))
        for name, (title, unit, factor, small_unit) in COEFFICIENTS.items():
            rows.append(_coefficient(side, side.state, name, title, unit, factor, small_unit, known))
    columns = ["", "quantity", "estimate", "± 95 %", "unit", "in N, mm, s", "truth", "error"]
    if not any(key[0] == joint.name for key in truth):
        columns, rows = columns[:6], [row[:6] for row in rows]
    reasons = [line for side in joint.sides if side.state for line in _not_valid(side)]
    return Table("Table I: coefficients at the end of the run", columns, rows, "; ".join(reasons))


def _coefficient(
    side: Side, state: Series, name: str, title: str, unit: str, factor: float, small_unit: str, known: Truth | None
) -> list[str]:
    value, half = float(state[name][-1]), Z95 * float(state.std(name)[-1])
    estimate = number(value) if state.valid(name)[-1] else f"({number(value)})"
    true = known.coefficients.get(name, np.nan) if known else np.nan
    error = f"{1e2 * (value / true - 1.0):+.2f} %" if np.isfinite(true) and true else "–"
    small = f"{number(factor * value)} ± {number(factor * half, 2)} {small_unit}"
    return [side.name, title, estimate, number(half, 2), unit, small, number(true), error]


def _not_valid(side: Side) -> list[str]:
    """What is in brackets and why, as the estimator put it."""
    assert side.state
    names = [name for name in COEFFICIENTS if not side.state.valid(name)[-1]]
    reasons = [line for line in side.state.texts.get("observability", ()) if line]
    why = f" ({'; '.join(reasons)})" if reasons else ""
    return [f"{side.name}: in brackets, not valid at the end: {', '.join(names)}{why}"] if names else []


def joint_table(joint: Joint) -> Table | None:
    """What the joint felt like while it was known: range, and typical standard deviation."""
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
        share = f"{1e2 * np.mean(valid):.1f} %"
        if not len(value):
            rows.append([title, "–", "–", "–", unit, share])
            continue
        low, middle, high = np.quantile(value, [0.0, 0.5, 1.0])
        rows.append(
            [title, f"{number(low)} … {number(high)}", number(middle), number(float(np.median(std)), 2), unit, share]
        )
    return Table("Joint impedance while valid", ["quantity", "range", "median", "std", "unit", "valid"], rows)


def health_table(joint: Joint) -> Table:
    """Samples, losses, rejections, resets and validity of each transmission."""
    names = [side.name for side in joint.sides]
    facts = [_health(side) for side in joint.sides]
    rows = [[title, *(fact.get(title, "–") for fact in facts)] for title in dict.fromkeys(k for f in facts for k in f)]
    return Table("Health of the run", ["", *names], rows)


def _health(side: Side) -> dict[str, str]:
    facts: dict[str, str] = {}
    samples = side.force or side.impedance
    if samples is not None and len(samples) > 1:
        steps = np.diff(samples.stamp_ns) * 1e-9
        steps = steps[steps > 0.0]
        facts["samples"] = str(len(samples))
        facts["sample rate"] = f"{1.0 / np.median(steps):.1f} Hz" if len(steps) else "–"
    if side.counters:
        counted = np.array(sorted(set(side.counters.values())))
        facts["lost on the bus, by counter"] = str(int(counted[-1] - counted[0] + 1 - len(counted)))
    if side.state is not None:
        state = side.state
        for name, title in (
            ("samples_fused", "samples fused"),
            ("samples_dropped", "samples dropped"),
            ("force_rejected", "force rejected by the gate"),
            ("deflection_rejected", "deflection rejected by the gate"),
        ):
            facts[title] = number(float(state[name][-1]), 12)
        facts["force noise in use"] = f"{number(state['force_noise_std'][-1], 3)} N"
        facts["deflection noise in use"] = f"{number(1e3 * state['deflection_noise_std'][-1], 3)} mm"
    if side.impedance is not None:
        facts |= _validity(side.impedance)
    return facts


def _validity(series: Series) -> dict[str, str]:
    facts = {}
    resets, reason = float(series["reset_count"][-1]), series["reset_reason"][-1]
    facts["resets"] = number(resets, 12) + (f", last: {word(ResetReason, reason)}" if resets else "")
    valid = series.valid("stiffness")
    first = series.time[valid][:1]
    facts["stiffness first valid after"] = f"{first[0]:.2f} s" if len(first) else "never"
    facts["stiffness valid"] = f"{1e2 * np.mean(valid):.1f} % of the samples"
    facts["status at the end"] = word(Status, series["status"][-1])
    facts |= {f"delay to the recorder, {k}": v for k, v in delays(series).items()}
    return facts


def delays(series: Series) -> dict[str, str]:
    """Time from the sensor's stamp to the recorder; nothing where the stamps are not of the recorder's clock."""
    behind = delay(series)
    if not len(behind):
        return {}
    p50, p99 = np.quantile(behind, [0.5, 0.99])
    return {"p50": f"{1e3 * p50:.2f} ms", "p99": f"{1e3 * p99:.2f} ms", "max": f"{1e3 * behind.max():.2f} ms"}


def delay(series: Series) -> Floats:
    """Receive time less stamp [s]; empty where that is no delay: other clocks, or a replay."""
    behind: Floats = (series.receive_ns - series.stamp_ns).astype(np.float64) * 1e-9
    return behind if -0.001 < np.median(behind) < 60.0 else np.empty(0)


def word(kind: type[Status] | type[ResetReason], value: float) -> str:
    """Name of an enumeration's value, or the bare number of one that is not known."""
    try:
        return kind(int(value)).name
    except ValueError:
        return number(value)
