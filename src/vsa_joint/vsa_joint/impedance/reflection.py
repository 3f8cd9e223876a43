# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance at the joint of tendons and transmissions in series, eqs. (10) to (13).

The moving pulley doubles the tendon tension and halves the tendon's travel: F = 2 T, R theta = 2 x + T / K_t.
With Z = M s^2 + D s + sigma of each transmission, virtual work gives the joint

    Z_theta(s) = sum R^2 Z K_t / (4 K_t + Z) + D_joint s + J_joint s^2.

`virtual_work` is its expansion in s; `as_printed` is (12) and (13) as printed, twice the terms of a rigid tendon.
"""

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.tuning import MIN_DAMPING, VALID_SHARE

Quantity = TypeVar("Quantity", float, NDArray[np.float64], NDArray[np.complex128])


@dataclass(frozen=True, slots=True)
class Impedance:
    """Stiffness, damping, inertia: of a transmission in N/m, N s/m, kg; of the joint in N m/rad, N m s/rad, kg m^2."""

    stiffness: float
    damping: float
    inertia: float


Transmissions = tuple[Impedance, Impedance]  # transmission_1, transmission_2


def branch_stiffness(transmission: float, tendon: float) -> float:
    """Stiffness of one tendon with its transmission in series [N/m], eq. (10).

    >>> branch_stiffness(4000.0, 1000.0)
    500.0
    """
    return transmission * tendon / (transmission + 4.0 * tendon)


def joint_stiffness(stiffness: tuple[float, float], joint: Joint) -> float:
    """Stiffness of the joint [N m/rad] for the stiffness of both transmissions [N/m], eq. (11)."""
    return sum(
        path.radius**2 * branch_stiffness(sigma, path.tendon_stiffness)
        for sigma, path in zip(stiffness, joint.paths, strict=True)
    )


def branch_at_joint(transmission: Quantity, radius: float, tendon: float) -> Quantity:
    """Term of one transmission in eq. (11): its stiffness [N/m] or impedance Z(s), seen from the joint [N m/rad]."""
    return radius**2 * transmission * tendon / (4.0 * tendon + transmission)


def virtual_work(transmissions: Transmissions, joint: Joint) -> Impedance:
    """Stiffness, damping and inertia of the joint by virtual work; valid up to `valid_frequency`."""
    mass, maxwell = inertia_terms(transmissions, joint)
    damping = sum(
        path.radius**2 * _squared_travel_ratio(transmission, path) * transmission.damping
        for transmission, path in zip(transmissions, joint.paths, strict=True)
    )
    stiffness = joint_stiffness((transmissions[0].stiffness, transmissions[1].stiffness), joint)
    return Impedance(stiffness, damping + joint.damping, mass - maxwell + joint.inertia)


def as_printed(transmissions: Transmissions, joint: Joint) -> Impedance:
    """Eqs. (11), (12), (13) as printed: the terms of damping and inertia are twice those of a rigid tendon."""
    pairs = list(zip(transmissions, joint.paths, strict=True))
    damping = sum(0.5 * path.radius**2 * transmission.damping for transmission, path in pairs)
    inertia = sum(0.5 * path.radius**2 * transmission.inertia for transmission, path in pairs)
    stiffness = joint_stiffness((transmissions[0].stiffness, transmissions[1].stiffness), joint)
    return Impedance(stiffness, damping + joint.damping, inertia + joint.inertia)


def inertia_terms(transmissions: Transmissions, joint: Joint) -> tuple[float, float]:
    """Mass term and Maxwell term (damper and tendon in series) of the joint's inertia, mass - Maxwell [kg m^2]."""
    mass = maxwell = 0.0
    for transmission, path in zip(transmissions, joint.paths, strict=True):
        total = 4.0 * path.tendon_stiffness + transmission.stiffness
        mass += path.radius**2 * _squared_travel_ratio(transmission, path) * transmission.inertia
        maxwell += path.radius**2 * _squared_travel_ratio(transmission, path) * transmission.damping**2 / total
    return mass, maxwell


def valid_frequency(transmissions: Transmissions, joint: Joint) -> float:
    """Frequency up to which `virtual_work` describes the joint [Hz]; above it, the tendon bypasses the spring."""
    corner = min(
        (4.0 * path.tendon_stiffness + transmission.stiffness) / max(transmission.damping, MIN_DAMPING)
        for transmission, path in zip(transmissions, joint.paths, strict=True)
    )
    return VALID_SHARE * corner / (2.0 * math.pi)


def response(frequency: ArrayLike, transmissions: Transmissions, joint: Joint) -> NDArray[np.complex128]:
    """Z_theta(j w), torque over angle [N m/rad], at each `frequency` [Hz]; same shape as `frequency`."""
    s = 2j * np.pi * np.asarray(frequency, dtype=float)
    total: NDArray[np.complex128] = joint.inertia * s**2 + joint.damping * s
    for transmission, path in zip(transmissions, joint.paths, strict=True):
        impedance = transmission.inertia * s**2 + transmission.damping * s + transmission.stiffness
        total = total + branch_at_joint(impedance, path.radius, path.tendon_stiffness)
    return total


def _squared_travel_ratio(transmission: Impedance, path: TendonPath) -> float:
    """Square of the deflection per tendon travel at low frequency: 1/4 for a rigid tendon."""
    return (2.0 * path.tendon_stiffness / (4.0 * path.tendon_stiffness + transmission.stiffness)) ** 2
