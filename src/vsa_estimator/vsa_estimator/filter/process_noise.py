"""Process noise: drift of the coefficients, and the density of the jerk by maximum likelihood.

A bank of encoder-only filters, one for each half decade of jerk density, runs beside the filter (multiple model).
"""

from collections import deque

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
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


@compiled
def add_jerk_process_noise(p: Array, dt: float, jerk_density: float) -> None:
    """Add the noise of white jerk over dt [s] to the upper triangle of the covariance."""
    q = jerk_density
    p[0, 0] += q * dt**5 / 20.0
    p[0, 1] += q * dt**4 / 8.0
    p[0, 2] += q * dt**3 / 6.0
    p[1, 1] += q * dt**3 / 3.0
    p[1, 2] += q * dt**2 / 2.0
    p[2, 2] += q * dt


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

    `bank` (9, 19) has rows x, v, a, pxx, pxv, pxa, pvv, pva, paa; `density` and `likelihood` are (19,).
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
        bank[0, i] = x + gx * innovation
        bank[1, i] = v + gv * innovation
        bank[2, i] = a + ga * innovation
        bank[3, i] = pxx - gx * pxx
        bank[4, i] = sxv - gx * sxv
        bank[5, i] = sxa - gx * sxa
        bank[6, i] = svv - gv * sxv
        bank[7, i] = sva - gv * sxa
        bank[8, i] = paa - ga * sxa


class JerkDensity:
    """Running jerk density: the most likely one of the last windows."""

    def __init__(self, windows: int = 20) -> None:
        """A window is the time between two calls of `refresh`; likelihoods reach back over `windows` of them."""
        self.density = INITIAL_JERK_DENSITY  # for the filter [m^2/s^5]
        self.ml_estimate = INITIAL_JERK_DENSITY  # of the encoder alone [m^2/s^5]
        self._bank: Array = np.zeros((9, CANDIDATES.size))
        self._likelihood = np.zeros(CANDIDATES.size)
        self._recent: deque[Array] = deque(maxlen=windows)
        self._started = False
        self._mean_nis = 1.0

    def detect_manoeuvre(self, nis: float) -> bool:
        """Update the manoeuvre test by the NIS of the filter's last deflection; whether it has detected one.

        The density then rises at once: until then the filter lags, which would bias the coefficients.
        """
        self._mean_nis += MANOEUVRE_GAIN * (min(nis, MANOEUVRE_NIS_CAP) - self._mean_nis)
        if self._mean_nis <= MANOEUVRE_NIS:
            return False
        if nis > MANOEUVRE_NIS:  # the variance of the position grows with the sixth root of the density
            self.density = min((nis / MANOEUVRE_NIS) ** 3 * self.density, float(CANDIDATES[-1]))
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
        self._bank[0] = measured
        self._bank[3] = noise_variance
        self._bank[6] = INITIAL_SPEED_STD**2
        self._bank[8] = INITIAL_ACCELERATION_STD**2
        self._started = True

    def refresh(self, minimum: float = MIN_JERK_DENSITY_WITH_INERTIA) -> float:
        """Close a window and update the density [m^2/s^5], not below `minimum`; the new value."""
        self._recent.append(self._likelihood.copy())
        self._likelihood[:] = 0.0
        estimate = _maximum_likelihood(np.sum(self._recent, axis=0))
        self.ml_estimate, self.density = max(minimum, estimate), max(minimum, PSD_SCALE * estimate)
        return self.density


def _maximum_likelihood(likelihood: Array) -> float:
    """Density of the maximum of the log likelihood, by the parabola through the three best candidates."""
    top = int(np.argmax(likelihood))
    if not 0 < top < len(CANDIDATES) - 1:
        return float(CANDIDATES[top])
    before, at, after = likelihood[top - 1 : top + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * at + after)
    return float(CANDIDATES[top] * (CANDIDATES[1] / CANDIDATES[0]) ** shift)
