"""Joint impedance with its variances, in plain floats: this runs once a sample.

The derivatives are those of `reflection.consistent` and `reflection.paper`. An error of the radius or of the
tendon stiffness is one error for both sides (one capstan, one kind of rope): its effects add before they are squared.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from vsa_joint.impedance.reflection import LEAST_DAMPING, VALID_SHARE, Joint, TendonPath

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


@dataclass(frozen=True, slots=True)
class RouteStd:
    """Standard deviations of a side's capstan radius [m] and tendon stiffness [N/m]."""

    radius: float = 0.0
    tendon_stiffness: float = 0.0


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


Gradient = tuple[float, float, float, float, float]  # by stiffness, damping, inertia, tendon stiffness, radius
Branch = tuple[float, Gradient, float, Gradient, float, Gradient, float, float]


def reflect(
    rods: tuple[ImpedanceEstimate, ImpedanceEstimate],
    joint: Joint,
    std: tuple[RouteStd, RouteStd],
    branch: Callable[[ImpedanceEstimate, TendonPath], Branch],
) -> Reflected:
    """Joint impedance with variances; `branch` is `consistent_branch` or `paper_branch`."""
    stiffness, damping, inertia = 0.0, joint.damping, joint.inertia
    variances, shared = [0.0, 0.0, 0.0], [0.0] * 6
    mass_term = maxwell_term = 0.0
    corner = float("inf")
    for rod, route, error in zip(rods, joint.routes, std, strict=True):
        k, k_slope, d, d_slope, j, j_slope, mass, maxwell = branch(rod, route)
        stiffness, damping, inertia = stiffness + k, damping + d, inertia + j
        for row, slope in enumerate((k_slope, d_slope, j_slope)):
            variances[row] += _quadratic(rod, slope)
            shared[2 * row] += slope[3] * error.tendon_stiffness
            shared[2 * row + 1] += slope[4] * error.radius
        mass_term, maxwell_term = mass_term + mass, maxwell_term + maxwell
        corner = min(corner, (4.0 * route.tendon_stiffness + rod.stiffness) / max(rod.damping, LEAST_DAMPING))
    k_var, d_var, j_var = (variances[row] + shared[2 * row] ** 2 + shared[2 * row + 1] ** 2 for row in range(3))
    limit = VALID_SHARE * corner / TURN
    return Reflected(stiffness, k_var, damping, d_var, inertia, j_var, limit, mass_term, maxwell_term)


def consistent_branch(rod: ImpedanceEstimate, route: TendonPath) -> Branch:
    """What one side adds to the joint by virtual work, with derivatives."""
    sigma, d, m, kt, r = rod.stiffness, rod.damping, rod.inertia, route.tendon_stiffness, route.radius
    b = 4.0 * kt + sigma
    r2 = r * r
    per_b = 1.0 / b
    g = 4.0 * kt * kt * per_b * per_b
    r2g = r2 * g
    fall = -2.0 * r2g * per_b  # of g with stiffness
    rise = 8.0 * r2 * kt * sigma * per_b**3  # of g with tendon stiffness
    stiffness, damping, mass, maxwell = r2 * sigma * kt * per_b, r2g * d, r2g * m, r2g * d * d * per_b
    by_tendon = rise * m + r2 * d * d * (16.0 * kt * kt - 8.0 * kt * sigma) * per_b**4
    return (
        stiffness,
        (r2g, 0.0, 0.0, r2 * (sigma * per_b) ** 2, 2.0 * stiffness / r),
        damping,
        (fall * d, r2g, 0.0, rise * d, 2.0 * damping / r),
        mass - maxwell,
        (fall * m + 3.0 * maxwell * per_b, fall * d, r2g, by_tendon, 2.0 * (mass - maxwell) / r),
        mass,
        maxwell,
    )


def paper_branch(rod: ImpedanceEstimate, route: TendonPath) -> Branch:
    """What one side adds to the joint by (11), (12) and (13) as printed, with derivatives."""
    stiffness, stiffness_slope, _, _, _, _, mass, maxwell = consistent_branch(rod, route)
    r, half = route.radius, 0.5 * route.radius**2
    damping, inertia = half * rod.damping, half * rod.inertia
    damping_slope = (0.0, half, 0.0, 0.0, 2.0 * damping / r)
    inertia_slope = (0.0, 0.0, half, 0.0, 2.0 * inertia / r)
    return stiffness, stiffness_slope, damping, damping_slope, inertia, inertia_slope, mass, maxwell


def _quadratic(rod: ImpedanceEstimate, slope: Gradient) -> float:
    """slope' C slope with the rod's covariance C."""
    a, b, c = slope[0], slope[1], slope[2]
    cross = (
        a * b * rod.stiffness_damping_covariance
        + a * c * rod.stiffness_inertia_covariance
        + b * c * rod.damping_inertia_covariance
    )
    squares = a * a * rod.stiffness_variance + b * b * rod.damping_variance + c * c * rod.inertia_variance
    return max(0.0, squares + 2.0 * cross)
