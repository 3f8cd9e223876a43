# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Exponential spring, eqs. (2) and (3): ln sigma = s + k2 dx and F - F0 = sigma / k2, dx = x - reference.

A different elastic law with two parameters replaces this module alone: the other modules take stiffness, force and
derivatives from here.
"""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.state import K2, S, X
from vsa_estimator.tuning.force_law import MAX_LN_STIFFNESS, MIN_LN_STIFFNESS


@compiled
def ln_stiffness(s: float, k2: float, dx: float) -> float:
    """Natural logarithm of the stiffness in N/m, eq. (3), `dx` [m] from the reference; limited against overflow."""
    return min(max(s + k2 * dx, MIN_LN_STIFFNESS), MAX_LN_STIFFNESS)


@compiled
def stiffness(s: float, k2: float, dx: float) -> float:
    """Stiffness sigma [N/m], eq. (3), `dx` [m] from the reference."""
    return float(np.exp(ln_stiffness(s, k2, dx)))


@compiled
def elastic_force(sigma: float, k2: float) -> float:
    """Elastic force [N] at the stiffness `sigma` [N/m], eq. (3)."""
    return sigma / k2


@compiled
def elastic_gradient(sigma: float, k2: float, dx: float) -> tuple[float, float, float]:
    """Derivatives of the elastic force by x, s and k2."""
    return sigma, sigma / k2, sigma / k2 * (dx - 1.0 / k2)


@compiled
def ln_stiffness_gradient(k2: float, dx: float) -> tuple[float, float, float]:
    """Derivatives of ln sigma by x, s and k2."""
    return k2, 1.0, dx


@compiled
def add_elastic_hessian(sigma: float, k2: float, dx: float, hessian: Array) -> None:
    """Second derivatives of the elastic force, into the upper triangle of `hessian` (10 x 10)."""
    hessian[X, X] = sigma * k2
    hessian[X, S] = sigma
    hessian[X, K2] = sigma * dx
    hessian[S, S] = sigma / k2
    hessian[S, K2] = sigma * (dx / k2 - 1.0 / k2**2)
    hessian[K2, K2] = sigma * (dx * dx / k2 - 2.0 * dx / k2**2 + 2.0 / k2**3)


@compiled
def ln_stiffness_ratio(k2: float, stroke: float) -> float:
    """ln of the stiffness ratio between the ends of a `stroke` [m]: the observability of k2."""
    return k2 * stroke


@compiled
def compliance_at_reference(s: float) -> float:
    """1 / sigma at the reference [m/N]."""
    return float(np.exp(-s))


def relative_stiffness(k2: Array, dx: Array) -> Array:
    """Stiffness relative to that at the reference, exp(k2 dx), elementwise with broadcasting; limited."""
    return np.asarray(np.exp(np.clip(k2 * dx, MIN_LN_STIFFNESS, MAX_LN_STIFFNESS)))


def s_from_force(force: float, k2: float, dx: float) -> float:
    """State s from an elastic `force` [N] measured at dx [m], eq. (3)."""
    return float(np.log(k2 * force) - k2 * dx)


def s_covariance(force: float, force_std: float, k2: float, k2_std: float, dx: float) -> tuple[float, float, float]:
    """Variances of `s_from_force` and k2, and their covariance, to first order. `dx` [m] is exact."""
    k2_variance = k2_std**2
    relative = k2_std / k2
    return relative**2 + (force_std / force) ** 2 + dx * dx * k2_variance, k2_variance, -dx * k2_variance


def deflection_shift(k2: float, ratio: float) -> float:
    """Shift dx [m] of the deflection whose change of the elastic force is `ratio` [m] times sigma.

    The inverse of ratio = -(1 - exp(-k2 dx)) / k2. Raises ValueError where k2 ratio <= -1.
    """
    return -math.log1p(k2 * ratio) / k2
