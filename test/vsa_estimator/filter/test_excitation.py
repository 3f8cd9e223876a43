# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of the excitation: variance of the rod's vibration near and beyond v*."""

import numpy as np
import pytest
from vsa_estimator.filter.excitation import accumulate_vibration
from vsa_estimator.filter.records import initial_excitation


def estimated_variance(innovations):
    excitation = initial_excitation()
    for innovation in innovations:
        accumulate_vibration(excitation, innovation, 1e-4, 0.01)
        excitation["peak_innovation"] = innovation
    return float(excitation["vibration_variance"][0])


def test_the_variance_of_a_vibration_is_estimated():
    rng = np.random.default_rng(1)
    estimates = [estimated_variance(0.25 * rng.standard_normal(200)) for _ in range(20)]
    assert np.mean(estimates) == pytest.approx(0.25**2, rel=0.2)


def test_innovations_of_one_sign_are_no_vibration():
    assert estimated_variance(np.full(200, 0.5)) == 0.0
