"""Smoothed rows of motion and force from overlapping windows, and the covariance of the noise that they share."""

from collections.abc import Generator
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array

LEAST_ROWS = 8
MOST_ROWS = 400
DRAWS = 4  # of pure noise through the same windows, to see what it pretends to know
POOR = 3.0  # times the variance that noise leaves in a window, beyond which no cubic describes it
CHUNK = 40  # windows that are smoothed in one slice
BAND = 4  # neighbours on either side that a row may share samples with

Result = TypeVar("Result")
Slices = Generator[None, None, Result]  # yields between slices of work


@dataclass(frozen=True)
class Rows:
    """Smoothed motion and force, one row for each place of the smoothing window."""

    deflection: Array
    velocity: Array
    acceleration: Array
    force: Array
    place: NDArray[np.int64]  # of the window, in strides
    shared: Array  # (n, BAND + 1, 3, 3): products of value, slope and curvature weights with those `m` places before
    noise: Array  # (3, n, DRAWS): value, slope, curvature of unit white noise
    described: NDArray[np.bool_]  # whether the window's cubics describe motion and force but for noise
    half_width: float  # [s]

    def part(self, mask: NDArray[np.bool_]) -> "Rows":
        """The rows that a mask picks."""
        return Rows(
            self.deflection[mask], self.velocity[mask], self.acceleration[mask], self.force[mask], self.place[mask],
            self.shared[mask], self.noise[:, mask], self.described[mask], self.half_width,
        )  # fmt: skip


def smooth(
    time: Array, deflection: Array, force: Array, period: float, noise_std: float, force_std: float, jerk_density: float
) -> Slices[Rows | None]:
    """Local cubics through deflection and force over one window; None where there is too little data.

    The window is as long as the motion allows: its bias and its noise meet near the frequency w_c.
    """
    w_c = (jerk_density / (noise_std**2 * period)) ** (1.0 / 6.0)
    half = int(np.clip(round(min(0.5, 3.3 / w_c) / period), 3, max(3, time.size // 4)))
    stride = max(-(-half // 2), -(-time.size // MOST_ROWS))
    centre = np.arange(half, time.size - half, stride)
    if centre.size == 0:
        return None
    centre = centre[time[centre + half] - time[centre - half] < (2 * half + 0.5) * period * 1.1]
    if centre.size < LEAST_ROWS:
        return None
    scale = half * period
    place = centre // stride
    noise = _white(1 << time.size.bit_length())[: time.size]
    weights = np.empty((centre.size, 3, 2 * half + 1))
    motion, smoothed_force = np.empty((centre.size, 3)), np.empty(centre.size)
    through = np.empty((3, centre.size, DRAWS))
    described = np.empty(centre.size, dtype=bool)
    for first in range(0, centre.size, CHUNK):
        yield
        part = slice(first, first + CHUNK)
        pick = centre[part, None] + np.arange(-half, half + 1)
        u = (time[pick] - time[centre[part]][:, None]) / scale
        basis = np.stack([np.ones_like(u), u, u * u, u * u * u], axis=1)
        cubic = np.linalg.inv(basis @ basis.transpose(0, 2, 1)) @ basis
        described[part] = _describes(basis, cubic, deflection[pick], noise_std)
        described[part] &= _describes(basis, cubic, force[pick], force_std)
        weights[part] = cubic[:, :3] * np.array([1.0, 1.0 / scale, 2.0 / scale**2])[:, None]
        motion[part] = np.einsum("nij,nj->ni", weights[part], deflection[pick])
        smoothed_force[part] = np.einsum("nj,nj->n", weights[part, 0], force[pick])
        through[:, part] = np.einsum("nij,njd->ind", weights[part], noise[pick])
    yield
    shared = np.zeros((centre.size, BAND + 1, 3, 3))
    shared[:, 0] = weights @ weights.transpose(0, 2, 1)
    for m in range(1, BAND + 1):
        yield
        before = np.searchsorted(place, place - m)
        pair = (place[before] == place - m) & (m * stride <= 2 * half)
        later, earlier = weights[pair][:, :, : -m * stride], weights[before[pair]][:, :, m * stride :]
        shared[pair, m] = later @ earlier.transpose(0, 2, 1)
    yield
    return Rows(
        motion[:, 0], motion[:, 1], motion[:, 2], smoothed_force, place, shared, through, described, half * period
    )


@lru_cache(maxsize=2)
def _white(size: int) -> Array:
    """Noise of unit variance (size, DRAWS), always the same."""
    return np.random.default_rng(0).standard_normal((size, DRAWS))


def _describes(basis: Array, cubic: Array, values: Array, std: float) -> NDArray[np.bool_]:
    """Of each window (n, m), whether its cubic is off by no more than noise; it is at a kink, or when a step begins."""
    apart = values - np.einsum("nkj,nk->nj", basis, np.einsum("nkj,nj->nk", cubic, values))
    return np.asarray((apart**2).sum(1) < POOR * std**2 * (values.shape[1] - 4))


@compiled
def whiten(covariance: Array, columns: Array) -> None:
    """Columns (n, c) into white ones of unit variance, in place.

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
        if i >= BAND:  # all BAND of them at once: a third of the time
            columns[i] = (
                columns[i] - row[1] * columns[i - 1] - row[2] * columns[i - 2] - row[3] * columns[i - 3]
                - row[4] * columns[i - 4]
            ) / row[0]  # fmt: skip
        else:
            for b in range(1, i + 1):
                columns[i] -= row[b] * columns[i - b]
            columns[i] /= row[0]
