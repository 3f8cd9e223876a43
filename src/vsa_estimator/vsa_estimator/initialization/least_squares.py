# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Corrected least squares with a prior, for every k2 of the grid.

Noise of the motion adds information about the coefficients that does not exist (errors in variables). Its expectation
is subtracted from the normal matrix (Fuller, "Measurement error models", 1987): on a single sweep of the stroke it
would determine the damper, with a bias.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.initialization.design import normal_matrices
from vsa_estimator.initialization.posterior import Prior
from vsa_estimator.initialization.windows import Slices
from vsa_estimator.tuning.initialization import (
    GRID_SIZE,
    MAX_NOISE_INFORMATION,
    MAX_NOISE_INFORMATION_UNCONSTRAINED,
    NOISE_DRAWS,
)


@dataclass(frozen=True)
class Solution:
    """Coefficients [k1 d1 d2 M F0 d0], SI, for every k2 of the grid."""

    coefficients: Array  # (GRID_SIZE, 6)
    chi2: Array  # (GRID_SIZE,): of the unconstrained solution
    corrected_chi2: Array  # (GRID_SIZE,): expected without noise of the motion, relative to the best
    normal: Array  # (GRID_SIZE, 6, 6), scaled
    spread: Array  # (GRID_SIZE, 6, 6), scaled: covariance of the right-hand side
    std: Array  # (6,): scale

    def covariances(self, inflation: float) -> Array:
        """Covariance of the coefficients for every k2 (GRID_SIZE, 6, 6), times `inflation`."""
        inverse = np.linalg.inv(self.normal)
        scale = inflation * np.outer(self.std, self.std)
        return np.asarray(inverse @ self.spread @ inverse * scale)


def solve(prior: Prior, design: Array, drawn: Array, force: Array) -> Slices[Solution]:
    """Solve for the coefficients, given the outputs of `whitened_design`. A generator of slices.

    A direction with too much noise-induced information stays at the prior. The comparison of the hypotheses uses an
    unconstrained solution: otherwise it prefers those that match the mass of the prior, and the posterior of k2 is
    overconfident.
    """
    noise_information = np.mean([normal_matrices(drawn[:, draw], prior.std) for draw in range(NOISE_DRAWS)], axis=0)
    yield
    measured = normal_matrices(design, prior.std)
    values, vectors = np.linalg.eigh(measured - noise_information)
    yield
    information = (vectors * (measured @ vectors)).sum(1)
    right = np.empty((GRID_SIZE, 6))
    right[:, 0], right[:, 1:] = np.split(force @ design, [GRID_SIZE])
    right *= prior.std
    observable = values > (1.0 - MAX_NOISE_INFORMATION_UNCONSTRAINED) * information
    unconstrained, _, _ = _solve_within(prior, values, vectors, observable, right)
    observable = values > (1.0 - MAX_NOISE_INFORMATION) * information
    scaled, normal, projector = _solve_within(prior, values, vectors, observable, right)
    yield
    spread = projector @ measured @ projector + np.eye(6)
    coefficients = unconstrained * prior.std
    own = design[:, :GRID_SIZE] * coefficients[:, 0]
    common = design[:, GRID_SIZE:] @ coefficients[:, 1:].T
    residual = force[:, None] - own - common
    chi2 = (residual**2).sum(0) + ((unconstrained - prior.scaled) ** 2).sum(1)
    noise_chi2 = np.einsum("bi,bij,bj->b", unconstrained, noise_information, unconstrained)
    corrected_chi2 = chi2 - noise_chi2 + noise_chi2[int(np.argmin(chi2))]
    return Solution(scaled * prior.std, chi2, corrected_chi2, normal, spread, prior.std)


def _solve_within(
    prior: Prior, values: Array, vectors: Array, observable: NDArray[np.bool_], right: Array
) -> tuple[Array, Array, Array]:
    """Scaled solution within the `observable` eigenvectors and the prior elsewhere, normal matrix and projector."""
    basis = vectors * observable[:, None, :]
    projector = basis @ basis.transpose(0, 2, 1)
    normal = (basis * np.maximum(values, 0.0)[:, None, :]) @ basis.transpose(0, 2, 1) + np.eye(6)
    within = np.einsum("bij,bj->bi", projector, right) + prior.scaled
    return np.linalg.solve(normal, within[:, :, None])[:, :, 0], normal, projector
