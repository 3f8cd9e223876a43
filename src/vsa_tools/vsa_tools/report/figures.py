# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Pages of figures of a report, named after the paper's figures."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from vsa_common.figures import SIDES, set_title
from vsa_tools.report.data import Joint, Run
from vsa_tools.report.joint_figures import figure_health, figure_joint
from vsa_tools.report.model_figures import figure_allan, figure_elastic_law, figure_laws
from vsa_tools.report.transmission_figures import figure_coefficients, figure_impedance, figure_motion
from vsa_tools.report.truth import Truths


@dataclass(frozen=True)
class FigurePage:
    """One figure with the stem of its files, its title and its caption."""

    name: str
    title: str
    caption: str
    figure: Any


def figure_pages(run: Run, truth: Truths) -> Iterator[FigurePage]:
    """Every figure for which the recording has data, joint by joint."""
    for joint in run.joints:
        several = len(run.joints) > 1
        prefix = f"{joint.name.strip('/').replace('/', '_')}_" if several else ""
        for name, title, caption, figure in _figures(joint, run.duration, truth):
            set_title(figure, title + (f" ({joint.name})" if several else ""))
            yield FigurePage(prefix + name, title, caption, figure)


def _figures(joint: Joint, duration: float, truth: Truths) -> Iterator[tuple[str, str, str, Any]]:
    for side, color in zip(joint.transmissions, SIDES, strict=False):
        side_truth = truth.get((joint.name, side.name))
        if side.force or side.impedance or side.encoder:
            motion = figure_motion(side, side_truth, color, duration)
            yield f"fig7_{side.name}", f"Fig. 7: motion of {side.name}", _CAPTION_7, motion
        if side.impedance:
            impedance = figure_impedance(side, side_truth, color, duration)
            yield f"fig8_{side.name}", f"Fig. 8: impedance of {side.name}", _CAPTION_8, impedance
    if any(side.impedance for side in joint.transmissions):
        laws = figure_laws(joint, truth)
        yield "fig9", "Fig. 9: stiffness against position, damping against velocity", _CAPTION_9, laws
    elastic = figure_elastic_law(joint)
    if elastic is not None:
        yield "elastic_law", "Elastic law: force, and residual of the model", _CAPTION_E, elastic
    if any(side.state for side in joint.transmissions):
        yield "table1", "Table I: coefficients over time", _CAPTION_T, figure_coefficients(joint, truth, duration)
        yield "fig6", "Fig. 6: Allan variance of the innovations", _CAPTION_6, figure_allan(joint)
    if joint.impedance:
        yield "joint", "Joint: impedance, (10) to (13)", _CAPTION_J, figure_joint(joint, duration)
    yield "health", "Health: status, delay, gate", _CAPTION_H, figure_health(joint, duration)


_CAPTION_7 = (
    "Measured force and its rate (first-order filter, 0.19 s as section VI implies), measured and estimated position "
    "with their difference, estimated velocity and acceleration. Bands: 2 standard deviations. Grey: not valid."
)
_CAPTION_8 = (
    "Generalised stiffness, damping and inertia, (8), with bands of 2 standard deviations. Grey: not valid. "
    "Dashed: truth of the simulated rig."
)
_CAPTION_9 = (
    "Dots: valid estimates, minimum and maximum in each bin. "
    "Line: the law at the end; of the stiffness the elastic law of the last valid state with its 95 % band, "
    "of the damping (5) with the coefficients at the end."
)
_CAPTION_E = (
    "Elastic law of the last valid state, named in the title. Residual: measured force minus elastic law, damper, "
    "friction and inertia, minimum and maximum in each bin; line: median; the damper's force is the integral of the "
    "published damping over the speed. Grey: 95 % interval of the force sensor's noise. A median outside of it over "
    "the position is a misfit of the elastic law or its drift, over the velocity one of damper, friction or delay."
)
_CAPTION_T = "k2, d2 and m with bands of 2 standard deviations. Grey: not valid."
_CAPTION_6 = (
    "Innovations of force and deflection. White noise has slope -1 (dashed); a curve above it is motion that the model "
    "does not explain. `./vsa noise` gives the noise of the sensors from a recording at rest."
)
_CAPTION_J = "Stiffness, damping and inertia at the joint with 2 sd bands, tendon tensions, angle and torque."
_CAPTION_H = (
    "Status of every estimate over time; delay from the sensor's stamp to the recorder; normalised innovation squared, "
    "whose mean is 1 for a consistent filter; the gate rejects samples with large values."
)
