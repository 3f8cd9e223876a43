# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Successive fits are fused: an inconsistent step widens the covariance; a mixture keeps its moments."""

import numpy as np
import pytest
from vsa_estimator.initialization.posterior import Fit, match_moments
from vsa_estimator.tuning.initialization import INCONSISTENCY_DECAY


def fit(ln_stiffness=7.0, std=0.01, k2=250.0) -> Fit:
    mean = np.array([ln_stiffness, k2, 4e3, -1e8, 0.4, 16.0, 0.3])
    return Fit(mean, np.diag([std**2, 25.0, 1e4, 1e14, 0.1, 0.1, 0.01]), 0.02, 0.01, 1e-3)


def test_an_inconsistent_step_is_added_to_the_covariance_and_decays():
    first, near, far = fit(7.0, 0.1), fit(7.2, 0.03), fit(7.4, 0.03)
    assert first.fuse_with_previous(None) is first
    assert np.array_equal(near.fuse_with_previous(first).covariance, near.covariance)
    inconsistent = far.fuse_with_previous(first)
    assert np.array_equal(inconsistent.mean, far.mean)
    assert inconsistent.covariance[0, 0] == pytest.approx(0.4**2 + 0.03**2)
    back = near.fuse_with_previous(inconsistent)  # consistent with so large a covariance, but the decay takes time
    assert back.covariance[0, 0] == pytest.approx((INCONSISTENCY_DECAY * 0.4) ** 2 + 0.03**2)
    later = near.fuse_with_previous(back)
    assert later.covariance[0, 0] == pytest.approx((INCONSISTENCY_DECAY**2 * 0.4) ** 2 + 0.03**2)


def test_an_inconsistent_step_of_k2_is_added_to_the_standard_deviation_of_ln_k2():
    assert fit(k2=260.0).fuse_with_previous(fit()).ln_k2_std == pytest.approx(0.02)
    inconsistent = fit(k2=230.0).fuse_with_previous(fit())
    assert inconsistent.covariance[1, 1] == pytest.approx(20.0**2 + 25.0)
    assert inconsistent.ln_k2_std == pytest.approx(np.hypot(0.02, 20.0 / 230.0))


def test_a_mixture_has_the_mean_and_the_covariance_of_samples_from_its_components():
    fits, weights = [fit(7.0, 0.1, 250.0), fit(7.5, 0.2, 270.0)], np.array([0.25, 0.75])
    mixed = match_moments(fits, weights)
    assert mixed.mean[0] == pytest.approx(0.25 * 7.0 + 0.75 * 7.5)
    assert mixed.covariance[0, 0] == pytest.approx(0.25 * 0.1**2 + 0.75 * 0.2**2 + 0.25 * 0.75 * 0.5**2)
    assert mixed.covariance[0, 1] == pytest.approx(0.25 * 0.75 * 0.5 * 20.0)
