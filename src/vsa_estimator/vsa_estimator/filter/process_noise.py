# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Process noise: drift of the coefficients, and the density of the jerk by maximum likelihood.

A bank of encoder-only filters, one for each half decade of jerk density, runs beside the filter (multiple model).
"""

from collections import deque

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.state import A, V, X
from vsa_estimator.tuning.filter import (
    BANK_NIS_CAP,
    INITIAL_ACCELERATION_STD,
    INITIAL_JERK_DENSITY,
    INITIAL_SPEED_STD,
    MANOEUVRE_GAIN,
    MANOEUVRE_NIS,
    MANOEUVRE_NIS_CAP,
    MIN_JERK_DENSITY_WITH_INERTIA,
    PARAMETER_PROCESS_NOISE,
    PSD_SCALE,
)

CANDIDATES: Array = np.logspace(-8.0, 1.0, 19).astype(np.float64)  # [m^2/s^5]
PARAMETER_DRIFT = np.array(PARAMETER_PROCESS_NOISE)
PXX, PXV, PXA, PVV, PVA, PAA = range(3, 9)  # rows of the bank: covariance of x, v, a behind these


@compiled
def add_jerk_process_noise(p: Array, dt: float, jerk_density: float) -> None:
    """Add the noise of white jerk over dt [s] to the upper triangle of the covariance."""
    q = jerk_density
    p[X, X] += q * dt**5 / 20.0
    p[X, V] += q * dt**4 / 8.0
    p[X, A] += q * dt**3 / 6.0
    p[V, V] += q * dt**3 / 3.0
    p[V, A] += q * dt**2 / 2.0
    p[A, A] += q * dt


@compiled
def add_parameter_process_noise(p: Array, dt: float) -> None:
    """Add the random walk of the coefficients over dt [s] of motion to the covariance."""
    for i in range(PARAMETER_DRIFT.size):
        p[3 + i, 3 + i] += PARAMETER_DRIFT[i] * dt


@compiled
def advance_bank(
    bank: Array, density: Array, likelihood: Array, measured: float, noise_variance: float, dt: float
) -> None:
    """One step of all filters of the bank; the log likelihoods of the innovations add up.

    `bank` (9, 19) has the rows X to PAA; `density` and `likelihood` are (19,).
    """
    half = 0.5 * dt * dt
    for i in range(density.size):
        x, v, a, pxx, pxv, pxa, pvv, pva, paa = bank[:, i]
        q = density[i]
        x += dt * v + half * a
        v += dt * a
        sva = pva + dt * paa
        svv = pvv + dt * (pva + sva) + q * (dt**3 / 3.0)
        sxa = pxa + dt * pva + half * paa
        sxv = pxv + dt * pvv + half * pva + dt * sxa + q * (dt**4 / 8.0)
        pxx += 2.0 * dt * pxv + dt * dt * pvv + half * (2.0 * pxa + 2.0 * dt * pva + half * paa) + q * (dt**5 / 20.0)
        sxa += q * (dt**3 / 6.0)
        sva += q * (dt * dt / 2.0)
        paa += q * dt
        variance = pxx + noise_variance
        innovation = measured - x
        likelihood[i] -= 0.5 * (np.log(variance) + min(innovation * innovation / variance, BANK_NIS_CAP))
        gx, gv, ga = pxx / variance, sxv / variance, sxa / variance
        bank[X, i] = x + gx * innovation
        bank[V, i] = v + gv * innovation
        bank[A, i] = a + ga * innovation
        bank[PXX, i] = pxx - gx * pxx
        bank[PXV, i] = sxv - gx * sxv
        bank[PXA, i] = sxa - gx * sxa
        bank[PVV, i] = svv - gv * sxv
        bank[PVA, i] = sva - gv * sxa
        bank[PAA, i] = paa - ga * sxa


class JerkDensity:
    """Running jerk density: the most likely one of the last windows."""

    def __init__(self, windows: int = 20) -> None:
        """A window is the time between two calls of `refresh`; likelihoods reach back over `windows` of them."""
        self.density = INITIAL_JERK_DENSITY  # for the filter [m^2/s^5]
        self.ml_estimate = INITIAL_JERK_DENSITY  # of the encoder alone [m^2/s^5]
        self._bank: Array = np.zeros((PAA + 1, CANDIDATES.size))
        self._likelihood = np.zeros(CANDIDATES.size)
        self._recent: deque[Array] = deque(maxlen=windows)
        self._started = False
        self._mean_nis = 1.0
        self._raised = 0.0  # density that the last manoeuvre requires [m^2/s^5]

    def detect_manoeuvre(self, nis: float) -> bool:
        """Update the manoeuvre test by the NIS of the filter's last deflection; whether it has detected one.

        The density then rises at once: until then the filter lags, which would bias the coefficients.
        """
        self._mean_nis += MANOEUVRE_GAIN * (min(nis, MANOEUVRE_NIS_CAP) - self._mean_nis)
        if self._mean_nis <= MANOEUVRE_NIS:
            return False
        if nis > MANOEUVRE_NIS:  # the variance of the position grows with the sixth root of the density
            self.density = self._raised = min((nis / MANOEUVRE_NIS) ** 3 * self.density, float(CANDIDATES[-1]))
        return True

    def add(self, measured: float, noise_variance: float, dt: float) -> None:
        """Update the bank by a deflection [m] with noise [m^2], dt [s] after the one before."""
        if not self._started:
            self.restart(measured, noise_variance)
            return
        advance_bank(self._bank, CANDIDATES, self._likelihood, measured, noise_variance, dt)

    def restart(self, measured: float, noise_variance: float) -> None:
        """Reset the bank to a position [m]: at the first sample, after a gap, after an encoder step."""
        self._bank[:] = 0.0
        self._bank[X] = measured
        self._bank[PXX] = noise_variance
        self._bank[PVV] = INITIAL_SPEED_STD**2
        self._bank[PAA] = INITIAL_ACCELERATION_STD**2
        self._started = True

    def refresh(self, minimum: float = MIN_JERK_DENSITY_WITH_INERTIA) -> float:
        """Close a window and update the density [m^2/s^5], not below `minimum`; the new value.

        A density that a manoeuvre has raised falls no lower than that of this window alone.
        """
        self._recent.append(self._likelihood.copy())
        estimate = maximum_likelihood(CANDIDATES, np.sum(self._recent, axis=0))
        of_window = maximum_likelihood(CANDIDATES, self._likelihood)
        self._likelihood[:] = 0.0
        self._raised = min(self._raised, PSD_SCALE * of_window)
        self.ml_estimate, self.density = max(minimum, estimate), max(minimum, PSD_SCALE * estimate, self._raised)
        return self.density


def maximum_likelihood(candidates: Array, likelihood: Array) -> float:
    """Density of the greatest log likelihood over geometric `candidates`, by the parabola through three of them."""
    top = int(np.argmax(likelihood))
    if not 0 < top < len(candidates) - 1:
        return float(candidates[top])
    before, at, after = likelihood[top - 1 : top + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * at + after)
    return float(candidates[top] * (candidates[1] / candidates[0]) ** shift)
