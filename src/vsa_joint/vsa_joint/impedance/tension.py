# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tendon tensions, split into internal part (co-contraction) and motion part.

With A = [R1, -R2] the tendons exert the torque A T. The internal part n n' T, n = [R2, R1] / |R|, exerts no torque;
the motion part A' A T / |R|^2 exerts all of it. For equal radii the internal part is the mean tension of both tendons.
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
    """Tensions without torque, one per transmission [N]."""
    r1, r2 = radius
    amplitude = (r2 * tension[0] + r1 * tension[1]) / (r1 * r1 + r2 * r2)
    return r2 * amplitude, r1 * amplitude


def unloaded_force(tension: tuple[float, float], radius: tuple[float, float]) -> float:
    """Force of transmission_1 with the same internal part and no torque [N]: twice its tension.

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
    """Split tensions [N] with variances [N^2] and radii [m]; `internal_force` is the mean of the internal part."""
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
