# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Inflation of variances on white, biased and correlated innovations."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from vsa_common.accel import compiled
from vsa_estimator.general.lack_of_fit import inflation, interpolation_variance
from vsa_estimator.general.records import INTERVALS, LACK, MEMBER, SPRING, SPRING_SIZE
from vsa_estimator.tuning.general import BLOCK_LENGTHS

STEPS, VARIANCE = 6400, 0.04


@compiled
def inflate_all(lack, influences, innovations, variance):
    """Inflation after the last innovation."""
    result = 1.0
    for n in range(innovations.size):
        result = inflation(lack[0], influences[n], innovations[n], variance)
    return result


def inflated(innovations, influences=None):
    influences = np.full(innovations.size, 0.3) if influences is None else influences
    return inflate_all(np.zeros(1, LACK), influences, innovations, VARIANCE)


def white(seed, steps=STEPS):
    return np.sqrt(VARIANCE) * np.random.default_rng(seed).standard_normal(steps)


def autoregressive(seed, phi):
    """AR(1) process of the variance VARIANCE."""
    out, noise = np.zeros(STEPS), np.sqrt(1.0 - phi * phi) * white(seed)
    for n in range(1, STEPS):
        out[n] = phi * out[n - 1] + noise[n]
    return out


def test_white_innovations_leave_the_variance():
    values = np.array([inflated(white(seed)) for seed in range(100)])
    assert values.min() >= 1.0
    assert np.mean(values) < 1.35
    assert np.quantile(values, 0.95) < 2.0


def test_innovations_smaller_than_their_variance_do_not_deflate_it():
    assert inflated(0.1 * white(1)) == 1.0


def test_a_constant_bias_inflates_by_its_share_of_the_longest_block():
    bias = 0.5 * np.sqrt(VARIANCE)
    blocks = STEPS // BLOCK_LENGTHS[-1]
    ratio = 1.0 + 0.25 * BLOCK_LENGTHS[-1]
    values = [inflated(white(seed) + bias) for seed in range(20)]
    assert np.median(values) == pytest.approx(ratio * blocks / (blocks + 4.0), rel=0.25)


@pytest.mark.parametrize("phi", [0.8, 0.95])
def test_correlated_innovations_inflate_by_the_variance_of_their_mean(phi):
    exact = (1.0 + phi) / (1.0 - phi)  # of the mean of an AR(1) process
    values = [inflated(autoregressive(seed, phi)) for seed in range(40)]
    assert 0.6 * exact < np.median(values) < 1.6 * exact


def test_the_unit_of_the_output_does_not_matter():
    innovations, influences = autoregressive(3, 0.9), np.linspace(0.5, 1.5, STEPS)
    assert inflated(innovations, influences) == pytest.approx(inflated(innovations, 1e4 * influences), rel=1e-9)


def test_innovations_without_influence_do_not_count():
    innovations, influences = white(5), np.full(STEPS, 0.3)
    innovations[::2], influences[::2] = 10.0, 0.0
    assert inflated(innovations, influences) < 2.0


PLACES = np.linspace(0.0, INTERVALS, 1600, endpoint=False)  # in knots
SPLINES = BSpline.design_matrix(PLACES, np.arange(-3.0, INTERVALS + 4.0), 3).toarray()


def fitted(stiffness):
    """(1,) MEMBER whose elastic spline fits the force of a law with a `stiffness` at PLACES, and its error there."""
    width = PLACES[1]
    design = np.column_stack([np.cumsum(SPLINES, axis=0) * width, np.ones(PLACES.size)])
    member = np.zeros(1, MEMBER)
    member[0]["mean"][SPRING:] = np.linalg.lstsq(design, np.cumsum(stiffness) * width, rcond=None)[0][:-1]
    return member, stiffness - SPLINES @ member[0]["mean"][SPRING:]


def test_the_interpolation_error_of_a_law_with_a_step_of_its_slope_is_that_of_its_fit():
    squares, variances, random = [], [], np.random.default_rng(1)
    for _ in range(50):
        member, error = fitted(1000.0 + 300.0 * np.abs(PLACES - random.uniform(5.0, 11.0)))
        for interval in range(3, INTERVALS - 3):
            squares.append(np.mean(error[PLACES.astype(int) == interval] ** 2))
            variances.append(interpolation_variance(member, interval))
    squares, variances = np.array(squares), np.array(variances)
    assert squares.mean() == pytest.approx(variances.mean(), rel=0.2)
    assert np.mean(squares < 1.96**2 * variances) > 0.93


def test_a_smooth_law_has_no_interpolation_error():
    member, _ = fitted(1000.0 * np.exp(0.5 * (PLACES - 8.0)))
    relative = np.sqrt([interpolation_variance(member, i) for i in (2, 8, 13)]) / (1000.0 * np.exp([-2.75, 0.25, 2.75]))
    assert relative.max() < 2e-3


def test_the_variance_of_the_coefficients_is_no_roughness():
    member, random, kept = fitted(np.full(PLACES.size, 1000.0))[0], np.random.default_rng(2), []
    member[0]["covariance"][SPRING:, SPRING:] = 100.0**2 * np.eye(SPRING_SIZE)
    plain = np.zeros(1, MEMBER)
    for _ in range(200):
        member[0]["mean"][SPRING:] = plain[0]["mean"][SPRING:] = random.normal(1000.0, 100.0, SPRING_SIZE)
        kept.append([interpolation_variance(member, 8), interpolation_variance(plain, 8)])
    with_variance, without = np.mean(kept, axis=0)
    assert with_variance < 0.6 * without
