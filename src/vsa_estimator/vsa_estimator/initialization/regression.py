# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Posterior of the coefficients from smoothed rows: two hypothesis grids over k2, one on each side of v*."""

import numpy as np
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.initialization.grid import HypothesisGrid
from vsa_estimator.initialization.posterior import Fit, Prior, match_moments
from vsa_estimator.initialization.row_noise import NoisyRows
from vsa_estimator.initialization.windows import Rows, Slices
from vsa_estimator.tuning.initialization import GRID_PASSES, SECOND_START_RATIO


def regress(
    prior: Prior, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float
) -> Slices[Fit | None]:
    """Fit the coefficients about a `reference` [m]; None where too few rows move. Noise [N, m] of one sample.

    Each grid counts by its likelihood: where a damper above v* explains the force as well as one below, the covariance
    covers both. A generator of slices of a fraction of a millisecond each, so that no sample is delayed for longer.
    """
    noisy = NoisyRows.of(rows, reference, force_noise_std, deflection_noise_std)
    if noisy is None:
        return None
    _, d1, d2, *_ = prior.mean
    prior_speed = peak_speed(d1, d2)
    grids = []
    for speed in (prior_speed, SECOND_START_RATIO * prior_speed):
        yield
        grid = HypothesisGrid(prior, noisy, speed)
        for _ in range(GRID_PASSES):
            yield from grid.refine()
            yield
        grids.append(grid)
    costs = np.array([grid.cost for grid in grids])
    weights = np.exp(-0.5 * (costs - costs.min()))
    fits = []
    for grid in grids:
        fits.append(grid.fit())
        yield
    return match_moments(fits, weights / weights.sum())
