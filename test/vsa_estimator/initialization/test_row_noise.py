# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Noise of the rows: whitening and the noise of rows at rest."""

import numpy as np
import pytest
from vsa_estimator.initialization.row_noise import whiten
from vsa_estimator.initialization.windows import BAND


def test_rows_with_correlated_noise_become_white():
    random = np.random.default_rng(3)
    full = np.convolve(random.standard_normal(400_003), [0.5, 1.0, -0.7, 0.3])[3:-3].reshape(-1, 20)
    kernel = np.correlate([0.5, 1.0, -0.7, 0.3], [0.5, 1.0, -0.7, 0.3], "full")[3:]
    covariance = np.zeros((20, BAND + 1))
    for apart, value in enumerate(kernel):
        covariance[apart:, apart] = value
    columns = full.T.copy()
    whiten(covariance, columns)
    assert np.cov(columns) == pytest.approx(np.eye(20), abs=0.04)
