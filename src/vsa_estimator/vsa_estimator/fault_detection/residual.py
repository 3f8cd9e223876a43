# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parity residuals: measured force less the force of eq. (6) with given coefficients on the encoder's motion."""

from typing import NamedTuple

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array, Booleans
from vsa_estimator.fault_detection.isolation import Residuals, SensorShift
from vsa_estimator.fault_detection.row_buffer import is_confirmed, vibrates
from vsa_estimator.fault_detection.travel import Limits, Travel, known_limits
from vsa_estimator.force_law.damper import clip_speed, peak_speed
from vsa_estimator.force_law.elastic import elastic_force, elastic_gradient, stiffness
from vsa_estimator.force_law.friction import smoothed_sign
from vsa_estimator.force_law.state import C_D0, C_D1, C_D2, C_F0, C_K2, C_M, C_S, COEFFICIENTS
from vsa_estimator.tuning.fault_detection import (
    EVALUATION_PERIOD,
    MAX_DAMPER_ERROR,
    MIN_COVERAGE,
    MIN_ROWS,
    MOVING_SPEED,
    STICTION_RATIO,
    WINDOWS,
)
from vsa_estimator.tuning.force_law import COULOMB_SPEED

DECISION_WINDOW = 1  # index in WINDOWS of the one that ends a fault


class Coefficients(NamedTuple):
    """Coefficients [s k2 d1 d2 M F0 d0] (7,) with covariance (7, 7), and the position at which s holds [m]."""

    mean: Array
    covariance: Array
    reference: float

    @property
    def ages(self) -> bool:
        """Whether the covariance grows with time: no."""
        return False

    def stiffness(self, deflection: float) -> float:
        """Stiffness of eq. (3) at a deflection [m] in N/m."""
        return float(stiffness(self.mean[C_S], self.mean[C_K2], deflection - self.reference))

    def growth(self, _deflection: float) -> float:
        """Slope of ln stiffness at a deflection [m] in 1/m."""
        return float(self.mean[C_K2])

    def travel(self, known: Travel) -> tuple[float, float]:
        """Deflections [m] up to which the law holds, if it is known in this travel."""
        return known.limits(self.growth(self.reference))

    def others(self) -> "tuple[Coefficients, ...]":
        """Other laws that the data permit: none."""
        return ()

    def follow(self, rows: Array, baseline: float, peak_speed: float) -> None:
        """Nothing: the force has no memory."""

    def residuals(self, rows: Array, baseline: float, limits: Limits) -> Residuals:
        """`residuals` of rows."""
        return residuals(rows, self.mean, self.reference, baseline, known_limits(self.mean, self.covariance, limits))

    def evaluate(self, rows: Array, baseline: float, limits: Limits, windows: Array) -> None:
        """`evaluate_windows` of rows."""
        evaluate_windows(rows, *self, baseline, limits, windows)

    def widened(self, ln_stiffness_variance: float) -> "Coefficients":
        """The coefficients with a greater variance of ln stiffness."""
        covariance = self.covariance.copy()
        covariance[C_S, C_S] += ln_stiffness_variance
        return self._replace(covariance=covariance)

    def shifted(self, shift: SensorShift) -> "Coefficients":
        """The coefficients for sensors that read this much more; the variance of an encoder's widens the stiffness."""
        if shift.deflection:
            widened = self.widened((self.growth(self.reference) * shift.std) ** 2)
            return widened._replace(reference=self.reference + shift.deflection)
        mean, covariance = self.mean.copy(), self.covariance.copy()
        mean[C_F0] += shift.force
        covariance[C_F0, C_F0] += shift.std**2
        return self._replace(mean=mean, covariance=covariance)


@compiled
def residuals(rows: Array, mean: Array, reference: float, baseline: float, limits: Limits) -> Residuals:
    """Residuals of the rows (4, n) of a RowBuffer, where they are usable.

    Velocities are differences over `baseline` [s]; rows beyond the `limits` are not usable.
    `mean` is [s k2 d1 d2 M F0 d0] with s at `reference` [m]. Returns time (m,), residual [N] (m,), stiffness of eq. (3)
    (m,), whether the rod moves (m,), the motion x, v, a (3, m), and the times of all finite residuals.
    """
    time, deflection, force, after_rejection = rows
    baseline = max(baseline, 2.0 * mean_period(time))
    half = half_baseline(time, baseline)
    count = max(0, time.size - 2 * half)
    s, k2, d1, d2, mass, offset, coulomb = mean
    peak = peak_speed(d1, d2)
    motion, residual, sigma = np.empty((3, count)), np.empty(count), np.empty(count)
    usable, excluded, moving = np.empty(count, np.bool_), np.empty(count, np.bool_), np.empty(count, np.bool_)
    for i in range(count):
        x, v, a, least_a, span = differences(time, deflection, i, half, count)
        sigma[i] = stiffness(s, k2, x - reference)
        c = clip_speed(v, peak)
        friction = coulomb * smoothed_sign(v, COULOMB_SPEED)
        residual[i] = force[i + half] - (
            elastic_force(sigma[i], k2) + d1 * c + d2 * c**3 + mass * a + offset + friction
        )
        speed_error = 0.25 * baseline * least_a
        excluded[i] = abs(v) + speed_error >= limits[2] or speed_error * d1 > MAX_DAMPER_ERROR
        excluded[i] |= after_rejection[i : i + 2 * half + 1].any() or not limits[0] < x < limits[1]
        usable[i] = np.isfinite(residual[i]) and span < 2.0 * baseline and is_confirmed(force, i + half)
        excluded[i] |= vibrates(force, i + half, 2 * half)
        moving[i] = abs(v) > MOVING_SPEED
        motion[0, i], motion[1, i], motion[2, i] = x, v, a
    time = time[half : half + count]
    finite = time[usable]
    exclude_neighbours(usable, excluded, 2 * half)
    return time[usable], residual[usable], sigma[usable], moving[usable], motion[:, usable], finite


@compiled
def mean_period(time: Array) -> float:
    """Mean time between two rows [s]."""
    return float((time[-1] - time[0]) / (time.size - 1))


@compiled
def half_baseline(time: Array, baseline: float) -> int:
    """Rows in half a `baseline` [s]."""
    return int(max(1, round(0.5 * baseline / mean_period(time))))


@compiled
def differences(
    time: Array, deflection: Array, i: int, half: int, count: int
) -> tuple[float, float, float, float, float]:
    """Position, velocity and acceleration about row i + half, the least magnitude of the acceleration, and span [s].

    The least one is that over the baseline or over twice the baseline, which has a quarter of the noise.
    """
    span = time[i + 2 * half] - time[i]
    v = (deflection[i + 2 * half] - deflection[i]) / span
    a = 4.0 * (deflection[i + 2 * half] - 2.0 * deflection[i + half] + deflection[i]) / span**2
    around, x = half // 2, 0.0
    for near in range(i + half - around, i + half + around + 1):
        x += deflection[near]
    x /= 2 * around + 1
    least_a = abs(a)
    if half <= i < count - half:
        wide = deflection[i + 3 * half] - 2.0 * deflection[i + half] + deflection[i - half]
        least_a = min(least_a, abs(wide) / span**2)
    return x, v, a, least_a, span


@compiled
def exclude_neighbours(usable: Booleans, excluded: Booleans, width: int) -> None:
    """Mark rows within `width` rows of an excluded one as not usable."""
    until = -1
    for i in range(usable.size):
        if excluded[i]:
            usable[max(0, i - width) : i] = False
            until = i + width
        if i <= until:
            usable[i] = False


@compiled
def mean_residual(
    time: Array, residual: Array, moving: Booleans, finite: Array, span: tuple[float, float], lag: int
) -> tuple[int, float, float, float]:
    """First row in `span`, of a window [s] up to an end [s], -1 for too few; mean [N], weight, and share in motion.

    `finite` are the times of all finite residuals. The noise of n velocity differences over `lag` rows telescopes:
    that of their mean is as sqrt(min(n, lag)) / n. The mean of a part of the window is reduced to the noise of the
    whole, by a weight of at most 1.
    """
    if time.size == 0:
        return -1, 0.0, 0.0, 0.0
    window, end = span
    begin = end - window
    first = int(np.searchsorted(time, begin))
    whole = finite.size - int(np.searchsorted(finite, begin))
    count = time.size - first
    if count < max(3.0, MIN_COVERAGE * whole) or time[-1] - time[first] <= 0.8 * window - 2.0 * EVALUATION_PERIOD:
        return -1, 0.0, 0.0, 0.0
    weight = min(1.0, count / whole * np.sqrt(min(whole, lag) / min(count, lag)))
    return first, weight * float(np.mean(residual[first:])), weight, float(np.mean(moving[first:]))


@compiled
def model_force_std(mean: Array, covariance: Array, reference: float, motion: Array, first: int) -> float:
    """Standard deviation [N] of the mean model force from row `first` on by the coefficients' covariance (7, 7)."""
    s, k2, gradient = mean[C_S], mean[C_K2], np.zeros(COEFFICIENTS)
    peak = peak_speed(mean[C_D1], mean[C_D2])
    for i in range(first, motion.shape[1]):
        x, v, a = motion[:, i]
        dx, c = x - reference, clip_speed(v, peak)
        _, by_s, by_k2 = elastic_gradient(stiffness(s, k2, dx), k2, dx)
        gradient[C_S] += by_s
        gradient[C_K2] += by_k2
        gradient[C_D1] += c
        gradient[C_D2] += c**3
        gradient[C_M] += a
        gradient[C_F0] += 1.0
        gradient[C_D0] += smoothed_sign(v, COULOMB_SPEED)
    gradient /= motion.shape[1] - first
    return float(np.sqrt(max(float(gradient @ covariance @ gradient), 0.0)))


@compiled
def evaluate_windows(
    rows: Array, mean: Array, covariance: Array, reference: float, baseline: float, limits: Limits, windows: Array
) -> None:
    """Write into `windows` (4, 3), for each of WINDOWS, what describes its mean residual.

    Mean [N], `model_force_std` [N], stiction of eq. (6) that is hidden in it at most [N], and share of rows in motion.
    A window has at least MIN_ROWS rows. Where too few of them are usable the mean is NaN, and the others stay.
    """
    limits = known_limits(mean, covariance, limits)
    time, residual, _, moving, motion, finite = residuals(rows, mean, reference, baseline, limits)
    period = mean_period(rows[0])
    half = half_baseline(rows[0], max(baseline, 2.0 * period))
    end = rows[0, max(0, rows.shape[1] - 1 - half)]  # of the rows that have a velocity
    for index in range(len(WINDOWS)):
        span = max(WINDOWS[index], MIN_ROWS * period), end
        first, average, weight, in_motion = mean_residual(time, residual, moving, finite, span, 2 * half)
        windows[0, index] = np.nan
        if first >= 0:
            windows[0, index], windows[3, index] = average, in_motion
            windows[1, index] = model_force_std(mean, covariance, reference, motion, first)
            windows[2, index] = weight * (1.0 - in_motion) * STICTION_RATIO * mean[C_D0]
