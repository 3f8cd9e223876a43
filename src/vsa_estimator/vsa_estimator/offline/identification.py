# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Coefficients of a transmission from whole recordings, eqs. (18) and (19).

All but k2 enter the force, eqs. (2) to (6), linearly: k2 is found by nonlinear least squares over the fit of the rest
(variable projection), the rest by weighted pseudo-inverse. Positions, velocities and accelerations are smoothed, hence
noisy and coloured: the normal equations are corrected for their noise (errors in variables), and the covariance
includes it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from vsa_common.types import Array
from vsa_estimator.offline.force_model import (
    K2,
    Q,
    column_slopes,
    columns_and_residual,
    force_columns,
    impedance,
    weights_and_slopes,
)
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.offline.segments import Segment, segments_of
from vsa_estimator.tuning.offline import (
    BIAS_STEPS,
    INDEPENDENCE_TIME,
    MAX_BENDING,
    MIN_BENDING,
    MIN_SAMPLES,
    WEIGHT_STEPS,
)

NAMES = ("k2", "k1", "force_offset", "coulomb_friction", "d1", "d2", "inertia")
UNITS = ("1/m", "N", "N", "N", "N s/m", "N s^3/m^3", "kg")
SCAN_SIZE = 40  # values of k2, a factor of 1.2 apart


@dataclass(frozen=True)
class Identification:
    """Coefficients in the order of NAMES, SI, with covariance and residuals."""

    values: Array  # (7,)
    covariance: Array  # (7, 7)
    deflection: Array  # of the rows used [m]
    velocity: Array  # [m/s]
    force: Array  # [N]
    residual: Array  # measured minus model [N]
    rows: int
    repeated: int  # force samples that repeated the one before and were left out
    misfit: float  # greatest ratio of a coefficient's variance to that by white noise alone [1]

    def value(self, name: str) -> float:
        """Value of one coefficient, SI."""
        return float(self.values[NAMES.index(name)])

    def std(self, name: str) -> float:
        """Standard deviation of one coefficient, SI."""
        index = NAMES.index(name)
        return float(np.sqrt(self.covariance[index, index]))


def identify(recordings: Sequence[Recording]) -> Identification:
    """Coefficients of one transmission from all `recordings` of it together.

    Raises RecordingError where they hold too little to fit.
    """
    segments: list[Segment] = []
    repeated = 0
    for recording in recordings:
        found, held = segments_of(recording)
        segments += found
        repeated += held
    reference, stroke = _range(segments)
    theta = _scan(segments, reference, stroke)
    for _ in range(WEIGHT_STEPS):
        theta = _refine(segments, reference, theta)
    covariance, misfit = _covariance(segments, reference, theta)
    values, to_k1 = theta.copy(), np.eye(7)
    values[Q] = theta[Q] * np.exp(-theta[K2] * reference)
    to_k1[Q, Q], to_k1[Q, K2] = np.exp(-theta[K2] * reference), -reference * values[Q]
    residuals = [columns_and_residual(segment, theta, reference)[1] for segment in segments]
    return Identification(
        values=values,
        covariance=to_k1 @ covariance @ to_k1.T,
        deflection=np.concatenate([segment.deflection[segment.used] for segment in segments]),
        velocity=np.concatenate([segment.velocity[segment.used] for segment in segments]),
        force=np.concatenate([segment.force[segment.used] for segment in segments]),
        residual=np.concatenate([left[segment.used] for segment, left in zip(segments, residuals, strict=True)]),
        rows=int(sum(segment.used.sum() for segment in segments)),
        repeated=repeated,
        misfit=misfit,
    )


def _range(segments: Sequence[Segment]) -> tuple[float, float]:
    """Median deflection and stroke of the rows used [m]."""
    deflection = np.concatenate([segment.deflection[segment.used] for segment in segments])
    if len(deflection) < MIN_SAMPLES or np.ptp(deflection) == 0.0:
        raise RecordingError("expected a recording in which the transmission moves, found one at rest")
    return float(np.median(deflection)), float(np.ptp(deflection))


def _scan(segments: Sequence[Segment], reference: float, stroke: float) -> Array:
    """Coefficients with the least cost of a scan over k2."""
    start = np.r_[0.0, 1.0, np.zeros(5)]
    fits = [
        _project(segments, reference, np.r_[k2, start[1:]])
        for k2 in np.geomspace(MIN_BENDING, MAX_BENDING, SCAN_SIZE) / stroke
    ]
    return min(fits, key=lambda fit: float(fit[1] @ fit[1]))[0]


def _project(segments: Sequence[Segment], reference: float, theta: Array) -> tuple[Array, Array]:
    """Best linear coefficients for the k2 in `theta`, by weighted pseudo-inverse; the weighted residual."""
    rows, targets = [], []
    for segment in segments:
        root = np.sqrt(weights_and_slopes(segment, theta, reference)[0])[segment.used, 0]
        rows.append(force_columns(segment, theta, reference)[segment.used, 1:] * root[:, None])
        targets.append(segment.force[segment.used] * root)
    a, f = np.concatenate(rows), np.concatenate(targets)
    scale = np.linalg.norm(a, axis=0)
    scale[scale == 0.0] = 1.0
    linear = np.linalg.lstsq(a / scale, f, rcond=1e-9)[0] / scale
    return np.r_[theta[K2], linear], f - a @ linear


def _refine(segments: Sequence[Segment], reference: float, theta: Array) -> Array:
    """k2 by nonlinear least squares, the rest by eq. (19), then the bias by noisy motion removed."""

    def residual(ln_k2: Array) -> Array:
        return _project(segments, reference, np.r_[np.exp(ln_k2), theta[1:]])[1]

    solution = least_squares(residual, np.log(theta[:1]), xtol=1e-10, ftol=1e-12)
    theta, _ = _project(segments, reference, np.r_[np.exp(solution.x), theta[1:]])
    refined = theta
    for _ in range(BIAS_STEPS):
        gradient = _corrected_gradient(segments, reference, refined)
        refined = refined + _inverse(_normal(segments, refined, reference)) @ gradient
        if not 0.5 * theta[K2] < refined[K2] < 2.0 * theta[K2]:
            return theta
    return refined


def _corrected_gradient(segments: Sequence[Segment], reference: float, theta: Array) -> Array:
    """Right-hand side (7,) of the normal equations without the expected effect of noisy motion.

    Noise e of a row's motion is in its weighted columns and, through the force's slopes, in its residual. With
    covariance C the expectation of their product is -d(weighted columns) C slopes (Stein's lemma); that is added.
    """
    gradient = np.zeros(7)
    for segment in segments:
        columns, residual = columns_and_residual(segment, theta, reference)
        weights, weight_slopes = weights_and_slopes(segment, theta, reference)
        slopes = np.stack(impedance(segment, theta, reference), axis=1)
        weighted_slopes = weights[:, 0, None, None] * column_slopes(segment, theta, reference)
        weighted_slopes += columns[:, :, None] * weight_slopes[:, None, :]
        gradient += columns.T @ (weights[:, 0] * residual)
        gradient += np.einsum("ipa,iab,ib->p", weighted_slopes, segment.motion_covariance, slopes, optimize=True)
    return gradient


def _normal(segments: Sequence[Segment], theta: Array, reference: float) -> Array:
    """Normal matrix of eq. (19) without the expected contribution of noisy motion, (7, 7)."""
    result = np.zeros((7, 7))
    for segment in segments:
        columns = force_columns(segment, theta, reference)
        weights = weights_and_slopes(segment, theta, reference)[0]
        slopes = column_slopes(segment, theta, reference)
        by_noise = np.einsum(
            "i,ipa,iab,iqb->pq", weights[:, 0], slopes, segment.motion_covariance, slopes, optimize=True
        )
        result += (columns * weights).T @ columns - by_noise
    return result


def _covariance(segments: Sequence[Segment], reference: float, theta: Array) -> tuple[Array, float]:
    """Eq. (19) for coloured noise (7, 7), scaled to the residuals; the greatest variance factor of that scaling."""
    noise, blocks = np.zeros((7, 7)), []
    for segment in segments:
        columns, residual = columns_and_residual(segment, theta, reference)
        weighted = columns * weights_and_slopes(segment, theta, reference)[0]
        operators = (segment.polynomials.value, segment.polynomials.slope, segment.polynomials.curvature)
        spread = np.zeros_like(weighted)
        for operator, slope in zip(operators, impedance(segment, theta, reference), strict=True):
            spread += segment.polynomials.transpose(operator, weighted * slope[:, None])
        noise += segment.force_noise**2 * weighted.T @ weighted + segment.deflection_noise**2 * spread.T @ spread
        edges = np.searchsorted(segment.time, np.arange(segment.time[0], segment.time[-1], INDEPENDENCE_TIME))
        blocks.append(np.add.reduceat(weighted * residual[:, None], np.unique(edges), axis=0))
    inverse = _inverse(_normal(segments, theta, reference))
    sums = np.concatenate(blocks)
    expected, observed = inverse @ noise @ inverse, inverse @ (sums.T @ sums) @ inverse
    misfit = np.maximum(1.0, np.diag(observed) / np.maximum(np.diag(expected), 1e-300))
    return expected * np.sqrt(np.outer(misfit, misfit)), float(misfit.max())


def _inverse(normal: Array) -> Array:
    """Pseudo-inverse of a normal matrix whose columns have any units."""
    scale = np.sqrt(np.abs(np.diag(normal)))
    scale[scale == 0.0] = 1.0
    return np.asarray(
        np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-11, hermitian=True) / np.outer(scale, scale)
    )
