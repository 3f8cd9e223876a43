"""Tendon tensions split into the part that moves the joint and the part that stiffens it.

With A = [R1, -R2] the joint feels the torque A T. The internal part n n' T, n = [R2, R1] / |R|, gives no torque;
the motion part A' A T / |R|^2 gives all of it. For equal radii the internal part is the mean tension on both sides.
"""

from typing import NamedTuple


class TensionSplit(NamedTuple):
    """Internal tension [N], motion torque [N m], the smaller tension [N], and variances."""

    internal_force: float
    internal_force_variance: float
    motion_torque: float
    motion_torque_variance: float
    co_contraction: float
    co_contraction_variance: float


def internal_part(tension: tuple[float, float], radius: tuple[float, float]) -> tuple[float, float]:
    """Tensions that give no torque, one a side [N]."""
    r1, r2 = radius
    amplitude = (r2 * tension[0] + r1 * tension[1]) / (r1 * r1 + r2 * r2)
    return r2 * amplitude, r1 * amplitude


def motion_part(tension: tuple[float, float], radius: tuple[float, float]) -> tuple[float, float]:
    """Tensions that give all the torque, one a side [N]."""
    r1, r2 = radius
    amplitude = (r1 * tension[0] - r2 * tension[1]) / (r1 * r1 + r2 * r2)
    return r1 * amplitude, -r2 * amplitude


def unloaded_force(tension: tuple[float, float], radius: tuple[float, float]) -> float:
    """Rod force of transmission_1 that is left when the tendons bear no torque [N].

    >>> unloaded_force((20.0, 30.0), (0.02, 0.02))
    50.0
    """
    return 2.0 * internal_part(tension, radius)[0]


def split(
    tension: tuple[float, float],
    variance: tuple[float, float],
    radius: tuple[float, float],
    radius_std: tuple[float, float],
) -> TensionSplit:
    """Split tensions [N]; `internal_force` is the mean of the internal part over both sides."""
    (t1, t2), (v1, v2), (r1, r2) = tension, variance, radius
    scale = 0.5 * (r1 + r2) / (r1 * r1 + r2 * r2)
    radius_effect = t1 * radius_std[0] - t2 * radius_std[1]
    smaller = 0 if t1 <= t2 else 1
    return TensionSplit(
        internal_force=scale * (r2 * t1 + r1 * t2),
        internal_force_variance=scale * scale * (r2 * r2 * v1 + r1 * r1 * v2),
        motion_torque=r1 * t1 - r2 * t2,
        motion_torque_variance=r1 * r1 * v1 + r2 * r2 * v2 + radius_effect * radius_effect,
        co_contraction=tension[smaller],
        co_contraction_variance=variance[smaller],
    )
