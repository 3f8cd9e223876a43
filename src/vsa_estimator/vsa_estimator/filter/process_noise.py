"""How lively the motion is: the jerk density under which the encoder alone is most likely.

A bank of encoder-only filters, one for each half decade of jerk density, runs beside the estimator.
"""

from collections import deque

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array

CANDIDATES: Array = np.logspace(-8.0, 1.0, 19).astype(np.float64)  # [m^2/s^5]
# The filter never assumes less [m^2/s^5]: the more, the more noise of the place pulls k2 upward (by 6e-5 of it at 3e-6,
# slow at 1 kHz); the less, the surer it is of a spring that is part mass.
LEAST, LEAST_HEAVY = 3e-7, 3e-6
# A motion of some tones is followed best by the encoder alone with less white jerk than it has power; the force, which
# tells the speed far closer, would feel the lag: 1 to 2 um and 60 um/s in phase with the motion.
MARGIN = 2.2
STARTLED = 4.0  # leaky mean of the deflection's normalised innovation squared that tells of a sudden motion
_STARTLE_GAIN, _STARTLE_LOUD = 0.3, 10.0  # one loud sample alone does not startle
_LOUD = 16.0  # normalised innovation squared from which a sample says no more against a candidate


@compiled
def advance(bank: Array, density: Array, likelihood: Array, measured: float, noise_variance: float, dt: float) -> None:
    """One step of all filters; bank rows are x, v, a and the six covariances; log likelihoods add up."""
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
        likelihood[i] -= 0.5 * (np.log(variance) + min(innovation * innovation / variance, _LOUD))
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
    """Running jerk density: the most likely one of the last few windows."""

    def __init__(self, windows: int = 20) -> None:
        """A window is what lies between two calls of `refresh`; likelihoods reach back over `windows` of them."""
        self.density = self.likeliest = 1e-3  # for the filter, and for the encoder alone [m^2/s^5]
        self._bank: Array = np.zeros((9, CANDIDATES.size))
        self._likelihood = np.zeros(CANDIDATES.size)
        self._recent: deque[Array] = deque(maxlen=windows)
        self._started = False
        self._surprise = 1.0

    def detect_manoeuvre(self, nis: float) -> bool:
        """Whether the motion has just become livelier than the density allows; it then rises at once.

        Until it has risen far enough the filter lags, and a force would be laid at the door of the coefficients.
        `nis` is the normalised innovation squared of the filter's last deflection.
        """
        self._surprise += _STARTLE_GAIN * (min(nis, _STARTLE_LOUD) - self._surprise)
        if self._surprise <= STARTLED:
            return False
        if nis > STARTLED:  # not yet caught up; the filter's variance grows with the sixth root of the density
            self.density = min((nis / STARTLED) ** 3 * self.density, float(CANDIDATES[-1]))
        return True

    def add(self, measured: float, noise_variance: float, dt: float) -> None:
        """Take one deflection [m] that came dt [s] after the one before."""
        if not self._started:
            self.restart(measured, noise_variance)
            return
        advance(self._bank, CANDIDATES, self._likelihood, measured, noise_variance, dt)

    def restart(self, measured: float, noise_variance: float) -> None:
        """Begin anew at a place: after a gap, or where the encoder jumped."""
        self._bank[:] = 0.0
        self._bank[0] = measured
        self._bank[3] = noise_variance
        self._bank[6] = 4e-6
        self._bank[8] = 25e-6
        self._started = True

    def refresh(self, least: float = LEAST_HEAVY) -> float:
        """Close a window; the density [m^2/s^5] to use from now on, not below `least`."""
        self._recent.append(self._likelihood.copy())
        self._likelihood[:] = 0.0
        likeliest = _likeliest(np.sum(self._recent, axis=0))
        self.likeliest, self.density = max(least, likeliest), max(least, MARGIN * likeliest)
        return self.density


def _likeliest(likelihood: Array) -> float:
    """Density of the greatest log likelihood, by the parabola through the three greatest candidates."""
    top = int(np.argmax(likelihood))
    if not 0 < top < len(CANDIDATES) - 1:
        return float(CANDIDATES[top])
    before, at, after = likelihood[top - 1 : top + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * at + after)
    return float(CANDIDATES[top] * (CANDIDATES[1] / CANDIDATES[0]) ** shift)
