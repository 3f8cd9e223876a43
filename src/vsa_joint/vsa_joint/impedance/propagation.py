# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Joint impedance with its variances, in plain floats: the hot path of the joint, one call per pair.

The derivatives are those of `reflection.virtual_work` and `reflection.as_printed`. The radii have one common error and
the tendon stiffnesses have one common error (one capstan, one rope type): their effects add before they are squared.
"""

from collections.abc import Callable
from typing import NamedTuple

from vsa_joint.geometry import Joint, TendonPath, TendonPathStd
from vsa_joint.tuning import MIN_DAMPING, VALID_SHARE

TURN = 6.283185307179586  # rad


class ImpedanceEstimate(NamedTuple):
    """Impedance of one transmission with its covariance: N/m, N s/m, kg."""

    stiffness: float
    damping: float
    inertia: float
    stiffness_variance: float = 0.0
    damping_variance: float = 0.0
    inertia_variance: float = 0.0
    stiffness_damping_covariance: float = 0.0
    stiffness_inertia_covariance: float = 0.0
    damping_inertia_covariance: float = 0.0


class Reflected(NamedTuple):
    """Impedance of the joint: N m/rad, N m s/rad, kg m^2, and their variances."""

    stiffness: float
    stiffness_variance: float
    damping: float
    damping_variance: float
    inertia: float
    inertia_variance: float
    valid_frequency: float  # Hz
    mass_term: float  # kg m^2
    maxwell_term: float  # kg m^2


class Gradient(NamedTuple):
    """Derivatives by the parameters of one transmission and its tendon."""

    stiffness: float
    damping: float
    inertia: float
    tendon_stiffness: float
    radius: float


class Branch(NamedTuple):
    """Contribution of one transmission to the joint: N m/rad, N m s/rad, kg m^2, with gradients."""

    stiffness: float
    stiffness_gradient: Gradient
    damping: float
    damping_gradient: Gradient
    inertia: float
    inertia_gradient: Gradient
    mass_term: float  # kg m^2
    maxwell_term: float  # kg m^2


def reflect_to_joint(
    impedances: tuple[ImpedanceEstimate, ImpedanceEstimate],
    joint: Joint,
    std: tuple[TendonPathStd, TendonPathStd],
    branch: Callable[[ImpedanceEstimate, TendonPath], Branch],
) -> Reflected:
    """Joint impedance with variances; `branch` is `consistent_branch` or `paper_branch`."""
    stiffness, damping, inertia = 0.0, joint.damping, joint.inertia
    variances, by_tendon, by_radius = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    mass_term = maxwell_term = 0.0
    corner = float("inf")
    for impedance, path, error in zip(impedances, joint.paths, std, strict=True):
        k, k_gradient, d, d_gradient, j, j_gradient, mass, maxwell = branch(impedance, path)
        stiffness, damping, inertia = stiffness + k, damping + d, inertia + j
        for row, gradient in enumerate((k_gradient, d_gradient, j_gradient)):
            variances[row] += _variance(impedance, gradient)
            by_tendon[row] += gradient[3] * error.tendon_stiffness
            by_radius[row] += gradient[4] * error.radius
        mass_term, maxwell_term = mass_term + mass, maxwell_term + maxwell
        corner = min(corner, (4.0 * path.tendon_stiffness + impedance.stiffness) / max(impedance.damping, MIN_DAMPING))
    k_var, d_var, j_var = (variances[row] + by_tendon[row] ** 2 + by_radius[row] ** 2 for row in range(3))
    return Reflected(
        stiffness=stiffness,
        stiffness_variance=k_var,
        damping=damping,
        damping_variance=d_var,
        inertia=inertia,
        inertia_variance=j_var,
        valid_frequency=VALID_SHARE * corner / TURN,
        mass_term=mass_term,
        maxwell_term=maxwell_term,
    )


def consistent_branch(impedance: ImpedanceEstimate, path: TendonPath) -> Branch:
    """Contribution of one transmission by virtual work: the expansion of eq. (11) in s, with derivatives."""
    sigma, d, m, kt, r = impedance.stiffness, impedance.damping, impedance.inertia, path.tendon_stiffness, path.radius
    b = 4.0 * kt + sigma
    r2 = r * r
    per_b = 1.0 / b
    g = 4.0 * kt * kt * per_b * per_b
    r2g = r2 * g
    g_by_sigma = -2.0 * r2g * per_b  # of r2g
    g_by_tendon = 8.0 * r2 * kt * sigma * per_b**3  # of r2g
    stiffness, damping, mass, maxwell = r2 * sigma * kt * per_b, r2g * d, r2g * m, r2g * d * d * per_b
    by_tendon = g_by_tendon * m + r2 * d * d * (16.0 * kt * kt - 8.0 * kt * sigma) * per_b**4
    inertia_by_sigma = g_by_sigma * m + 3.0 * maxwell * per_b
    return Branch(
        stiffness,
        Gradient(r2g, 0.0, 0.0, r2 * (sigma * per_b) ** 2, 2.0 * stiffness / r),
        damping,
        Gradient(g_by_sigma * d, r2g, 0.0, g_by_tendon * d, 2.0 * damping / r),
        mass - maxwell,
        Gradient(inertia_by_sigma, g_by_sigma * d, r2g, by_tendon, 2.0 * (mass - maxwell) / r),
        mass,
        maxwell,
    )


def paper_branch(impedance: ImpedanceEstimate, path: TendonPath) -> Branch:
    """Contribution of one transmission by (11), (12) and (13) as printed, with derivatives."""
    r, half = path.radius, 0.5 * path.radius**2
    damping, inertia = half * impedance.damping, half * impedance.inertia
    return consistent_branch(impedance, path)._replace(
        damping=damping,
        damping_gradient=Gradient(0.0, half, 0.0, 0.0, 2.0 * damping / r),
        inertia=inertia,
        inertia_gradient=Gradient(0.0, 0.0, half, 0.0, 2.0 * inertia / r),
    )


def _variance(impedance: ImpedanceEstimate, gradient: Gradient) -> float:
    """g' C g with the covariance C of stiffness, damping and inertia."""
    a, b, c = gradient[0], gradient[1], gradient[2]
    cross = (
        a * b * impedance.stiffness_damping_covariance
        + a * c * impedance.stiffness_inertia_covariance
        + b * c * impedance.damping_inertia_covariance
    )
    squares = (
        a * a * impedance.stiffness_variance + b * b * impedance.damping_variance + c * c * impedance.inertia_variance
    )
    return max(0.0, squares + 2.0 * cross)
