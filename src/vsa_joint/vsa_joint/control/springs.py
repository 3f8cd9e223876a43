# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Law of one transmission at rest, and the exponential one."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from vsa_joint.tuning import MIN_ELASTIC_FORCE


@dataclass(frozen=True, kw_only=True)
class Spring(ABC):
    """Law of one transmission at rest, and its damper."""

    damping: float = 0.0  # N s/m, at rest
    peak_speed: float = math.inf  # m/s, of the greatest damper force

    @property
    @abstractmethod
    def least_force(self) -> float:
        """Force below which the law does not hold [N]."""

    @property
    @abstractmethod
    def slack_force(self) -> float:
        """Force below which the transmission is slack in any motion [N]; -inf where that is unknown."""

    @abstractmethod
    def deflection(self, force: float) -> float:
        """Deflection at rest under a force [m]."""

    @abstractmethod
    def force(self, deflection: float) -> float:
        """Force at rest at a deflection [N]."""

    @abstractmethod
    def stiffness(self, force: float) -> float:
        """Stiffness under a force [N/m]."""

    @abstractmethod
    def stiffness_at(self, deflection: float) -> float:
        """Stiffness at a deflection [N/m]."""

    @abstractmethod
    def slope_at(self, deflection: float) -> float:
        """Slope of ln stiffness over the deflection [1/m]."""

    @abstractmethod
    def position_variance(self, force: float) -> float:
        """Variance of ln stiffness, predicted from the deflection at which the spring bears `force`."""

    @abstractmethod
    def force_variance(self, force: float) -> float:
        """Variance of ln stiffness, predicted from the force."""

    def damper(self, velocity: float) -> float:
        """Force of the damper without dry friction [N], eq. (5); constant beyond its maximum."""
        v = min(max(velocity, -self.peak_speed), self.peak_speed)
        return self.damping * v * (1.0 - (v / self.peak_speed) ** 2 / 3.0)

    @property
    def damper_max(self) -> float:
        """Greatest force of the damper [N]; 0 where the peak speed is unknown."""
        return 2.0 / 3.0 * self.damping * self.peak_speed if math.isfinite(self.peak_speed) else 0.0


@dataclass(frozen=True)
class ExponentialSpring(Spring):
    """Exponential law with the covariance of (ln_stiffness, k2).

    At rest F = F0 + sigma / k2 and sigma = exp(ln sigma_r + k2 (x - x_r)), eqs. (2) and (3).
    """

    deflection_reference: float  # m
    ln_stiffness: float  # of N/m, at the reference
    k2: float  # 1/m
    force_offset: float  # N
    ln_stiffness_variance: float = 0.0
    k2_variance: float = 0.0
    covariance: float = 0.0  # 1/m
    force_offset_variance: float = 0.0  # N^2
    force_offset_covariance: float = 0.0  # with k2 [N/m]

    @property
    def least_force(self) -> float:
        return self.force_offset

    @property
    def slack_force(self) -> float:
        return self.force_offset - self.damper_max

    def deflection(self, force: float) -> float:
        elastic = max(force - self.force_offset, MIN_ELASTIC_FORCE)
        return self.deflection_reference + (math.log(self.k2 * elastic) - self.ln_stiffness) / self.k2

    def force(self, deflection: float) -> float:
        return self.force_offset + self.stiffness_at(deflection) / self.k2

    def stiffness(self, force: float) -> float:
        return self.k2 * max(force - self.force_offset, MIN_ELASTIC_FORCE)

    def stiffness_at(self, deflection: float) -> float:
        return math.exp(self.ln_stiffness + self.k2 * (deflection - self.deflection_reference))

    def slope_at(self, deflection: float) -> float:
        return self.k2

    def position_variance(self, force: float) -> float:
        dx = self.deflection(force) - self.deflection_reference
        return max(0.0, self.ln_stiffness_variance + 2.0 * dx * self.covariance + dx * dx * self.k2_variance)

    def force_variance(self, force: float) -> float:
        by_k2, by_offset = 1.0 / self.k2, -1.0 / max(force - self.force_offset, MIN_ELASTIC_FORCE)
        squares = by_k2**2 * self.k2_variance + by_offset**2 * self.force_offset_variance
        return max(0.0, squares + 2.0 * by_k2 * by_offset * self.force_offset_covariance)


Springs = tuple[Spring, Spring]  # transmission_1, transmission_2


def position_variance(spring: Spring, force: float) -> float:
    """`Spring.position_variance`."""
    return spring.position_variance(force)


def force_variance(spring: Spring, force: float) -> float:
    """`Spring.force_variance`."""
    return spring.force_variance(force)
