"""Rows as a regression of the force takes them, and what noise does to them."""

from dataclasses import dataclass

import numpy as np
from vsa_common.types import Array
from vsa_estimator.initialization.windows import BAND, LEAST_ROWS, Rows
from vsa_estimator.tuning.filter import STATIONARY_SPEED

REVERSAL_FORCE = 0.3  # the Coulomb law's error in a row near a reversal [N] ...
REVERSAL_SPEED = 0.3e-3  # ... which is this wide [m/s]
COULOMB_SPEED = 0.1e-3  # of the friction's transition; sharper, a heavy mass starts with a wrong damper [m/s]


@dataclass(frozen=True)
class Problem:
    """Rows of a regression of the force: those that move, and what noise does to them whatever the coefficients."""

    rows: Rows
    dx: Array
    alone: Array  # (BAND + 1, n): covariance of each row with those before it without noise of the motion [N^2]
    shared: Array  # (3, 3, BAND + 1, n): covariance of value, slope and curvature of the motion, of the same rows
    noise: Array  # (3, n, DRAWS): value, slope and curvature of noise as large as the encoder's
    friction: Array  # expected sign of the speed, as far as the rows tell it
    friction_noise: Array  # (n, DRAWS): what noise of the speed does to it

    @classmethod
    def of(cls, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float) -> "Problem | None":
        """Of `rows`, about a `reference` [m]; None where too few move."""
        moving = np.abs(rows.velocity) > STATIONARY_SPEED
        if np.count_nonzero(moving) < LEAST_ROWS:
            return None
        kept = rows.part(moving)
        v, n = kept.velocity, kept.velocity.size
        shared = np.zeros((3, 3, BAND + 1, n))
        alone = np.zeros((BAND + 1, n))
        for b in range(min(BAND + 1, n)):
            apart = kept.place[b:] - kept.place[: n - b]
            found = kept.shared[np.arange(b, n), np.minimum(apart, BAND)] * (apart <= BAND)[:, None, None]
            shared[:, :, b, b:] = deflection_noise_std**2 * found.transpose(1, 2, 0)
            alone[b, b:] = force_noise_std**2 * found[:, 0, 0]
        # A smoothed reversal is as wide as the window's change of speed.
        width = REVERSAL_SPEED**2 + (0.7 * kept.acceleration * kept.half_width) ** 2
        alone[0] += (REVERSAL_FORCE * np.exp(-(v**2) / width)) ** 2
        # and the sign of its speed is blurred by that and by noise [m/s]
        speed_variance = deflection_noise_std**2 * kept.shared[:, 0, 1, 1]
        blur = np.sqrt(COULOMB_SPEED**2 + 1.5 * speed_variance + (0.5 * kept.acceleration * kept.half_width) ** 2)
        noise = deflection_noise_std * kept.noise
        speeds = v[:, None]
        ahead, behind = (np.tanh((speeds + dv) / blur[:, None]) for dv in (noise[1], -noise[1]))
        return cls(
            kept, kept.deflection - reference, alone, shared, noise, np.tanh(v / blur), 0.5 * (ahead - behind)
        )  # fmt: skip

    def covariance(self, sigma: Array, damping: float, mass: float) -> Array:
        """Of the rows' forces [N^2] as `whiten` takes it, given the slopes by which noise of the motion enters them."""
        s = self.shared
        earlier = np.zeros(s.shape[2:])
        for b in range(min(BAND + 1, sigma.size)):
            earlier[b, b:] = sigma[: sigma.size - b]
        of_spring = sigma * s[0, 0] + damping * s[1, 0] + mass * s[2, 0]
        of_damper = sigma * s[0, 1] + damping * s[1, 1] + mass * s[2, 1]
        of_mass = sigma * s[0, 2] + damping * s[1, 2] + mass * s[2, 2]
        found = self.alone + of_spring * earlier + of_damper * damping + of_mass * mass
        return np.ascontiguousarray(found.T)
