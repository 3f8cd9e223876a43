# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion of both transmissions of a free joint in co-contraction.

The motors set the mean deflection u = w1 x1 + w2 x2 with w_i = (1/R_i) / (1/R_1 + 1/R_2), whatever the springs are:
each motor travels 2 du, and the joint turns until the torques balance, R1 F1(x1, v1) = R2 F2(x2, v2). Mean deflections
are relative to the start. The torque at the start is the external one, and constant.
"""

from dataclasses import dataclass

import numpy as np
from vsa_common.types import Array
from vsa_joint.excitation.model import Motion, TransmissionModel
from vsa_joint.excitation.tuning import NEWTON_STEPS, STATIC_BISECTIONS

Models = tuple[TransmissionModel, TransmissionModel]  # transmission_1, transmission_2
Pair = tuple[float, float]


@dataclass(frozen=True)
class Start:
    """Deflections of both transmissions at rest [m], at a mean deflection of zero; radii of the joint's pulley [m]."""

    deflections: Pair
    radii: Pair

    @property
    def weights(self) -> Pair:
        """Weights of both deflections in the mean deflection."""
        first, second = (1.0 / radius for radius in self.radii)
        return first / (first + second), second / (first + second)

    def other(self, deflection: Array, mean: Array) -> Array:
        """Deflection of transmission_2 from that of transmission_1 and the mean deflection [m]."""
        w1, w2 = self.weights
        return self.deflections[1] + (mean - w1 * (deflection - self.deflections[0])) / w2


def static_deflections(mean: Array, start: Start, models: Models) -> tuple[Array, Array]:
    """Deflections of both transmissions at rest at a mean deflection [m], by bisection."""
    rest, external = np.zeros(()), _external_torque(start, models)
    reach = np.abs(mean) / start.weights[0]  # both deflections change in the same direction
    low, high = start.deflections[0] - reach, start.deflections[0] + reach
    for _ in range(STATIC_BISECTIONS):
        middle = 0.5 * (low + high)
        below = _torque(middle, rest, start.other(middle, mean), rest, start, models) < external
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    first = 0.5 * (low + high)
    return first, start.other(first, mean)


def balanced_motions(mean: Array, begin: float, step: float, start: Start, models: Models) -> tuple[Motion, Motion]:
    """Motions of both transmissions for a mean deflection, (..., steps) [m], from rest at the mean deflection `begin`.

    Implicit Euler integration of the balance of torques at a step of `step` [s], without the masses.
    """
    deflection = np.empty_like(mean)
    u = np.full_like(mean[..., 0], begin)
    x, external = static_deflections(u, start, models)[0], _external_torque(start, models)
    for k in range(mean.shape[-1]):
        x = _advance(x, (u, mean[..., k]), step, start, models, external)
        u = mean[..., k]
        deflection[..., k] = x
    return _motion(deflection, step), _motion(start.other(deflection, mean), step)


def _advance(
    before: Array, mean: tuple[Array, Array], step: float, start: Start, models: Models, external: float
) -> Array:
    """Deflection of transmission_1 one step later, by Newton's method; `mean` is that before and after the step."""
    (w1, w2), (first, second) = start.weights, models
    change = mean[1] - mean[0]
    x = before + change
    for _ in range(NEWTON_STEPS):
        v = (x - before) / step
        other, other_v = start.other(x, mean[1]), (change / step - w1 * v) / w2
        slope = start.radii[0] * (first.stiffness(x) + first.damping(v) / step)
        slope += start.radii[1] * w1 / w2 * (second.stiffness(other) + second.damping(other_v) / step)
        x = x - (_torque(x, v, other, other_v, start, models) - external) / slope
    return x


def _torque(x: Array, v: Array, other: Array, other_v: Array, start: Start, models: Models) -> Array:
    """Twice the torque of both tendons [N m]; their tensions are half of the forces."""
    return start.radii[0] * models[0].force(x, v) - start.radii[1] * models[1].force(other, other_v)


def _external_torque(start: Start, models: Models) -> float:
    rest = np.zeros(())
    first, second = (np.asarray(x) for x in start.deflections)
    return float(_torque(first, rest, second, rest, start, models))


def _motion(deflection: Array, step: float) -> Motion:
    velocity = np.gradient(deflection, step, axis=-1)
    return Motion(deflection, velocity, np.gradient(velocity, step, axis=-1))
