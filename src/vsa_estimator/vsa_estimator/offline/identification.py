# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Coefficients of a transmission from whole recordings, eqs. (18) and (19), and its elastic law of any form.

Exponential law: all but k2 enter the force, eqs. (2) to (6), linearly: k2 is found by nonlinear least squares over the
fit of the rest (variable projection), the rest by weighted pseudo-inverse. Law of any form: the stiffness is a spline,
in whose coefficients the force is linear. It is reported where it refutes the exponential law.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from vsa_common.types import Array
from vsa_estimator.general.models import matern
from vsa_estimator.offline.elastic_law import Deviation, KnotLaw, deviation
from vsa_estimator.offline.force_model import (
    F0,
    columns_and_residual,
    corrected_gradient,
    covariance_of,
    force_columns,
    inverse_of,
    normal_matrix,
    weights_and_slopes,
)
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.offline.segments import Segment, segments_of
from vsa_estimator.offline.springs import ExponentialSpring, SplineSpring, Spring, abscissas
from vsa_estimator.tuning.force_law import MIN_K2
from vsa_estimator.tuning.offline import (
    BIAS_STEPS,
    LAW_INTERVALS,
    LAW_LENGTH,
    LAW_STDS,
    MAX_BENDING,
    MIN_BENDING,
    MIN_SAMPLES,
    MIN_STIFFNESS_SHARE,
    WEIGHT_STEPS,
)

UNITS = {
    "k2": "1/m", "k1": "N", "force_offset": "N", "coulomb_friction": "N", "d1": "N s/m", "d2": "N s^3/m^3",
    "inertia": "kg",
}  # fmt: skip
NAMES = tuple(UNITS)
K2, Q = 0, 1  # coefficients of the exponential spring
SCAN_SIZE = 40  # values of k2, a factor of 1.2 apart


@dataclass(frozen=True)
class Identification:
    """Coefficients, SI, with covariance, elastic law and residuals; k2, k1 and F0 only of the exponential law."""

    names: tuple[str, ...]
    values: Array  # (n,)
    covariance: Array  # (n, n)
    law: KnotLaw
    deflection: Array  # of the rows used [m]
    velocity: Array  # [m/s]
    force: Array  # [N]
    residual: Array  # measured minus model [N]
    rows: int
    repeated: int  # force samples that repeated the one before and were left out
    misfit: float  # greatest ratio of a coefficient's variance to that by white noise alone [1]
    deviation: Deviation | None = None  # of the law of any form from the exponential law, where compared

    @property
    def is_exponential(self) -> bool:
        """Whether the elastic law is the exponential one."""
        return "k2" in self.names

    def value(self, name: str) -> float:
        """Value of one coefficient, SI."""
        return float(self.values[self.names.index(name)])

    def std(self, name: str) -> float:
        """Standard deviation of one coefficient, SI."""
        index = self.names.index(name)
        return float(np.sqrt(self.covariance[index, index]))


@dataclass(frozen=True)
class _Data:
    """Segments of all recordings, and the force samples that were left out."""

    segments: Sequence[Segment]
    repeated: int
    deflection: Array  # of the rows used [m]

    @property
    def reference(self) -> float:
        return float(np.median(self.deflection))

    @property
    def stroke(self) -> float:
        return float(np.ptp(self.deflection))


def identify(recordings: Sequence[Recording], any_law: bool = False) -> Identification:
    """Coefficients of one transmission from all `recordings` of it together.

    With `any_law` those with a law of any form, where that refutes the exponential law. Raises RecordingError where the
    recordings hold too little to fit.
    """
    data = _data(recordings)
    spring = ExponentialSpring(data.reference)
    theta = _scan(data.segments, spring, data.stroke)
    for _ in range(WEIGHT_STEPS):
        theta = _refine(data.segments, spring, theta)
    exponential = _exponential(data, spring, theta)
    if not any_law:
        return exponential
    general = _general(data, theta)
    departure = deviation(general.law, MIN_K2)
    return replace(general if departure.is_significant else exponential, deviation=departure)


def _data(recordings: Sequence[Recording]) -> _Data:
    parts = [segments_of(recording) for recording in recordings]
    segments = [segment for found, _ in parts for segment in found]
    deflection = np.concatenate([segment.deflection[segment.used] for segment in segments])
    if len(deflection) < MIN_SAMPLES or np.ptp(deflection) == 0.0:
        raise RecordingError("expected a recording in which the transmission moves, found one at rest")
    return _Data(segments, sum(held for _, held in parts), deflection)


def _exponential(data: _Data, spring: ExponentialSpring, theta: Array) -> Identification:
    """The result with k1 in place of q."""
    covariance, misfit = covariance_of(data.segments, theta, spring)
    values, to_k1, reference = theta.copy(), np.eye(len(theta)), spring.reference
    values[Q] = theta[Q] * np.exp(-theta[K2] * reference)
    to_k1[Q, Q], to_k1[Q, K2] = np.exp(-theta[K2] * reference), -reference * values[Q]
    knots = np.array([data.deflection.min(), data.deflection.max()])
    gradient = np.zeros((2, len(theta)))
    gradient[:, K2], gradient[:, Q] = 1.0 / theta[K2] + knots - reference, 1.0 / theta[Q]
    force = spring.force(knots, theta[:F0])
    law = KnotLaw(
        knots, np.log(np.maximum(theta[K2] * force, 1e-300)), gradient @ covariance @ gradient.T,
        float(theta[F0] + force[0]),
    )  # fmt: skip
    return _result(data, spring, theta, NAMES, (values, to_k1 @ covariance @ to_k1.T, law, misfit))


def _general(data: _Data, theta: Array) -> Identification:
    """The result with a spline for the stiffness; `theta` has the start values of damper, friction and mass.

    The first fit, with a prior about the mean stiffness, gives the exponential law that the prior of the second one is
    about: then the prior is as wide at the soft end as at the stiff one.
    """
    knots = np.linspace(data.deflection.min(), data.deflection.max(), LAW_INTERVALS + 1)
    at = abscissas(knots)
    force = np.concatenate([segment.force[segment.used] for segment in data.segments])
    mean: Array = np.full(len(at), max(abs(float(np.polyfit(data.deflection, force, 1)[0])), 1e-9))
    theta = np.r_[mean, float(force.mean()) - mean[0] * 0.5 * data.stroke, theta[F0 + 1 :]]
    for std in LAW_STDS:
        relative = matern(at, LAW_LENGTH * data.stroke, std)
        spring = SplineSpring(knots, mean, np.outer(mean, mean) * relative)
        theta = _solve(data.segments, spring, theta)
        covariance, misfit = covariance_of(data.segments, theta, spring)
        law = _knot_law(spring, np.linspace(knots[0], knots[-1], 2 * LAW_INTERVALS + 1), theta, covariance)
        mean = deviation(law).exponential(at)
    others = slice(F0 + 1, None)
    return _result(data, spring, theta, NAMES[others], (theta[others], covariance[others, others], law, misfit))


def _solve(segments: Sequence[Segment], spring: Spring, theta: Array) -> Array:
    """Coefficients that solve the corrected normal equations; the weights depend on them."""
    for _ in range(WEIGHT_STEPS * BIAS_STEPS):
        gradient = corrected_gradient(segments, theta, spring)
        theta = theta + inverse_of(normal_matrix(segments, theta, spring)) @ gradient
    return theta


def _knot_law(spring: SplineSpring, knots: Array, theta: Array, covariance: Array) -> KnotLaw:
    stiffness, _ = spring.stiffness(knots, theta[:F0])
    stiffness = np.maximum(stiffness, MIN_STIFFNESS_SHARE * spring.stiffness(knots, spring.prior)[0])
    gradient = spring.basis(knots) / stiffness[:, None]
    return KnotLaw(knots, np.log(stiffness), gradient @ covariance[:F0, :F0] @ gradient.T, float(theta[F0]))


def _result(
    data: _Data, spring: Spring, theta: Array, names: tuple[str, ...], found: tuple[Array, Array, KnotLaw, float]
) -> Identification:
    """Result with the residuals of the coefficients `theta`; `found`: values, covariance, law and misfit."""
    values, covariance, law, misfit = found
    residuals = [columns_and_residual(segment, theta, spring)[1] for segment in data.segments]
    used = [segment.used for segment in data.segments]
    return Identification(
        names=names, values=values, covariance=covariance, law=law, misfit=misfit,
        deflection=data.deflection,
        velocity=np.concatenate([segment.velocity[segment.used] for segment in data.segments]),
        force=np.concatenate([segment.force[segment.used] for segment in data.segments]),
        residual=np.concatenate([left[rows] for left, rows in zip(residuals, used, strict=True)]),
        rows=len(data.deflection),
        repeated=data.repeated,
    )  # fmt: skip


def _scan(segments: Sequence[Segment], spring: Spring, stroke: float) -> Array:
    """Coefficients with the least cost of a scan over k2."""
    start = np.r_[0.0, 1.0, np.zeros(5)]
    fits = [
        _project(segments, spring, np.r_[k2, start[1:]])
        for k2 in np.geomspace(MIN_BENDING, MAX_BENDING, SCAN_SIZE) / stroke
    ]
    return min(fits, key=lambda fit: float(fit[1] @ fit[1]))[0]


def _project(
    segments: Sequence[Segment], spring: Spring, theta: Array, weighing: Array | None = None
) -> tuple[Array, Array]:
    """Best linear coefficients for the k2 in `theta`, by weighted pseudo-inverse; the weighted residual.

    The weights are those of the coefficients `weighing`, by default of `theta`.
    """
    rows, targets = [], []
    for segment in segments:
        weights, _ = weights_and_slopes(segment, theta if weighing is None else weighing, spring)
        root = np.sqrt(weights)[segment.used, 0]
        rows.append(force_columns(segment, theta, spring)[segment.used, 1:] * root[:, None])
        targets.append(segment.force[segment.used] * root)
    a, f = np.concatenate(rows), np.concatenate(targets)
    scale = np.linalg.norm(a, axis=0)
    scale[scale == 0.0] = 1.0
    linear = np.linalg.lstsq(a / scale, f, rcond=1e-9)[0] / scale
    return np.r_[theta[K2], linear], f - a @ linear


def _refine(segments: Sequence[Segment], spring: Spring, theta: Array) -> Array:
    """k2 by nonlinear least squares, the rest by eq. (19), then the bias by noisy motion removed."""

    def residual(ln_k2: Array) -> Array:
        return _project(segments, spring, np.r_[np.exp(ln_k2), theta[1:]], weighing=theta)[1]

    solution = least_squares(residual, np.log(theta[:1]), xtol=1e-10, ftol=1e-12)
    theta, _ = _project(segments, spring, np.r_[np.exp(solution.x), theta[1:]])
    refined = theta
    for _ in range(BIAS_STEPS):
        gradient = corrected_gradient(segments, refined, spring)
        refined = refined + inverse_of(normal_matrix(segments, refined, spring)) @ gradient
        if not 0.5 * theta[K2] < refined[K2] < 2.0 * theta[K2]:
            return theta
    return refined
