# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Whitened design of the regression for every k2 of the grid, and the information that noise adds to it.

With k2 given, the force of eq. (6) is linear in [k1 d1 d2 M F0 d0] except for the damper's clip at v*. The designs
differ in their first column, the spring's; the other five are common.
"""

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.initialization.row_noise import NoisyRows, whiten
from vsa_estimator.initialization.windows import Slices
from vsa_estimator.tuning.initialization import GRID_SIZE, NOISE_DRAWS

WIDTH = GRID_SIZE + 5  # columns: a spring for each k2, damper (two), mass, offset, friction


def whitened_design(
    noisy: NoisyRows, covariance: Array, k2: Array, growth: Array, speed: float
) -> Slices[tuple[Array, Array, Array]]:
    """Design (n, WIDTH), designs of noise alone (n, NOISE_DRAWS, WIDTH) and force (n,), whitened by `covariance`.

    `growth` (GRID_SIZE, n) is exp(k2 dx) for each `k2` [1/m]; the damper is clipped at `speed` [m/s]. A generator of
    slices.
    """
    rows, v = noisy.rows, noisy.rows.velocity
    clipped = np.clip(v, -speed, speed)
    columns = np.empty((v.size, WIDTH + 1 + NOISE_DRAWS * WIDTH))
    columns[:, :GRID_SIZE] = growth.T
    columns[:, GRID_SIZE:WIDTH] = np.column_stack(
        [clipped, clipped**3, rows.acceleration, np.ones(v.size), noisy.friction_sign]
    )  # fmt: skip
    columns[:, WIDTH] = rows.force
    drawn = columns[:, WIDTH + 1 :].reshape(v.size, NOISE_DRAWS, WIDTH)
    yield
    _propagate_noise(drawn, noisy, (k2[:, None] * growth).T, clipped, np.abs(v) < speed)
    yield
    whiten(covariance, columns)
    yield
    return columns[:, :WIDTH], drawn, columns[:, WIDTH]


def _propagate_noise(
    design: Array, noisy: NoisyRows, spring_slope: Array, clipped: Array, is_below: NDArray[np.bool_]
) -> None:
    """Write the change of the design by deflection noise into `design` (n, NOISE_DRAWS, WIDTH)."""
    dx, dv, da = noisy.noise_draws
    below = is_below.astype(float)
    np.multiply(spring_slope[:, None, :], dx[:, :, None], out=design[:, :, :GRID_SIZE])
    design[:, :, GRID_SIZE] = below[:, None] * dv
    design[:, :, GRID_SIZE + 1] = (3.0 * clipped * clipped * below)[:, None] * dv
    design[:, :, GRID_SIZE + 2] = da
    design[:, :, GRID_SIZE + 3] = 0.0
    design[:, :, GRID_SIZE + 4] = noisy.friction_noise


def normal_matrices(design: Array, std: Array) -> Array:
    """Normal matrix of each k2 (GRID_SIZE, 6, 6) in units of the prior's standard deviations `std` (6,)."""
    own, common = design[:, :GRID_SIZE], design[:, GRID_SIZE:]
    normal = np.empty((GRID_SIZE, 6, 6))
    normal[:, 0, 0] = np.einsum("nb,nb->b", own, own)
    normal[:, 0, 1:] = normal[:, 1:, 0] = own.T @ common
    normal[:, 1:, 1:] = common.T @ common
    return normal * np.outer(std, std)
