# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force law, eqs. (2) to (6), over a segment: columns of the regression, their derivatives, slopes and weights.

Coefficients are theta = [k2 q F0 d0 d1 d2 M], SI, where q = k1 exp(k2 reference) is the spring's force at the
`reference` deflection [m].
"""

import numpy as np
from vsa_common.damper import peak_speed
from vsa_common.types import Array
from vsa_estimator.offline.segments import Segment

K2, Q, F0, D0, D1, D2, M = range(7)


def columns_and_residual(segment: Segment, theta: Array, reference: float) -> tuple[Array, Array]:
    """Derivatives of the force by all coefficients (samples, 7), and measured minus modelled force (samples,) [N]."""
    columns = force_columns(segment, theta, reference)
    return columns, segment.force - columns[:, 1:] @ theta[1:]


def force_columns(segment: Segment, theta: Array, reference: float) -> Array:
    """Derivatives of the force by all coefficients (samples, 7)."""
    dx = segment.deflection - reference
    growth = np.exp(theta[K2] * dx)
    clipped, _ = _clipped_velocity(segment, theta)
    friction, ones = np.sign(segment.velocity), np.ones_like(dx)
    cubic = clipped**3 - 3.0 * clipped * segment.motion_covariance[:, 1, 1]  # noise biases the cube of a velocity
    return np.stack([theta[Q] * dx * growth, growth, ones, friction, clipped, cubic, segment.acceleration], axis=1)


def column_slopes(segment: Segment, theta: Array, reference: float) -> Array:
    """Derivatives of the columns by deflection, velocity and acceleration (samples, 7, 3)."""
    dx = segment.deflection - reference
    growth = np.exp(theta[K2] * dx)
    clipped, below = _clipped_velocity(segment, theta)
    result = np.zeros((len(dx), 7, 3))
    result[:, K2, 0] = theta[Q] * growth * (1.0 + theta[K2] * dx)
    result[:, Q, 0] = theta[K2] * growth
    result[:, D1, 1] = below
    result[:, D2, 1] = 3.0 * clipped**2 * below
    result[:, M, 2] = 1.0
    return result


def impedance(segment: Segment, theta: Array, reference: float) -> tuple[Array, Array, Array]:
    """Stiffness, damping and inertia at each sample, SI: slopes of the force by the motion."""
    clipped, below = _clipped_velocity(segment, theta)
    stiffness = theta[K2] * theta[Q] * np.exp(theta[K2] * (segment.deflection - reference))
    return stiffness, (theta[D1] + 3.0 * theta[D2] * clipped**2) * below, np.full_like(clipped, theta[M])


def weights_and_slopes(segment: Segment, theta: Array, reference: float) -> tuple[Array, Array]:
    """Weights (samples, 1), and their derivatives by deflection, velocity and acceleration (samples, 3).

    R_w of eq. (19) is the noise of force and, through stiffness, damping and inertia, of motion; the weight decreases
    to zero at low speed.
    """
    stiffness, damping, inertia = slopes = impedance(segment, theta, reference)
    by = np.einsum("iab,bi->ai", segment.motion_covariance, np.stack(slopes))
    weights = 1.0 / (segment.force_noise**2 + stiffness * by[0] + damping * by[1] + inertia * by[2])
    clipped, below = _clipped_velocity(segment, theta)
    r = np.clip(np.abs(segment.velocity) / segment.min_speed - 1.0, 0.0, 1.0)
    taper = r * r * (3.0 - 2.0 * r)
    taper_slope = 6.0 * r * (1.0 - r) / segment.min_speed * np.sign(segment.velocity)
    by_deflection = -2.0 * theta[K2] * stiffness * by[0] * weights**2 * taper
    by_velocity = -12.0 * theta[D2] * clipped * below * by[1] * weights**2 * taper + weights * taper_slope
    return (weights * taper)[:, None], np.stack([by_deflection, by_velocity, np.zeros_like(taper)], axis=1)


def _clipped_velocity(segment: Segment, theta: Array) -> tuple[Array, Array]:
    """Velocity clipped at v*, where the damper's force is greatest; one where it is below v*, zero elsewhere.

    theta can pass through d2 >= 0, where v* is infinite.
    """
    limit = peak_speed(float(theta[D1]), float(theta[D2]))
    return np.clip(segment.velocity, -limit, limit), (np.abs(segment.velocity) < limit).astype(float)
