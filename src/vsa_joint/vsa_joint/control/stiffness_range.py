# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Joint stiffness as a function of the force of transmission_1, its inverse, and the reachable range.

Under an external torque tau the forces of both transmissions satisfy R2 F2 = R1 F1 + 2 tau. Along that line the
stiffness increases with the force, so that bisection inverts it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from vsa_joint.control.springs import Spring, Springs, position_variance
from vsa_joint.geometry import Joint
from vsa_joint.impedance.reflection import branch_stiffness, joint_stiffness
from vsa_joint.settings import Limits
from vsa_joint.tuning import FORCE_BISECTIONS


@dataclass(frozen=True)
class StiffnessRange:
    """Reachable joint stiffness [N m/rad] and the forces of transmission_1 at its ends [N]."""

    stiffness_min: float
    stiffness_max: float
    force_min: float
    force_max: float

    def __contains__(self, stiffness: object) -> bool:
        return isinstance(stiffness, float) and self.stiffness_min <= stiffness <= self.stiffness_max


def partner_force(force: float, torque: float, joint: Joint) -> float:
    """Force of transmission_2 [N] in equilibrium with `force` of transmission_1 and an external `torque` [N m]."""
    first, second = joint.paths
    return (first.radius * force + 2.0 * torque) / second.radius


def stiffness_at(force: float, torque: float, springs: Springs, joint: Joint) -> float:
    """Joint stiffness [N m/rad] at a force of transmission_1 [N] under an external torque [N m]."""
    return stiffness_at_forces((force, partner_force(force, torque, joint)), springs, joint)


def stiffness_at_forces(forces: tuple[float, float], springs: Springs, joint: Joint) -> float:
    """Joint stiffness [N m/rad] at the forces of both transmissions [N]."""
    first, second = springs
    return joint_stiffness((first.stiffness(forces[0]), second.stiffness(forces[1])), joint)


def relative_std(
    force: float,
    torque: float,
    springs: Springs,
    joint: Joint,
    variance: Callable[[Spring, float], float] = position_variance,
) -> float:
    """Predicted relative standard deviation of the joint stiffness at a force of transmission_1.

    `variance` is that of ln stiffness of a spring: `position_variance` or `force_variance`.
    """
    forces = (force, partner_force(force, torque, joint))
    total = total_variance = 0.0
    for f, spring, path in zip(forces, springs, joint.paths, strict=True):
        sigma = spring.stiffness(f)
        branch = path.radius**2 * branch_stiffness(sigma, path.tendon_stiffness)
        sensitivity = 4.0 * path.tendon_stiffness / (sigma + 4.0 * path.tendon_stiffness)  # d ln branch / d ln sigma
        total += branch
        total_variance += (branch * sensitivity) ** 2 * variance(spring, f)
    return math.sqrt(total_variance) / total


def reachable_range(torque: float, springs: Springs, joint: Joint, limits: Limits) -> StiffnessRange | None:
    """Reachable stiffness under an external torque [N m]; None where no force satisfies the limits."""
    first, second = springs
    (path_1, path_2), margin = joint.paths, limits.slack_margin

    def of_partner(force_2: float) -> float:
        return (path_2.radius * force_2 - 2.0 * torque) / path_1.radius

    def greatest(spring: Spring) -> float:
        return min(limits.force_max, spring.force(limits.deflection_max))

    low = max(first.least_force + margin, of_partner(second.least_force + margin))
    high = min(greatest(first), of_partner(greatest(second)))
    if low >= high:
        return None
    return StiffnessRange(
        stiffness_min=stiffness_at(low, torque, springs, joint),
        stiffness_max=stiffness_at(high, torque, springs, joint),
        force_min=low,
        force_max=high,
    )


def force_for(stiffness: float, torque: float, springs: Springs, joint: Joint, reachable: StiffnessRange) -> float:
    """Force of transmission_1 [N] for a joint stiffness [N m/rad]; the nearest end for one out of range."""
    low, high = reachable.force_min, reachable.force_max
    for _ in range(FORCE_BISECTIONS):
        middle = 0.5 * (low + high)
        if stiffness_at(middle, torque, springs, joint) < stiffness:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def tendon_travel(force: float, deflection: float, tendon_stiffness: float) -> float:
    """Tendon travel at the motor with the joint at zero [m]: twice the deflection plus the tendon's elongation."""
    return 2.0 * deflection + force / (2.0 * tendon_stiffness)


def force_rate(force: float, travel_rate: float, springs: Springs, joint: Joint) -> float:
    """Rate of the force of transmission_1 [N/s] at which the faster motor winds `travel_rate` [m/s] of its tendon.

    `force` is that of transmission_1 [N]; both change without torque.
    """
    first, second = springs
    partner = partner_force(1.0, 0.0, joint)  # N per N of transmission_1
    travels = (
        tendon_travel(1.0, 1.0 / first.stiffness(force), joint.paths[0].tendon_stiffness),
        tendon_travel(partner, partner / second.stiffness(partner * force), joint.paths[1].tendon_stiffness),
    )
    return travel_rate / max(travels)
