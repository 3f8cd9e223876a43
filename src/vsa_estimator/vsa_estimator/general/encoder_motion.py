# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion from the encoder alone: filters over the density of white snap, the most likely one, and a smoother."""

import math
from collections import deque

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.process_noise import maximum_likelihood
from vsa_estimator.general.prediction import add_snap_noise, integrate
from vsa_estimator.general.records import MOTION, Record, V
from vsa_estimator.tuning.filter import (
    BANK_NIS_CAP,
    INITIAL_ACCELERATION_STD,
    INITIAL_SPEED_STD,
    STATIONARY_SPEED,
    STATIONARY_TIME,
)
from vsa_estimator.tuning.general import (
    DENSITY_WINDOW,
    DENSITY_WINDOWS,
    INITIAL_JERK_STD,
    MIN_SNAP_DENSITY,
    ONSET_EVIDENCE,
    ONSET_TIME,
    SNAP_SCALE,
)

CANDIDATES: Array = np.logspace(-6.0, 3.0, 19).astype(np.float64)  # [m^2/s^7]


@compiled
def predict_motion(mean: Array, covariance: Array, density: float, dt: float) -> None:
    """Predict `mean` (MOTION, 1) and `covariance` by dt [s] with white snap of a density [m^2/s^7]."""
    integrate(mean, dt)
    integrate(covariance, dt)
    integrate(covariance.T, dt)
    add_snap_noise(covariance, density, dt)


@compiled
def advance_encoder(
    means: Array, covariances: Array, likelihood: Array, recent_likelihood: Array, measurement: Array
) -> None:
    """One step of all filters: `means` (19, 4), `covariances` (19, 4, 4), sums and recent means of the log (19,).

    `measurement` is dt [s], deflection [m] and its variance [m^2].
    """
    dt, deflection, noise = measurement[0], measurement[1], measurement[2]
    leak = min(dt / ONSET_TIME, 1.0)
    for c in range(CANDIDATES.size):
        z, p = means[c], covariances[c]
        predict_motion(z.reshape((MOTION, 1)), p, CANDIDATES[c], dt)
        variance = p[0, 0] + noise
        innovation = deflection - z[0]
        increment = -0.5 * (math.log(variance) + min(innovation * innovation / variance, BANK_NIS_CAP))
        likelihood[c] += increment
        recent_likelihood[c] += leak * (increment - recent_likelihood[c])
        gain = p[:, 0] / variance
        z += gain * innovation
        p -= np.outer(gain, p[0])


@compiled
def is_moving(speed: float, variance: float) -> bool:
    """Whether a speed [m/s] of this variance [m^2/s^2] is significantly above STATIONARY_SPEED."""
    return bool(abs(speed) > STATIONARY_SPEED + 3.0 * math.sqrt(max(variance, 0.0)))


class EncoderMotion:
    """Running estimate of the motion and of its snap density: the most likely one of the last windows.

    At the onset of a faster motion that of the last ONSET_TIME is higher and significantly more likely: it is used at
    once, since a motion that lags gives a force with a wrong gradient (generalised likelihood ratio; Willsky and Jones,
    1976). A start from rest is an onset in any case: the density is that of the rest until it is detected.
    """

    def __init__(self) -> None:
        """Before the first deflection."""
        self._means = np.zeros((CANDIDATES.size, MOTION))
        self._covariances = np.zeros((CANDIDATES.size, MOTION, MOTION))
        self._likelihood, self._recent_likelihood = np.zeros(CANDIDATES.size), np.zeros(CANDIDATES.size)
        self._recent: deque[Array] = deque(maxlen=DENSITY_WINDOWS)
        self._best = CANDIDATES.size // 2
        self._density = float(CANDIDATES[self._best])
        self._elapsed = 0.0
        self.is_onset = False  # whether a faster motion, or one after a rest, has just begun
        self._since_motion, self._since_start = 0.0, math.inf  # time since the last motion and start from rest [s]

    def restart(self, deflection: float, variance: float) -> None:
        """Begin at a deflection [m] of this variance [m^2]: at the first sample and after a gap."""
        self._means[:] = deflection, 0.0, 0.0, 0.0
        spread = (variance, INITIAL_SPEED_STD**2, INITIAL_ACCELERATION_STD**2, INITIAL_JERK_STD**2)
        self._covariances[:] = np.diag(spread)
        self._recent_likelihood[:] = 0.0

    def add(self, dt: float, deflection: float, variance: float) -> None:
        """Update by a deflection [m] with this variance [m^2], dt [s] after the one before."""
        measurement = np.array([dt, deflection, variance])
        advance_encoder(self._means, self._covariances, self._likelihood, self._recent_likelihood, measurement)
        self._elapsed += dt
        self._follow_rest(dt)
        if self._elapsed >= DENSITY_WINDOW:
            self._elapsed = 0.0
            self._refresh()

    def _follow_rest(self, dt: float) -> None:
        """Time since the last motion, and since the last start from rest, after a step of dt [s]."""
        moves = is_moving(self._means[self._best, V], self._covariances[self._best, V, V])
        starts = moves and self._since_motion >= STATIONARY_TIME
        self._since_start = 0.0 if starts else self._since_start + dt
        self._since_motion = 0.0 if moves else self._since_motion + dt

    def _refresh(self) -> None:
        """Close a window; the density maximises the likelihood, by a parabola through three candidates."""
        self._recent.append(self._likelihood.copy())
        self._likelihood[:] = 0.0
        total = np.sum(self._recent, axis=0)
        self._best = int(np.argmax(total))
        self._density = max(MIN_SNAP_DENSITY, SNAP_SCALE * maximum_likelihood(CANDIDATES, total))

    @property
    def rest_time(self) -> float:
        """Time since the last motion [s]."""
        return self._since_motion

    def write(self, encoder: Record) -> None:
        """Write motion, covariance and density into `encoder`, (1,) ENCODER."""
        used, density, recent = self._best, self._density, self._recent_likelihood
        top = int(np.argmax(recent))
        is_faster = bool(top > used and recent[top] - recent[used] > ONSET_EVIDENCE)
        self.is_onset = is_faster or self._since_start < ONSET_TIME
        if is_faster:
            used, density = top, max(density, SNAP_SCALE * float(CANDIDATES[top]))
        encoder["mean"], encoder["covariance"], encoder["density"] = self._means[used], self._covariances[used], density


@compiled
def filter_deflection(step: Record, mean: Array, covariance: Array) -> None:
    """Advance `mean` (MOTION, 1) and `covariance` by the deflection of `step`, (1,) STEP, into its `smoothed`."""
    now = step[0]
    if now["gap"]:
        mean[:, 0] = now["encoder"]["mean"]
        covariance[:] = now["encoder"]["covariance"]
    else:
        predict_motion(mean, covariance, now["encoder"]["density"], now["dt"])
        gain = covariance[:, 0] / (covariance[0, 0] + now["deflection_variance"])
        mean[:, 0] += gain * (now["deflection"] - mean[0, 0])
        covariance -= np.outer(gain, covariance[0])
    now["smoothed"][:] = mean[:, 0]
    now["smoothed_covariance"][:] = covariance


@compiled
def add_congruence(outer: Array, inner: Array, sign: float, result: Array) -> None:
    """Add `sign` * `outer`' `inner` `outer`, all (MOTION, MOTION), to `result`."""
    for i in range(MOTION):
        for j in range(MOTION):
            for m in range(MOTION):
                for n in range(MOTION):
                    result[i, j] += sign * outer[m, i] * inner[m, n] * outer[n, j]


@compiled
def smooth(steps: Record, count: int, mean: Array, covariance: Array) -> None:
    """Write the motion of the first `count` of `steps` (n,) STEP by all their deflections into `smoothed`.

    `mean` (MOTION, 1) and `covariance` are those before the first step, then those after `count`. Modified
    Bryson-Frazier smoother (Bierman, 1973): no covariance is inverted.
    """
    ahead, ahead_covariance = mean.copy(), covariance.copy()
    for k in range(steps.size):
        filter_deflection(steps[k : k + 1], ahead, ahead_covariance)
        if k == count - 1:
            mean[:], covariance[:] = ahead, ahead_covariance
    score, information = np.zeros(MOTION), np.zeros((MOTION, MOTION))  # of the later deflections
    for k in range(steps.size - 1, -1, -1):
        now, noise, closed = steps[k], steps[k]["deflection_variance"], np.eye(MOTION)
        residual, p = now["deflection"] - now["smoothed"][0], now["smoothed_covariance"].copy()
        if k < count:
            for i in range(MOTION):
                now["smoothed"][i] += np.sum(p[i] * score)
            add_congruence(p, information, -1.0, now["smoothed_covariance"])
        later, later_score = information.copy(), score.copy()
        score[:] = 0.0
        information[:] = 0.0
        if not now["gap"]:
            integrate(closed, now["dt"])
            row = closed[0].copy()
            closed -= np.outer(p[:, 0], row) / noise  # of the error, over the step and its update
            score += residual / noise * row
            information += (1.0 - p[0, 0] / noise) / noise * np.outer(row, row)
            for i in range(MOTION):
                score += closed[i] * later_score[i]
            add_congruence(closed, later, 1.0, information)
