# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force of one transmission by the paper's law, eqs. (2), (5) and (6), and its derivatives by the coefficients."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from vsa_common.damper import peak_speed
from vsa_common.types import Array
from vsa_joint.excitation.tuning import COULOMB_SPEED, MAX_EXPONENT, MIN_NOISE_STD

COEFFICIENTS = ("stiffness", "k2", "damping", "d2", "inertia", "force_offset", "coulomb_friction")


class CoefficientState(Protocol):
    """Fields that `model_of` reads of EstimatorState or of the estimator's own state."""

    deflection_reference: float
    ln_stiffness_reference: float
    k2: float
    d1: float
    d2: float
    inertia: float
    force_offset: float
    coulomb_friction: float
    coefficient_covariance: Sequence[float]
    force_noise_std: float
    deflection_noise_std: float


class Motion(NamedTuple):
    """Deflection, velocity and acceleration of a transmission, arrays of one shape, SI."""

    deflection: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class TransmissionModel:
    """Coefficients of one transmission, SI; `covariance` (7, 7) is in the order of COEFFICIENTS, of ln stiffness first.

    The noise is that of one sample.
    """

    deflection_reference: float
    ln_stiffness: float
    k2: float
    d1: float
    d2: float
    inertia: float
    force_offset: float
    coulomb_friction: float
    covariance: Array
    force_noise_std: float
    deflection_noise_std: float

    @property
    def peak_speed(self) -> float:
        """Speed of the greatest damper force [m/s]; infinite for a damper without one."""
        return peak_speed(self.d1, self.d2)

    def stiffness(self, deflection: Array) -> Array:
        """Stiffness [N/m], eq. (3)."""
        exponent = self.ln_stiffness + self.k2 * (deflection - self.deflection_reference)
        return np.exp(np.minimum(exponent, MAX_EXPONENT))

    def damping(self, velocity: Array) -> Array:
        """Damping [N s/m], eq. (9); 0 beyond the peak speed."""
        return np.where(np.abs(velocity) < self.peak_speed, self.d1 + 3.0 * self.d2 * velocity**2, 0.0)

    def force(self, deflection: Array, velocity: Array) -> Array:
        """Force of spring and damper without dry friction [N]."""
        v = np.clip(velocity, -self.peak_speed, self.peak_speed)
        return self.force_offset + self.stiffness(deflection) / self.k2 + self.d1 * v + self.d2 * v**3

    def gradients(self, motion: Motion) -> Array:
        """Derivatives of the force by COEFFICIENTS, (..., 7); that by ln stiffness first."""
        dx = motion.deflection - self.deflection_reference
        elastic = self.stiffness(motion.deflection) / self.k2
        v = np.clip(motion.velocity, -self.peak_speed, self.peak_speed)
        friction = np.tanh(motion.velocity / COULOMB_SPEED)
        return np.stack(
            [elastic, elastic * (dx - 1.0 / self.k2), v, v**3, motion.acceleration, np.ones_like(dx), friction], axis=-1
        )


def model_of(state: CoefficientState) -> TransmissionModel | None:
    """Model from the state of an estimator; None where its coefficients are not usable."""
    covariance = np.array(state.coefficient_covariance, float).reshape(len(COEFFICIENTS), -1)
    numbers = (state.ln_stiffness_reference, state.k2, state.d1, state.d2, state.inertia, state.force_offset)
    finite = np.isfinite(covariance).all() and all(math.isfinite(number) for number in numbers)
    if not finite or state.k2 <= 0.0 or state.d1 <= 0.0 or (np.diag(covariance) <= 0.0).any():
        return None
    return TransmissionModel(
        state.deflection_reference,
        state.ln_stiffness_reference,
        state.k2,
        state.d1,
        state.d2,
        state.inertia,
        state.force_offset,
        state.coulomb_friction,
        covariance=covariance,
        force_noise_std=max(state.force_noise_std, MIN_NOISE_STD),
        deflection_noise_std=max(state.deflection_noise_std, MIN_NOISE_STD),
    )
