"""Impedance at the joint of tendons and transmissions in series, equations (10) to (13).

The moving pulley makes the rod force twice the tendon tension and the deflection half the tendon's
travel (F = 2 T, R theta = 2 x + T / K_t). With Z = M s^2 + D s + sigma of each transmission, virtual
work gives the joint

    Z_theta(s) = sum R^2 Z K_t / (4 K_t + Z) + D_joint s + J_joint s^2.

Its expansion in s is `virtual_work`; `as_printed` is (12) and (13) as printed, twice a rigid tendon's.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

VALID_SHARE = 0.1  # of the corner frequency, where the damping of the expansion is 1 % wrong
LEAST_DAMPING = 1e-6  # N s/m, keeps the corner frequency finite


@dataclass(frozen=True, slots=True)
class Impedance:
    """Stiffness, damping and inertia: N/m, N s/m, kg of a rod; N m/rad, N m s/rad, kg m^2 of the joint."""

    stiffness: float
    damping: float
    inertia: float


@dataclass(frozen=True, slots=True)
class TendonPath:
    """How one transmission reaches the joint: capstan radius [m] and tendon stiffness [N/m]."""

    radius: float
    tendon_stiffness: float


@dataclass(frozen=True, slots=True)
class Joint:
    """Both routes, and the joint's own damping [N m s/rad] and inertia [kg m^2]."""

    routes: tuple[TendonPath, TendonPath]
    damping: float = 0.0
    inertia: float = 0.0


Sides = tuple[Impedance, Impedance]


def branch_stiffness(transmission: float, tendon: float) -> float:
    """Stiffness of one tendon with its transmission in series [N/m], equation (10).

    >>> branch_stiffness(4000.0, 1000.0)
    500.0
    """
    return transmission * tendon / (transmission + 4.0 * tendon)


def joint_stiffness(sides: Sides, joint: Joint) -> float:
    """Stiffness of the joint [N m/rad], equation (11)."""
    return sum(
        route.radius**2 * branch_stiffness(side.stiffness, route.tendon_stiffness)
        for side, route in zip(sides, joint.routes, strict=True)
    )


def virtual_work(sides: Sides, joint: Joint) -> Impedance:
    """Stiffness, damping and inertia of the joint by virtual work; they hold up to `valid_frequency`."""
    mass, maxwell = inertia_terms(sides, joint)
    damping = sum(
        route.radius**2 * _share(side, route) * side.damping for side, route in zip(sides, joint.routes, strict=True)
    )
    return Impedance(joint_stiffness(sides, joint), damping + joint.damping, mass - maxwell + joint.inertia)


def as_printed(sides: Sides, joint: Joint) -> Impedance:
    """Equations (11), (12) and (13) as printed: the branch terms of damping and inertia are twice a rigid tendon's."""
    pairs = list(zip(sides, joint.routes, strict=True))
    damping = sum(0.5 * route.radius**2 * side.damping for side, route in pairs)
    inertia = sum(0.5 * route.radius**2 * side.inertia for side, route in pairs)
    return Impedance(joint_stiffness(sides, joint), damping + joint.damping, inertia + joint.inertia)


def inertia_terms(sides: Sides, joint: Joint) -> tuple[float, float]:
    """What the rods' mass adds to the joint's inertia, and what damper and tendon in series take off [kg m^2]."""
    mass = maxwell = 0.0
    for side, route in zip(sides, joint.routes, strict=True):
        total = 4.0 * route.tendon_stiffness + side.stiffness
        mass += route.radius**2 * _share(side, route) * side.inertia
        maxwell += route.radius**2 * _share(side, route) * side.damping**2 / total
    return mass, maxwell


def valid_frequency(sides: Sides, joint: Joint) -> float:
    """Frequency up to which `virtual_work` describes the joint [Hz]; above, the tendon bypasses the spring."""
    corner = min(
        (4.0 * route.tendon_stiffness + side.stiffness) / max(side.damping, LEAST_DAMPING)
        for side, route in zip(sides, joint.routes, strict=True)
    )
    return VALID_SHARE * corner / (2.0 * math.pi)


def response(frequency: ArrayLike, sides: Sides, joint: Joint) -> NDArray[np.complex128]:
    """Z_theta(j w), torque over angle [N m/rad] at each `frequency` [Hz]."""
    s = 2j * np.pi * np.asarray(frequency, dtype=float)
    total = joint.inertia * s**2 + joint.damping * s
    for side, route in zip(sides, joint.routes, strict=True):
        rod = side.inertia * s**2 + side.damping * s + side.stiffness
        total = total + route.radius**2 * rod * route.tendon_stiffness / (4.0 * route.tendon_stiffness + rod)
    return total


def _share(side: Impedance, route: TendonPath) -> float:
    """Square of the rod's travel per tendon travel at low frequency: 1/4 for a rigid tendon."""
    return (2.0 * route.tendon_stiffness / (4.0 * route.tendon_stiffness + side.stiffness)) ** 2
