"""What the estimators have learned of the springs, and its inverse: which forces give which joint stiffness.

At rest F = F0 + sigma / k2 and sigma = exp(ln sigma_r + k2 (x - x_r)), equations (2) and (3). Under an external
torque tau the rods bear R2 F2 = R1 F1 + 2 tau; along that line stiffness grows with force, so bisection finds it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from vsa_joint.impedance.reflection import Joint, branch_stiffness
from vsa_joint.settings import Limits

BISECTIONS = 40
LEAST_ELASTIC = 1e-3  # N, keeps logarithms finite


@dataclass(frozen=True)
class Spring:
    """Law of one transmission at rest, with the covariance of (ln_stiffness, k2)."""

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
        """Where the rod bears `force` [m]."""
        elastic = max(force - self.force_offset, LEAST_ELASTIC)
        return self.deflection_reference + (math.log(self.k2 * elastic) - self.ln_stiffness) / self.k2

    def force(self, deflection: float) -> float:
        """Rod force at a deflection [N]."""
        return self.force_offset + self.stiffness_at(deflection) / self.k2

    def stiffness(self, force: float) -> float:
        """Stiffness under a rod force [N/m], equation (3)."""
        return self.k2 * max(force - self.force_offset, LEAST_ELASTIC)

    def stiffness_at(self, deflection: float) -> float:
        """Stiffness at a deflection [N/m]."""
        return math.exp(self.ln_stiffness + self.k2 * (deflection - self.deflection_reference))

    def damper(self, velocity: float) -> float:
        """Force of the damper without its dry part [N], equation (5); held beyond its maximum."""
        v = min(max(velocity, -self.peak_speed), self.peak_speed)
        return self.damping * v * (1.0 - (v / self.peak_speed) ** 2 / 3.0)

    @property
    def damper_most(self) -> float:
        """Greatest force of the damper [N]; 0 where none is known."""
        return 2.0 / 3.0 * self.damping * self.peak_speed if math.isfinite(self.peak_speed) else 0.0

    def relative_variance(self, force: float) -> float:
        """Variance of the logarithm of the stiffness, known by the place, where the rod bears `force`."""
        dx = self.deflection(force) - self.deflection_reference
        return max(0.0, self.ln_stiffness_variance + 2.0 * dx * self.covariance + dx * dx * self.k2_variance)

    def law_variance(self, force: float) -> float:
        """Variance of the logarithm of the stiffness, known by the force, equation (3)."""
        by_k2, by_offset = 1.0 / self.k2, -1.0 / max(force - self.force_offset, LEAST_ELASTIC)
        squares = by_k2**2 * self.k2_variance + by_offset**2 * self.force_offset_variance
        return max(0.0, squares + 2.0 * by_k2 * by_offset * self.force_offset_covariance)


Springs = tuple[Spring, Spring]


@dataclass(frozen=True)
class Range:
    """Joint stiffness within reach [N m/rad] and the forces of transmission_1 at its ends [N]."""

    stiffness_min: float
    stiffness_max: float
    force_min: float
    force_max: float

    def __contains__(self, stiffness: object) -> bool:
        return isinstance(stiffness, float) and self.stiffness_min <= stiffness <= self.stiffness_max


def partner_force(force: float, torque: float, joint: Joint) -> float:
    """Rod force of transmission_2 when transmission_1 bears `force` and the joint `torque` from outside [N]."""
    first, second = joint.routes
    return (first.radius * force + 2.0 * torque) / second.radius


def stiffness_at(force: float, torque: float, springs: Springs, joint: Joint) -> float:
    """Joint stiffness at a rod force of transmission_1 [N m/rad]."""
    forces = (force, partner_force(force, torque, joint))
    return sum(
        route.radius**2 * branch_stiffness(spring.stiffness(f), route.tendon_stiffness)
        for f, spring, route in zip(forces, springs, joint.routes, strict=True)
    )


def relative_std(
    force: float,
    torque: float,
    springs: Springs,
    joint: Joint,
    of: Callable[[Spring, float], float] = Spring.relative_variance,
) -> float:
    """Predicted relative standard deviation of the joint stiffness at a rod force of transmission_1.

    `of` is the variance of a spring's ln stiffness: by its place, or `Spring.law_variance` by its force.
    """
    forces = (force, partner_force(force, torque, joint))
    total = variance = 0.0
    for f, spring, route in zip(forces, springs, joint.routes, strict=True):
        sigma = spring.stiffness(f)
        branch = route.radius**2 * branch_stiffness(sigma, route.tendon_stiffness)
        share = 4.0 * route.tendon_stiffness / (sigma + 4.0 * route.tendon_stiffness)
        total += branch
        variance += (branch * share) ** 2 * of(spring, f)
    return math.sqrt(variance) / total


def reachable(torque: float, springs: Springs, joint: Joint, limits: Limits) -> Range | None:
    """Stiffness within reach under an external torque [N m]; None where even one value is out of reach."""
    first, second = springs
    (route_1, route_2), margin = joint.routes, limits.slack_margin

    def of_partner(force_2: float) -> float:
        return (route_2.radius * force_2 - 2.0 * torque) / route_1.radius

    def most(spring: Spring) -> float:
        return min(limits.force_max, spring.force(limits.deflection_max))

    low = max(first.force_offset + margin, of_partner(second.force_offset + margin))
    high = min(most(first), of_partner(most(second)))
    if low >= high:
        return None
    return Range(stiffness_at(low, torque, springs, joint), stiffness_at(high, torque, springs, joint), low, high)


def force_for(stiffness: float, torque: float, springs: Springs, joint: Joint, within: Range) -> float:
    """Rod force of transmission_1 that gives a joint stiffness [N]; the nearest end of the range outside it."""
    low, high = within.force_min, within.force_max
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if stiffness_at(middle, torque, springs, joint) < stiffness:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def tendon_travel(force: float, deflection: float, tendon_stiffness: float) -> float:
    """Motor tendon travel with the joint at zero angle [m]: the rod's twice, and what the tendon stretches."""
    return 2.0 * deflection + force / (2.0 * tendon_stiffness)


class Learned(Protocol):
    """What a spring is read from: EstimatorState, or the estimator's own state."""

    deflection_reference: float
    ln_stiffness_reference: float
    k2: float
    d1: float
    d2: float
    force_offset: float
    coefficient_covariance: Sequence[float]


def learned_spring(state: Learned) -> Spring | None:
    """Spring from an estimator's state; None where its numbers make none."""
    covariance = state.coefficient_covariance
    numbers = (state.ln_stiffness_reference, state.k2, state.force_offset, *covariance)
    if (
        not all(math.isfinite(number) for number in numbers)
        or state.k2 <= 0.0
        or abs(state.ln_stiffness_reference) > 50.0
    ):
        return None
    peak = math.sqrt(state.d1 / (-3.0 * state.d2)) if state.d1 > 0.0 > state.d2 else math.inf
    return Spring(
        state.deflection_reference,
        state.ln_stiffness_reference,
        state.k2,
        state.force_offset,
        covariance[0],
        covariance[8],
        covariance[1],
        max(state.d1, 0.0),
        peak,
        covariance[40],
        covariance[12],
    )
