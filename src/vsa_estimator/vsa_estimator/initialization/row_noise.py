# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Noise of the rows of a regression: covariance of their forces, Monte Carlo draws, and whitening."""

from dataclasses import dataclass

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.initialization.windows import BAND, Rows
from vsa_estimator.tuning.filter import STATIONARY_SPEED
from vsa_estimator.tuning.initialization import (
    COULOMB_NOISE_FACTOR,
    COULOMB_SPEED,
    COULOMB_WINDOW_SHARE,
    MIN_ROWS,
    REVERSAL_FORCE,
    REVERSAL_SPEED,
    REVERSAL_WINDOW_SHARE,
)


@dataclass(frozen=True)
class NoisyRows:
    """The n rows of a regression of the force that move, with the noise that does not depend on the coefficients."""

    rows: Rows
    dx: Array  # deflection off the reference [m]
    own_covariance: Array  # (BAND + 1, n): of each row with those before it, without noise of the motion [N^2]
    shared_covariance: Array  # (3, 3, BAND + 1, n): of value, slope and curvature of the motion, for the same rows
    noise_draws: Array  # (3, n, NOISE_DRAWS): value, slope and curvature of the deflection noise
    friction_sign: Array  # expected sign of the speed
    friction_noise: Array  # (n, NOISE_DRAWS): change of the friction's sign by noise of the speed

    @classmethod
    def of(
        cls, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float
    ) -> "NoisyRows | None":
        """Of `rows` about a `reference` [m], with the noise [N, m] of one sample; None where too few rows move."""
        moving = np.abs(rows.velocity) > STATIONARY_SPEED
        if np.count_nonzero(moving) < MIN_ROWS:
            return None
        rows = rows.select(moving)
        own, shared = _covariances(rows, force_noise_std, deflection_noise_std)
        v = rows.velocity
        speed_variance = deflection_noise_std**2 * rows.unit_covariance[:, 0, 1, 1]
        width = np.sqrt(  # of the smoothed friction transition [m/s]
            COULOMB_SPEED**2
            + COULOMB_NOISE_FACTOR * speed_variance
            + (COULOMB_WINDOW_SHARE * rows.acceleration * rows.half_width) ** 2
        )
        draws = deflection_noise_std * rows.noise_draws
        speeds = v[:, None]
        plus, minus = (np.tanh((speeds + dv) / width[:, None]) for dv in (draws[1], -draws[1]))
        return cls(
            rows=rows,
            dx=rows.deflection - reference,
            own_covariance=own,
            shared_covariance=shared,
            noise_draws=draws,
            friction_sign=np.tanh(v / width),
            friction_noise=0.5 * (plus - minus),
        )

    def covariance(self, sigma: Array, damping: float, mass: float) -> Array:
        """Covariance (n, BAND + 1) of the rows' forces [N^2] as `whiten` takes it.

        Noise of the motion enters them by stiffness `sigma` (n,), `damping` and `mass`, SI.
        """
        s = self.shared_covariance
        earlier = np.zeros(s.shape[2:])
        for b in range(min(BAND + 1, sigma.size)):
            earlier[b, b:] = sigma[: sigma.size - b]
        of_spring = sigma * s[0, 0] + damping * s[1, 0] + mass * s[2, 0]
        of_damper = sigma * s[0, 1] + damping * s[1, 1] + mass * s[2, 1]
        of_mass = sigma * s[0, 2] + damping * s[1, 2] + mass * s[2, 2]
        result = self.own_covariance + of_spring * earlier + of_damper * damping + of_mass * mass
        return np.ascontiguousarray(result.T)


def _covariances(rows: Rows, force_noise_std: float, deflection_noise_std: float) -> tuple[Array, Array]:
    """Own covariance (BAND + 1, n), of force noise and friction, and shared covariance of the motion (3, 3, ...)."""
    n = rows.velocity.size
    own, shared = np.zeros((BAND + 1, n)), np.zeros((3, 3, BAND + 1, n))
    for b in range(min(BAND + 1, n)):
        apart = rows.index[b:] - rows.index[: n - b]
        unit = rows.unit_covariance[np.arange(b, n), np.minimum(apart, BAND)] * (apart <= BAND)[:, None, None]
        shared[:, :, b, b:] = deflection_noise_std**2 * unit.transpose(1, 2, 0)
        own[b, b:] = force_noise_std**2 * unit[:, 0, 0]
    # Smoothing widens a reversal by the change of speed within the window.
    width = REVERSAL_SPEED**2 + (REVERSAL_WINDOW_SHARE * rows.acceleration * rows.half_width) ** 2
    own[0] += (REVERSAL_FORCE * np.exp(-(rows.velocity**2) / width)) ** 2
    return own, shared


@compiled
def whiten(covariance: Array, columns: Array) -> None:
    """Multiply `columns` (n, c) by the inverse Cholesky factor of their `covariance`, in place.

    covariance: (n, BAND + 1), of each row with those up to BAND before it; its lower Cholesky factor replaces it.
    """
    for i in range(covariance.shape[0]):
        row = covariance[i]
        scale = row[0]
        for b in range(min(BAND, i), 0, -1):
            other = covariance[i - b]
            for k in range(b + 1, min(BAND, i) + 1):
                row[b] -= row[k] * other[k - b]
            row[b] /= other[0]
            row[0] -= row[b] * row[b]
        row[0] = np.sqrt(max(row[0], 1e-6 * scale))
        if i >= BAND:  # one expression over all BAND rows takes a third of the time of the loop below
            columns[i] = (
                columns[i] - row[1] * columns[i - 1] - row[2] * columns[i - 2] - row[3] * columns[i - 3]
                - row[4] * columns[i - 4]
            ) / row[0]  # fmt: skip
        else:
            for b in range(1, i + 1):
                columns[i] -= row[b] * columns[i - b]
            columns[i] /= row[0]
