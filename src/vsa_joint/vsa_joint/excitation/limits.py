# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Range of the mean deflection in which forces, deflections and motors stay within their limits."""

import numpy as np
from vsa_joint.excitation.balance import Models, Start, static_deflections
from vsa_joint.excitation.multisine import Range
from vsa_joint.excitation.settings import ExcitationConfig, Goal
from vsa_joint.excitation.tuning import RANGE_POINTS

Pair = tuple[float, float]  # transmission_1, transmission_2


def excess(forces: Pair, deflections: Pair, config: ExcitationConfig, goal: Goal) -> str:
    """The first limit that is exceeded at the upper end, as text; empty for none."""
    for number, (force, x) in enumerate(zip(forces, deflections, strict=True), 1):
        if force > goal.force_max:
            return f"force of transmission_{number} {force:.3g} N, limit {goal.force_max:.3g} N"
        if x > config.deflection_max:
            return f"deflection of transmission_{number} {1e3 * x:.3g} mm, limit {1e3 * config.deflection_max:.3g} mm"
    return ""


def shortfall(deflections: Pair, config: ExcitationConfig) -> str:
    """The first limit that is exceeded at the lower end, as text; empty for none."""
    for number, x in enumerate(deflections, 1):
        if x < config.deflection_min:
            return f"deflection of transmission_{number} {1e3 * x:.3g} mm, limit {1e3 * config.deflection_min:.3g} mm"
    return ""


def predicted_range(models: Models, start: Start, forces: Pair, config: ExcitationConfig, goal: Goal) -> Range:
    """Range of the mean deflection relative to the start, by the models and the measured `forces` [N] at the start."""
    mean = np.asarray(np.linspace(-goal.travel, goal.travel, RANGE_POINTS), float)
    within = np.ones(RANGE_POINTS, bool)
    rest = np.zeros(())
    for i, x in enumerate(static_deflections(mean, start, models)):
        force = forces[i] + models[i].force(x, rest) - models[i].force(np.asarray(start.deflections[i]), rest)
        within &= (force <= goal.force_max) & (config.deflection_min <= x) & (x <= config.deflection_max)
    inside = mean[within]
    return Range(float(inside.min(initial=0.0)), float(inside.max(initial=0.0)), goal.speed)


def motor_range(config: ExcitationConfig, motors: Pair) -> Pair:
    """Changes of the mean deflection [m] that the travel of both motors permits from `motors` [rad]."""
    per_radian = 0.5 * config.motor_pulley_radius
    return per_radian * (config.motor_min - min(motors)), per_radian * (config.motor_max - max(motors))
