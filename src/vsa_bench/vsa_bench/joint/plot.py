# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figure: response without friction; errors of identified and estimated impedance with friction."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from vsa_bench.joint.experiment import Outcome
from vsa_bench.joint.report import NAMES, PERCENT, relative_error
from vsa_common.figures import JOINT, SIDE_1, SIDE_2, TRUTH, WARNING, panels, save

if TYPE_CHECKING:
    from vsa_common.figures import Axes

COLORS = (SIDE_1, JOINT, WARNING)  # by tendon stiffness, ascending
OFFSET = 1.0  # N, between the markers of both series
SERIES = (("identified, against truth", SIDE_1, -OFFSET), ("estimated, against identified", SIDE_2, OFFSET))


def plot(outcomes: Sequence[Outcome], path: Path) -> None:
    """Save the figure: a row for the response, a row for the errors, each if there are such cases."""
    frictionless_cases = [o for o in outcomes if o.response]
    with_friction = [o for o in outcomes if not o.case.frictionless]
    count = bool(frictionless_cases) + bool(with_friction)
    figure, axes = panels(count, 2, height=3.2 * count, title="Impedance of the joint")
    rows = list(np.atleast_2d(axes))
    if frictionless_cases:
        _responses(rows[0], frictionless_cases)
    if with_friction:
        _errors(rows[-1], with_friction)
    save(figure, path)


def _responses(axes: Sequence[Axes], outcomes: Sequence[Outcome]) -> None:
    tendons = sorted({o.case.tendon_stiffness for o in outcomes})
    magnitude, phase = axes
    for o in outcomes:
        assert o.response
        frequency, color = o.response.frequency, COLORS[tendons.index(o.case.tendon_stiffness) % len(COLORS)]
        for axis, of in ((magnitude, np.abs), (phase, lambda z: np.degrees(np.angle(z)))):
            axis.plot(frequency, of(o.response.predicted), color=color, linewidth=0.9)
            axis.plot(frequency, of(o.response.measured), ".", color=TRUTH, markersize=3)
    for tendon, color in zip(tendons, COLORS, strict=False):
        magnitude.plot([], [], color=color, label=f"predicted, tendon {1e-3 * tendon:g} N/mm")
    magnitude.plot([], [], ".", color=TRUTH, markersize=3, label="measured")
    magnitude.legend(fontsize="small")
    magnitude.set(xscale="log", yscale="log", xlabel="Hz", ylabel="N m/rad", title="torque over angle, no friction")
    phase.set(xscale="log", xlabel="Hz", ylabel="degrees", title="phase of torque over angle")


def _errors(axes: Sequence[Axes], outcomes: Sequence[Outcome]) -> None:
    for axis, name in zip(axes, NAMES, strict=True):
        pairs = (
            [relative_error(o.identified.impedance, o.truth, name) for o in outcomes],
            [relative_error(o.estimated, o.identified.impedance, name) for o in outcomes],
        )
        for (label, color, offset), errors in zip(SERIES, pairs, strict=True):
            forces = [o.case.force + offset for o in outcomes]
            axis.plot(forces, [PERCENT * e for e in errors], "o", color=color, markersize=3, alpha=0.6, label=label)
        axis.axhline(0.0, color=TRUTH, linewidth=0.6)
        axis.set(xlabel="force while held, N", ylabel="error, %", title=f"{name}, with friction")
    axes[0].legend(fontsize="small")
