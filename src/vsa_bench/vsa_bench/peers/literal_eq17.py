# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The paper's filter exactly as eq. (17) prints it, as a reference.

States z1 to z8 = [x v a sigma D M k2 d2]; the force rate of a first-order filter is the input, deflection the
measurement. Row 3 has (z4 + z3 z5) where eq. (14) has (z4 z2 + z3 z5), rows 4 and 5 have factors 3 and 18 where eqs.
(15) and (16) give 1 and 6. In the paper's units (N, mm, s), many recordings side by side.
"""

from dataclasses import dataclass

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_rate.rate_filter import filtered_rate
from vsa_estimator.tuning.force_rate import RATE_FILTER

DIVERGED = 1e9  # magnitude of a state beyond which a run counts as diverged


@dataclass(frozen=True)
class Start:
    """Start values (recordings, 8) and their standard deviations, SI; noise of the two inputs."""

    state: Array
    std: Array
    force_noise: float  # [N]
    deflection_noise: float  # [m]


SCALE = np.array([1e3, 1e3, 1e3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-9])  # SI to N, mm, s (mass: N s^2/mm)


def run(force: Array, deflection: Array, rate: float, start: Start) -> Array:
    """States of eq. (17) in SI, (recordings, samples, 8); NaN from where a run has diverged."""
    dt = 1.0 / rate
    force_rate = filtered_rate(force, dt)
    rate_variance = (2.0 * start.force_noise / RATE_FILTER) ** 2
    z = start.state * SCALE
    p = np.einsum("si,ij->sij", (start.std * SCALE) ** 2, np.eye(8))
    measured = deflection * 1e3
    noise = (start.deflection_noise * 1e3) ** 2
    result = np.full((*force.shape, 8), np.nan)
    with np.errstate(all="ignore"):
        for k in range(force.shape[1]):
            if k:
                z, jacobian, by_input = _step(z, force_rate[:, k - 1], dt)
                p = (
                    jacobian @ p @ np.swapaxes(jacobian, 1, 2)
                    + rate_variance * by_input[:, :, None] * by_input[:, None, :]
                )
            gain = p[:, :, 0] / (p[:, 0, 0] + noise)[:, None]
            z = z + gain * (measured[:, k] - z[:, 0])[:, None]
            reduce = np.tile(np.eye(8), (len(z), 1, 1))
            reduce[:, :, 0] -= gain
            p = reduce @ p @ np.swapaxes(reduce, 1, 2) + noise * gain[:, :, None] * gain[:, None, :]
            z[~(np.abs(z).max(axis=1) < DIVERGED)] = np.nan
            result[:, k] = z / SCALE
    return result


def _step(z: Array, u: Array, dt: float) -> tuple[Array, Array, Array]:
    """Eq. (17), its Jacobian by the state and by the force rate."""
    z1, z2, z3, z4, z5, z6, z7, z8 = z.T
    new = np.stack(
        [
            z1 + dt * z2,
            z2 + dt * z3,
            z3 - (z4 + z3 * z5) * dt / z6 + u * dt / z6,
            z4 + 3.0 * z2 * z4 * z7 * dt,
            z5 + 18.0 * z2 * z3 * z8 * dt,
            z6,
            z7,
            z8,
        ],
        axis=1,
    )
    jacobian = np.tile(np.eye(8), (len(z), 1, 1))
    jacobian[:, 0, 1] = dt
    jacobian[:, 1, 2] = dt
    jacobian[:, 2, 2] -= z5 * dt / z6
    jacobian[:, 2, 3] = -dt / z6
    jacobian[:, 2, 4] = -z3 * dt / z6
    jacobian[:, 2, 5] = (z4 + z3 * z5 - u) * dt / z6**2
    jacobian[:, 3, 1] = 3.0 * z4 * z7 * dt
    jacobian[:, 3, 3] += 3.0 * z2 * z7 * dt
    jacobian[:, 3, 6] = 3.0 * z2 * z4 * dt
    jacobian[:, 4, 1] = 18.0 * z3 * z8 * dt
    jacobian[:, 4, 2] = 18.0 * z2 * z8 * dt
    jacobian[:, 4, 7] = 18.0 * z2 * z3 * dt
    by_input = np.zeros_like(z)
    by_input[:, 2] = dt / z6
    return new, jacobian, by_input
