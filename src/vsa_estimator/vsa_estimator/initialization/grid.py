# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Hypothesis grid over k2 (multiple model): a linear regression for each k2, weighted by its likelihood."""

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.elastic import relative_stiffness
from vsa_estimator.initialization.design import whitened_design
from vsa_estimator.initialization.least_squares import Solution, solve
from vsa_estimator.initialization.posterior import Fit, Prior
from vsa_estimator.initialization.row_noise import NoisyRows
from vsa_estimator.initialization.windows import Slices
from vsa_estimator.tuning.force_law import MIN_D1
from vsa_estimator.tuning.initialization import (
    COVARIANCE_INFLATION,
    DAMPING_STDS,
    GRID_HALF_WIDTH,
    GRID_SIZE,
    GRID_ZOOM_STDS,
    GRID_ZOOM_STEPS,
    MAX_DAMPING,
    START_DAMPING,
    START_STIFFNESS,
)

NEGATIVE_SPRING_COST = 1e6  # excludes a hypothesis with k1 <= 0
MIN_LN_K2_STD = 1e-4
MIN_K1 = 1e-6  # [N]: keeps ln k1 finite


class HypothesisGrid:
    """Hypotheses over k2, refined pass by pass from one assumption of v*."""

    def __init__(self, prior: Prior, noisy: NoisyRows, speed: float) -> None:
        """`speed` is the first v* [m/s]."""
        self.cost = np.inf  # of the best hypothesis
        self._prior = prior
        self._noisy = noisy
        self._speed = speed
        grid = np.linspace(-GRID_HALF_WIDTH, GRID_HALF_WIDTH, GRID_SIZE)
        self._next_ln_k2: Array = np.asarray(prior.ln_k2 + grid, dtype=np.float64)
        self._row_covariance = noisy.covariance(np.full_like(noisy.dx, START_STIFFNESS), START_DAMPING, 0.0)
        # Of the last pass:
        self._ln_k2: Array
        self._ln_k2_std: float
        self._weights: Array
        self._solution: Solution
        self._covariances: Array

    def refine(self) -> Slices[None]:
        """Solve for every k2 and weight the solutions; then narrow the grid, and update v* and the rows' covariance.

        A generator of slices.
        """
        self._ln_k2 = self._next_ln_k2
        k2 = np.exp(self._ln_k2)
        growth = relative_stiffness(k2[:, None], self._noisy.dx)
        yield
        design, drawn, force = yield from whitened_design(self._noisy, self._row_covariance, k2, growth, self._speed)
        self._solution = yield from solve(self._prior, design, drawn, force)
        yield
        inflation = COVARIANCE_INFLATION * max(1.0, float(self._solution.chi2.min()) / max(force.size - 6, 1))
        self._covariances = self._solution.covariances(inflation)
        best, mean = self._weight(inflation)
        self._update_row_covariance(best, growth[best])
        step = self._ln_k2[1] - self._ln_k2[0]
        half_width = min(GRID_ZOOM_STDS * self._ln_k2_std + GRID_ZOOM_STEPS * step, GRID_HALF_WIDTH)
        self._next_ln_k2 = mean + half_width * np.linspace(-1.0, 1.0, GRID_SIZE)

    def fit(self) -> Fit:
        """Mean and covariance of [s k2 d1 d2 M F0 d0] by moment matching over all hypotheses."""
        k2 = np.exp(self._ln_k2)
        coefficients = self._solution.coefficients
        k1 = np.maximum(coefficients[:, 0], MIN_K1)
        states = np.column_stack([np.log(k1 * k2), k2, coefficients[:, 1:]])
        mean = self._weights @ states
        apart = states - mean
        covariance = (self._weights[:, None] * apart).T @ apart
        for weight, scale, own in zip(self._weights, k1, self._covariances, strict=True):
            gradient = np.zeros((7, 6))
            gradient[0, 0] = 1.0 / scale
            gradient[2:, 1:] = np.eye(5)
            covariance += weight * gradient @ own @ gradient.T
        rows = self._noisy.rows
        acceleration = float(np.sqrt(np.mean(rows.acceleration**2)))
        return Fit(mean, covariance, self._ln_k2_std, float(np.ptp(rows.deflection)), acceleration)

    def _weight(self, inflation: float) -> tuple[int, float]:
        """Weight the hypotheses by their posterior probability; the index of the best one and the mean of ln k2."""
        solution, prior = self._solution, self._prior
        distance = ((self._ln_k2 - prior.ln_k2) / prior.ln_k2_std) ** 2
        penalty = np.where(solution.coefficients[:, 0] > 0.0, 0.0, NEGATIVE_SPRING_COST)
        cost = solution.corrected_chi2 / inflation + distance + penalty
        best = int(np.argmin(cost))
        self._weights = np.exp(-0.5 * (cost - cost[best]))
        self._weights /= self._weights.sum()
        self.cost = float(solution.chi2[best] + distance[best])
        mean, self._ln_k2_std = _moments(self._ln_k2, self._weights, cost, best)
        return best, mean

    def _update_row_covariance(self, best: int, growth: Array) -> None:
        """Update v* and the rows' covariance by the best hypothesis; `growth` is its exp(k2 dx) at each row."""
        k1, d1, d2, mass = self._solution.coefficients[best, :4]
        sigma = k1 * np.exp(self._ln_k2[best]) * growth if k1 > 0.0 else np.full(growth.size, START_STIFFNESS)
        self._speed = peak_speed(max(d1, MIN_D1), d2)
        d1_std = float(np.sqrt(self._covariances[best, 1, 1]))
        damping = min(max(d1 + DAMPING_STDS * d1_std, MIN_D1), MAX_DAMPING)
        self._row_covariance = self._noisy.covariance(sigma, damping, max(mass, 0.0))


def _moments(ln_k2: Array, weights: Array, cost: Array, best: int) -> tuple[float, float]:
    """Mean and standard deviation of ln k2; of a parabola through `cost` where the grid is too coarse."""
    step = ln_k2[1] - ln_k2[0]
    mean = float(weights @ ln_k2)
    std = float(np.sqrt(weights @ (ln_k2 - mean) ** 2))
    if 0 < best < GRID_SIZE - 1 and std < step:
        curvature = (cost[best + 1] - 2.0 * cost[best] + cost[best - 1]) / step**2
        slope = (cost[best + 1] - cost[best - 1]) / (2.0 * step)
        if curvature > 0.0:
            mean = float(ln_k2[best] - np.clip(slope / curvature, -step, step))
            std = max(float(np.sqrt(2.0 / curvature)), MIN_LN_K2_STD)
    return mean, std
