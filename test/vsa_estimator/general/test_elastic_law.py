# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Growth of the exponential law that fits ln stiffness at knots."""

import numpy as np
import pytest
from vsa_estimator.general.elastic_law import fitted_growth

KNOTS = np.linspace(0.004, 0.016, 13)


def test_the_fitted_growth_has_the_error_that_its_covariance_states():
    generator = np.random.default_rng(2)
    factor = 0.01 * generator.standard_normal((13, 13))
    covariance = factor @ factor.T
    samples = generator.multivariate_normal(7.0 + 250.0 * (KNOTS - 0.01), covariance, 2000)
    fits = [fitted_growth(KNOTS, one, covariance, (200.0, 1e6)) for one in samples]
    design = np.stack([np.ones(13), KNOTS], axis=1)
    information = design.T @ np.linalg.solve(covariance + 1e-8 * np.eye(13), design)
    assert np.mean(fits) == pytest.approx(250.0, abs=0.2)
    assert np.std(fits) == pytest.approx(np.sqrt(np.linalg.inv(information)[1, 1]), rel=0.1)


def test_without_information_the_growth_is_that_of_the_prior():
    assert fitted_growth(KNOTS, 300.0 * KNOTS, 1e6 * np.eye(13), (200.0, 50.0)) == pytest.approx(200.0, abs=0.1)


def test_knots_at_which_the_stiffness_may_be_zero_have_no_part_in_the_growth():
    variance = np.where(KNOTS < 0.008, 1e4, 1e-4)
    law = np.where(KNOTS < 0.008, -7.0, 300.0 * KNOTS)
    correlated = np.sqrt(np.outer(variance, variance)) * (0.999 + 0.001 * np.eye(13))
    assert fitted_growth(KNOTS, law, correlated, (200.0, 1e6)) == pytest.approx(300.0, abs=1.0)
