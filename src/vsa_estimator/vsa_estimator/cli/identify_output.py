# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tables, texts and figure of `./vsa identify`."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from vsa_common.figures import MEASURED, SIDE_1, TRUTH, band, limits, panels, save
from vsa_estimator.offline.elastic_law import Z95, Deviation
from vsa_estimator.offline.identification import UNITS, Identification

COEFFICIENTS = ("coefficient", "value", "std", "variance", "unit", "95 % interval")
LAW = ("deflection [mm]", "stiffness [N/mm]", "std [%]", "95 % interval [N/mm]", "off the exponential [%]")
KNOT_STEP = 2  # knots of a law from one printed knot to the next


def coefficient_rows(result: Identification) -> list[list[str]]:
    """Rows of the table of coefficients."""
    table = []
    for name in result.names:
        value, std = result.value(name), result.std(name)
        low, high = value - Z95 * std, value + Z95 * std
        table.append([name, f"{value:.5g}", f"{std:.2g}", f"{std**2:.3g}", UNITS[name], f"{low:.4g} to {high:.4g}"])
    return table


def law_rows(result: Identification) -> list[list[str]]:
    """Rows of the table of a law of any form: stiffness at knots."""
    assert result.deviation
    x = result.law.deflection[::KNOT_STEP]
    stiffness, std, (low, high) = result.law.stiffness(x), result.law.ln_std(x), result.law.band(x)
    deviation = np.expm1(result.deviation.ln_stiffness[::KNOT_STEP])
    columns = zip(1e3 * x, 1e-3 * stiffness, 1e2 * std, 1e-3 * low, 1e-3 * high, 1e2 * deviation, strict=True)
    return [
        [f"{at:.3f}", f"{value:.5g}", f"{share:.2g}", f"{least:.4g} to {most:.4g}", f"{other:+.2g}"]
        for at, value, share, least, most, other in columns
    ]


def law_text(result: Identification) -> str:
    """The elastic law: eq. (20), or its name and range."""
    if result.is_exponential:
        f0, k1, k2 = (result.value(name) for name in ("force_offset", "k1", "k2"))
        return f"F_S = {f0:.4g} + {k1:.4g} exp({1e-3 * k2:.4g} x)    N, mm"
    x = 1e3 * result.law.deflection
    return f"stiffness from {x[0]:.3f} to {x[-1]:.3f} mm"


def comparison(result: Identification) -> str:
    """Result of the comparison with the exponential law, on one line; empty without one."""
    found = result.deviation
    if found is None:
        return ""
    excess, x = np.expm1(found.ln_stiffness), 1e3 * found.deflection
    most = np.argmax(np.abs(found.ln_stiffness) / np.hypot(found.std, 1e-4))
    text = f"{1e2 * excess[most]:+.2g} +- {1e2 * Z95 * found.std[most]:.2g} % at {x[most]:.2f} mm"
    if not found.is_significant:
        return f"the exponential law is not refuted; most significant deviation of a law of any form: {text}"
    return (
        f"the exponential law is refuted: the stiffness deviates from it {_ranges(found)}; most significantly by {text}"
    )


def _ranges(found: Deviation) -> str:
    """Deflections at which the deviation is outside of its interval."""
    edges = np.flatnonzero(np.diff(np.r_[False, found.where, False]))
    x = 1e3 * found.deflection
    parts = [f"{x[first]:.2f} to {x[end - 1]:.2f}" for first, end in zip(edges[::2], edges[1::2], strict=True)]
    return f"at {', '.join(parts)} mm" if parts else "in total"


def plot(path: Path, results: Mapping[str, Identification]) -> None:
    """Plot force, stiffness with its 95 % band, and residual over deflection and speed."""
    figure, axes = panels(len(results), 4, width=14.0, height=2.6 * len(results) + 0.5, title="Identification")
    for row, (name, one) in zip(np.atleast_2d(axes), results.items(), strict=True):
        x, v = 1e3 * one.deflection, 1e3 * one.velocity  # [mm, mm/s]
        along = np.linspace(one.deflection.min(), one.deflection.max(), 200)
        row[0].plot(x, one.force, ".", color=MEASURED, markersize=2, label="measured")
        row[0].plot(1e3 * along, one.law.force(along), color=SIDE_1, label="elastic law")
        row[0].set(ylabel=f"{name}\nforce [N]", xlabel="deflection [mm]")
        low, high = one.law.band(along)
        row[1].plot(1e3 * along, 1e-3 * one.law.stiffness(along), color=SIDE_1, label="elastic law")
        band(row[1], 1e3 * along, 1e-3 * low, 1e-3 * high, SIDE_1)
        if one.deviation is not None and not one.is_exponential:
            exponential = 1e-3 * one.deviation.exponential(along)
            row[1].plot(1e3 * along, exponential, "--", color=TRUTH, linewidth=0.9, label="exponential law")
        row[1].set(ylabel="stiffness [N/mm]", xlabel="deflection [mm]")
        limits(row[1], 1e-3 * one.law.stiffness(along))
        for axis in row[:2]:
            axis.legend()
        for axis, abscissa, label in ((row[2], x, "deflection [mm]"), (row[3], v, "speed [mm/s]")):
            axis.plot(abscissa, one.residual, ".", color=SIDE_1, markersize=2)
            axis.axhline(0.0, color=TRUTH, linewidth=0.6)
            axis.set(xlabel=label, ylabel="residual [N]")
            limits(axis, one.residual)
    save(figure, path)
