# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force law, eqs. (2) to (6), over segments: columns of the regression, slopes, weights, and its normal equations.

Coefficients are theta = [spring F0 d0 d1 d2 M], SI, with the coefficients of the elastic law first. Positions,
velocities and accelerations are smoothed, hence noisy and coloured: the normal equations are corrected for their noise
(errors in variables), and the covariance includes it.
"""

from collections.abc import Sequence

import numpy as np
from vsa_common.damper import peak_speed
from vsa_common.types import Array
from vsa_estimator.offline.segments import Segment
from vsa_estimator.offline.springs import Spring
from vsa_estimator.tuning.offline import INDEPENDENCE_TIME

F0, D0, D1, D2, M = range(-5, 0)


def columns_and_residual(segment: Segment, theta: Array, spring: Spring) -> tuple[Array, Array]:
    """Derivatives of the force by all coefficients (samples, n), and measured minus modelled force (samples,) [N]."""
    columns = force_columns(segment, theta, spring)
    elastic = spring.force(segment.deflection, theta[:F0])
    return columns, segment.force - elastic - columns[:, F0:] @ theta[F0:]


def force_columns(segment: Segment, theta: Array, spring: Spring) -> Array:
    """Derivatives of the force by all coefficients (samples, n)."""
    clipped, _ = _clipped_velocity(segment, theta)
    friction, ones = np.sign(segment.velocity), np.ones_like(clipped)
    cubic = clipped**3 - 3.0 * clipped * segment.motion_covariance[:, 1, 1]  # noise biases the cube of a velocity
    elastic = spring.columns(segment.deflection, theta[:F0])
    return np.column_stack([elastic, ones, friction, clipped, cubic, segment.acceleration])


def column_slopes(segment: Segment, theta: Array, spring: Spring) -> Array:
    """Derivatives of the columns by deflection, velocity and acceleration (samples, n, 3)."""
    clipped, below = _clipped_velocity(segment, theta)
    result = np.zeros((len(clipped), len(theta), 3))
    result[:, :F0, 0] = spring.column_slopes(segment.deflection, theta[:F0])
    result[:, D1, 1] = below
    result[:, D2, 1] = 3.0 * clipped**2 * below
    result[:, M, 2] = 1.0
    return result


def impedance(segment: Segment, theta: Array, spring: Spring) -> tuple[Array, Array, Array]:
    """Stiffness, damping and inertia at each sample, SI: slopes of the force by the motion."""
    clipped, below = _clipped_velocity(segment, theta)
    stiffness, _ = spring.stiffness(segment.deflection, theta[:F0])
    return stiffness, (theta[D1] + 3.0 * theta[D2] * clipped**2) * below, np.full_like(clipped, theta[M])


def weights_and_slopes(segment: Segment, theta: Array, spring: Spring) -> tuple[Array, Array]:
    """Weights (samples, 1), and their derivatives by deflection, velocity and acceleration (samples, 3).

    R_w of eq. (19) is the noise of force and, through stiffness, damping and inertia, of motion; the weight decreases
    to zero at low speed.
    """
    stiffness, damping, inertia = slopes = impedance(segment, theta, spring)
    by = np.einsum("iab,bi->ai", segment.motion_covariance, np.stack(slopes))
    weights = 1.0 / (segment.force_noise**2 + stiffness * by[0] + damping * by[1] + inertia * by[2])
    clipped, below = _clipped_velocity(segment, theta)
    r = np.clip(np.abs(segment.velocity) / segment.min_speed - 1.0, 0.0, 1.0)
    taper = r * r * (3.0 - 2.0 * r)
    taper_slope = 6.0 * r * (1.0 - r) / segment.min_speed * np.sign(segment.velocity)
    _, stiffness_slope = spring.stiffness(segment.deflection, theta[:F0])
    by_deflection = -2.0 * stiffness_slope * by[0] * weights**2 * taper
    by_velocity = -12.0 * theta[D2] * clipped * below * by[1] * weights**2 * taper + weights * taper_slope
    return (weights * taper)[:, None], np.stack([by_deflection, by_velocity, np.zeros_like(taper)], axis=1)


def _clipped_velocity(segment: Segment, theta: Array) -> tuple[Array, Array]:
    """Velocity clipped at v*, where the damper's force is greatest; one where it is below v*, zero elsewhere.

    theta can pass through d2 >= 0, where v* is infinite.
    """
    limit = peak_speed(float(theta[D1]), float(theta[D2]))
    return np.clip(segment.velocity, -limit, limit), (np.abs(segment.velocity) < limit).astype(float)


def corrected_gradient(segments: Sequence[Segment], theta: Array, spring: Spring) -> Array:
    """Right-hand side (n,) of the normal equations without the expected effect of noisy motion.

    Noise e of a row's motion is in its weighted columns and, through the force's slopes, in its residual. With
    covariance C the expectation of their product is -d(weighted columns) C slopes (Stein's lemma); that is added.
    """
    gradient = np.zeros(len(theta))
    gradient[:F0] = spring.precision @ (spring.prior - theta[:F0])
    for segment in segments:
        columns, residual = columns_and_residual(segment, theta, spring)
        weights, weight_slopes = weights_and_slopes(segment, theta, spring)
        slopes = np.stack(impedance(segment, theta, spring), axis=1)
        weighted_slopes = weights[:, 0, None, None] * column_slopes(segment, theta, spring)
        weighted_slopes += columns[:, :, None] * weight_slopes[:, None, :]
        gradient += columns.T @ (weights[:, 0] * residual)
        gradient += np.einsum("ipa,iab,ib->p", weighted_slopes, segment.motion_covariance, slopes, optimize=True)
    return gradient


def normal_matrix(segments: Sequence[Segment], theta: Array, spring: Spring) -> Array:
    """Normal matrix (n, n) of eq. (19) with the prior of the spring, without the expected effect of noisy motion."""
    result = np.zeros((len(theta), len(theta)))
    result[:F0, :F0] = spring.precision
    for segment in segments:
        columns = force_columns(segment, theta, spring)
        weights = weights_and_slopes(segment, theta, spring)[0]
        slopes = column_slopes(segment, theta, spring)
        by_noise = np.einsum(
            "i,ipa,iab,iqb->pq", weights[:, 0], slopes, segment.motion_covariance, slopes, optimize=True
        )
        result += (columns * weights).T @ columns - by_noise
    return result


def covariance_of(segments: Sequence[Segment], theta: Array, spring: Spring) -> tuple[Array, float]:
    """Eq. (19) for coloured noise (n, n), scaled to the residuals; the greatest variance factor of that scaling."""
    noise, blocks = np.zeros((len(theta), len(theta))), []
    noise[:F0, :F0] = spring.precision
    for segment in segments:
        columns, residual = columns_and_residual(segment, theta, spring)
        weighted = columns * weights_and_slopes(segment, theta, spring)[0]
        operators = (segment.polynomials.value, segment.polynomials.slope, segment.polynomials.curvature)
        spread = np.zeros_like(weighted)
        for operator, slope in zip(operators, impedance(segment, theta, spring), strict=True):
            spread += segment.polynomials.transpose(operator, weighted * slope[:, None])
        noise += segment.force_noise**2 * weighted.T @ weighted + segment.deflection_noise**2 * spread.T @ spread
        edges = np.searchsorted(segment.time, np.arange(segment.time[0], segment.time[-1], INDEPENDENCE_TIME))
        blocks.append(np.add.reduceat(weighted * residual[:, None], np.unique(edges), axis=0))
    inverse = inverse_of(normal_matrix(segments, theta, spring))
    sums = np.concatenate(blocks)
    expected, observed = inverse @ noise @ inverse, inverse @ (sums.T @ sums) @ inverse
    misfit = np.maximum(1.0, np.diag(observed) / np.maximum(np.diag(expected), 1e-300))
    return expected * np.sqrt(np.outer(misfit, misfit)), float(misfit.max())


def inverse_of(normal: Array) -> Array:
    """Pseudo-inverse of a normal matrix whose columns have any units."""
    scale = np.sqrt(np.abs(np.diag(normal)))
    scale[scale == 0.0] = 1.0
    return np.asarray(
        np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-11, hermitian=True) / np.outer(scale, scale)
    )
