# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Smoothed rows of motion and force from overlapping windows, with the weights by which they share noise."""

from collections.abc import Generator
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.tuning.initialization import (
    HALF_WINDOW_PHASE,
    MAX_HALF_WINDOW,
    MAX_RESIDUAL_RATIO,
    MAX_ROWS,
    MIN_ROWS,
    NOISE_DRAWS,
    WINDOW_TIME_RATIO,
    WINDOWS_PER_SLICE,
)

BAND = 4  # preceding rows that a row may share samples with; `row_noise.whiten` is written for this number

Result = TypeVar("Result")
Slices = Generator[None, None, Result]  # yields between slices of work


@dataclass(frozen=True)
class Rows:
    """Smoothed motion and force, one row for each of n windows."""

    deflection: Array  # [m]
    velocity: Array  # [m/s]
    acceleration: Array  # [m/s^2]
    force: Array  # [N]
    index: NDArray[np.int64]  # of the window, in strides
    unit_covariance: Array  # (n, BAND + 1, 3, 3): of value, slope, curvature with those `m` windows before, unit noise
    noise_draws: Array  # (3, n, NOISE_DRAWS): value, slope, curvature of white noise of unit variance
    is_well_fitted: NDArray[np.bool_]  # the residuals of both cubics are no larger than noise
    half_width: float  # [s]

    def select(self, mask: NDArray[np.bool_]) -> "Rows":
        """The rows where `mask` (n,) is set."""
        return Rows(
            deflection=self.deflection[mask],
            velocity=self.velocity[mask],
            acceleration=self.acceleration[mask],
            force=self.force[mask],
            index=self.index[mask],
            unit_covariance=self.unit_covariance[mask],
            noise_draws=self.noise_draws[:, mask],
            is_well_fitted=self.is_well_fitted[mask],
            half_width=self.half_width,
        )


def smooth(
    time: Array, deflection: Array, force: Array, period: float, noise_std: float, force_std: float, jerk_density: float
) -> Slices[Rows | None]:
    """Local cubics through deflection [m] and force [N] over the same windows; None where there is too little data.

    `time` [s] has steps of `period` or more; `noise_std` [m] and `force_std` [N] are those of one sample,
    `jerk_density` [m^2/s^5]. A generator of slices.
    """
    w_c = (jerk_density / (noise_std**2 * period)) ** (1.0 / 6.0)  # bias and noise of a cubic are equal near it
    half = int(np.clip(round(min(MAX_HALF_WINDOW, HALF_WINDOW_PHASE / w_c) / period), 3, max(3, time.size // 4)))
    stride = max(-(-half // 2), -(-time.size // MAX_ROWS))
    centre = _centres(time, half, stride, period)
    if centre.size < MIN_ROWS:
        return None
    scale = half * period
    noise = _white_noise(1 << time.size.bit_length())[: time.size]
    weights = np.empty((centre.size, 3, 2 * half + 1))
    motion, smoothed_force = np.empty((centre.size, 3)), np.empty(centre.size)
    noise_draws = np.empty((3, centre.size, NOISE_DRAWS))
    is_well_fitted = np.empty(centre.size, dtype=bool)
    for first in range(0, centre.size, WINDOWS_PER_SLICE):
        yield
        part = slice(first, first + WINDOWS_PER_SLICE)
        window = centre[part, None] + np.arange(-half, half + 1)
        u = (time[window] - time[centre[part]][:, None]) / scale
        basis, cubic = _cubics(u)
        is_well_fitted[part] = _fits(basis, cubic, deflection[window], noise_std)
        is_well_fitted[part] &= _fits(basis, cubic, force[window], force_std)
        weights[part] = cubic[:, :3] * np.array([1.0, 1.0 / scale, 2.0 / scale**2])[:, None]
        motion[part] = np.einsum("nij,nj->ni", weights[part], deflection[window])
        smoothed_force[part] = np.einsum("nj,nj->n", weights[part, 0], force[window])
        noise_draws[:, part] = np.einsum("nij,njd->ind", weights[part], noise[window])
    yield
    unit_covariance = yield from _unit_covariance(weights, centre // stride, stride)
    yield
    return Rows(
        deflection=motion[:, 0], velocity=motion[:, 1], acceleration=motion[:, 2], force=smoothed_force,
        index=centre // stride, unit_covariance=unit_covariance, noise_draws=noise_draws,
        is_well_fitted=is_well_fitted, half_width=scale,
    )  # fmt: skip


def _centres(time: Array, half: int, stride: int, period: float) -> NDArray[np.int64]:
    """Centre samples of the windows that contain no gap."""
    centre = np.arange(half, time.size - half, stride)
    span = time[centre + half] - time[centre - half]
    return np.asarray(centre[span < (2 * half + 0.5) * period * WINDOW_TIME_RATIO])


def _cubics(u: Array) -> tuple[Array, Array]:
    """Basis (n, 4, m) of a cubic in `u` (n, m) and the weights of its least-squares coefficients."""
    basis = np.stack([np.ones_like(u), u, u * u, u * u * u], axis=1)
    return basis, np.asarray(np.linalg.inv(basis @ basis.transpose(0, 2, 1)) @ basis)


def _unit_covariance(weights: Array, index: NDArray[np.int64], stride: int) -> Slices[Array]:
    """Covariance (n, BAND + 1, 3, 3) of each row with those `m` windows before, at white noise of unit variance.

    `weights` (n, 3, samples) of value, slope and curvature; rows share samples where their windows overlap.
    """
    covariance = np.zeros((len(index), BAND + 1, 3, 3))
    covariance[:, 0] = weights @ weights.transpose(0, 2, 1)
    for m in range(1, BAND + 1):
        yield
        before = np.searchsorted(index, index - m)
        pair = (index[before] == index - m) & (m * stride < weights.shape[2])
        later, earlier = weights[pair][:, :, : -m * stride], weights[before[pair]][:, :, m * stride :]
        covariance[pair, m] = later @ earlier.transpose(0, 2, 1)
    return covariance


@lru_cache(maxsize=2)
def _white_noise(size: int) -> Array:
    """Noise of unit variance (size, NOISE_DRAWS), the same at each call."""
    return np.random.default_rng(0).standard_normal((size, NOISE_DRAWS))


def _fits(basis: Array, cubic: Array, values: Array, std: float) -> NDArray[np.bool_]:
    """For each window of `values` (n, m), whether the residual of its cubic is no larger than noise.

    It is larger at a discontinuity of the slope and at the start of a step.
    """
    residual = values - np.einsum("nkj,nk->nj", basis, np.einsum("nkj,nj->nk", cubic, values))
    return np.asarray((residual**2).sum(1) < MAX_RESIDUAL_RATIO * std**2 * (values.shape[1] - 4))
