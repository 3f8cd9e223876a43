# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Law of one transmission at rest, from the state of its estimator.

At rest F = F0 + sigma / k2 and sigma = exp(ln sigma_r + k2 (x - x_r)), eqs. (2) and (3).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from vsa_joint.tuning import MAX_LN_STIFFNESS, MIN_ELASTIC_FORCE


@dataclass(frozen=True)
class Spring:
    """Coefficients of one transmission at rest with the covariance of (ln_stiffness, k2)."""

    deflection_reference: float  # m
    ln_stiffness: float  # of N/m, at the reference
    k2: float  # 1/m
    force_offset: float  # N
    ln_stiffness_variance: float = 0.0
    k2_variance: float = 0.0
    covariance: float = 0.0  # 1/m
    damping: float = 0.0  # N s/m, at rest
    peak_speed: float = math.inf  # m/s, of the greatest damper force
    force_offset_variance: float = 0.0  # N^2
    force_offset_covariance: float = 0.0  # with k2 [N/m]

    def deflection(self, force: float) -> float:
        """Deflection at rest under a force [m]."""
        elastic = max(force - self.force_offset, MIN_ELASTIC_FORCE)
        return self.deflection_reference + (math.log(self.k2 * elastic) - self.ln_stiffness) / self.k2

    def force(self, deflection: float) -> float:
        """Force at rest at a deflection [N], eq. (2)."""
        return self.force_offset + self.stiffness_at(deflection) / self.k2

    def stiffness(self, force: float) -> float:
        """Stiffness under a force [N/m], eq. (3)."""
        return self.k2 * max(force - self.force_offset, MIN_ELASTIC_FORCE)

    def stiffness_at(self, deflection: float) -> float:
        """Stiffness at a deflection [N/m]."""
        return math.exp(self.ln_stiffness + self.k2 * (deflection - self.deflection_reference))

    def damper(self, velocity: float) -> float:
        """Force of the damper without dry friction [N], eq. (5); constant beyond its maximum."""
        v = min(max(velocity, -self.peak_speed), self.peak_speed)
        return self.damping * v * (1.0 - (v / self.peak_speed) ** 2 / 3.0)

    @property
    def damper_max(self) -> float:
        """Greatest force of the damper [N]; 0 where the peak speed is unknown."""
        return 2.0 / 3.0 * self.damping * self.peak_speed if math.isfinite(self.peak_speed) else 0.0

    def position_variance(self, force: float) -> float:
        """Variance of ln stiffness, predicted from the deflection at which the spring bears `force`."""
        dx = self.deflection(force) - self.deflection_reference
        return max(0.0, self.ln_stiffness_variance + 2.0 * dx * self.covariance + dx * dx * self.k2_variance)

    def force_variance(self, force: float) -> float:
        """Variance of ln stiffness, predicted from the force, eq. (3)."""
        by_k2, by_offset = 1.0 / self.k2, -1.0 / max(force - self.force_offset, MIN_ELASTIC_FORCE)
        squares = by_k2**2 * self.k2_variance + by_offset**2 * self.force_offset_variance
        return max(0.0, squares + 2.0 * by_k2 * by_offset * self.force_offset_covariance)


Springs = tuple[Spring, Spring]  # transmission_1, transmission_2


class CoefficientEstimate(Protocol):
    """Fields that `identified_spring` reads of EstimatorState or of the estimator's own state."""

    deflection_reference: float
    ln_stiffness_reference: float
    k2: float
    d1: float
    d2: float
    force_offset: float
    coefficient_covariance: Sequence[float]


def identified_spring(state: CoefficientEstimate) -> Spring | None:
    """Spring from the state of an estimator; None where the coefficients are not usable."""
    covariance = state.coefficient_covariance
    numbers = (state.ln_stiffness_reference, state.k2, state.force_offset, *covariance)
    usable = state.k2 > 0.0 and abs(state.ln_stiffness_reference) <= MAX_LN_STIFFNESS
    if not (usable and all(math.isfinite(number) for number in numbers)):
        return None
    return Spring(
        deflection_reference=state.deflection_reference,
        ln_stiffness=state.ln_stiffness_reference,
        k2=state.k2,
        force_offset=state.force_offset,
        ln_stiffness_variance=covariance[0],
        k2_variance=covariance[8],
        covariance=covariance[1],
        damping=max(state.d1, 0.0),
        peak_speed=math.sqrt(state.d1 / (-3.0 * state.d2)) if state.d1 > 0.0 > state.d2 else math.inf,
        force_offset_variance=covariance[40],
        force_offset_covariance=covariance[12],
    )
