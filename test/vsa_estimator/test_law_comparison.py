# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Comparison of filter and bank: threshold and discrepancy on made differences."""

import numpy as np
import pytest
from vsa_estimator.filter.records import PREDICTION
from vsa_estimator.general.records import IMPEDANCE
from vsa_estimator.law_comparison import LawComparison, move_to
from vsa_estimator.tuning.general import (
    COMPARISON_TIME,
    DAMPER_SHAPE_STD,
    DAMPING_BIAS,
    DAMPING_DISCREPANCY_STD,
    DIFFERENCE_THRESHOLD,
    LAW_DISCREPANCY_STD,
    SHAPE_STD,
    STIFFNESS_BIAS,
)

DT = 0.01
VARIANCE = 1e-6  # of ln stiffness, of each of the two
DAMPING_STD = 20.0  # [N s/m], of each of the two


def filtered(damping=4000.0, ln_stiffness_variance=VARIANCE, velocity=1e-3):
    one = np.zeros(1, PREDICTION)
    one["stiffness"], one["ln_stiffness_variance"] = 5000.0, ln_stiffness_variance
    one["damping"], one["damping_variance"] = damping, DAMPING_STD**2
    one["velocity"], one["peak_speed"] = velocity, 3.5e-3
    return one


def bank(ln_difference=0.0, beyond_peak=0.0):
    one = np.zeros(1, IMPEDANCE)
    one["ln_stiffness"], one["ln_stiffness_variance"] = np.log(5000.0) - ln_difference, VARIANCE
    one["damping"], one["damping_variance"], one["rest_damping"] = 4000.0, DAMPING_STD**2, 4000.0
    one["beyond_peak"] = beyond_peak
    return one


def compared(one, other, weight=1.0, seconds=10.0 * COMPARISON_TIME):
    comparison = LawComparison()
    for _ in range(round(seconds / DT)):
        comparison.add(DT, one, other, weight)
    return comparison


def posterior(prior, std, bias, weight):
    """Variance of an error of this prior standard deviation and probability after a comparison with the bank."""
    return 1.0 / (1.0 / (std**2 - bias**2) + 1.0 / (weight * prior**2))


@pytest.mark.parametrize(("share", "expected"), [(0.9, False), (1.1, True)])
def test_a_difference_exceeds_the_threshold_in_standard_deviations(share, expected):
    ratio = share * DIFFERENCE_THRESHOLD
    stiffness = compared(filtered(), bank(ln_difference=ratio * np.sqrt(2.0 * VARIANCE)))
    damping = compared(filtered(damping=4000.0 + ratio * np.sqrt(2.0) * DAMPING_STD), bank())
    assert stiffness.exceeds_threshold is expected
    assert damping.exceeds_threshold is expected


def test_a_short_difference_is_below_the_threshold():
    assert not compared(filtered(), bank(ln_difference=1.0), seconds=0.05 * COMPARISON_TIME).exceeds_threshold


def test_the_discrepancy_is_the_mean_square_by_the_probability_of_another_law():
    difference = 1.5 * np.sqrt(2.0 * VARIANCE)
    for weight in (0.0, 0.3, 1.0):
        found = compared(filtered(), bank(ln_difference=difference), weight).discrepancies(bank(), 0.0, False)
        assert found == pytest.approx((weight * difference**2, 0.0), rel=1e-3, abs=1e-12)


def test_an_uncertain_bank_adds_little_to_the_discrepancy():
    comparison, uncertain = LawComparison(), bank(ln_difference=0.09)
    uncertain["ln_stiffness_variance"] = 0.09**2
    for step in range(5000):
        comparison.add(DT, filtered(), uncertain if step % 2 else bank(ln_difference=1e-3), 1.0)
    assert comparison.discrepancies(bank(), 0.0, False)[0] == pytest.approx(0.75 / (0.5 / (2.0 * VARIANCE)), rel=0.05)


def test_a_bank_without_a_valid_stiffness_is_not_compared():
    useless = bank(ln_difference=0.15)
    useless["ln_stiffness_variance"] = 1.0
    found = compared(filtered(), useless).discrepancies(useless, 1.0, False)
    assert found[0] == pytest.approx(posterior(LAW_DISCREPANCY_STD, 1.0, STIFFNESS_BIAS, 1.0))


@pytest.mark.parametrize(("velocity", "beyond_peak"), [(3.4e-3, 0.0), (1e-3, 0.5)])
def test_the_damping_near_its_peak_is_not_compared(velocity, beyond_peak):
    assert not compared(filtered(9000.0, velocity=velocity), bank(beyond_peak=beyond_peak)).exceeds_threshold


def test_a_stiffness_that_is_not_valid_is_stated():
    assert compared(filtered(), bank()).filter_valid
    assert not compared(filtered(ln_stiffness_variance=0.04), bank()).filter_valid


def test_the_motion_of_the_bank_is_no_difference():
    one, other, dx, dv = filtered(damping=3900.0), bank(), 1e-3, 0.5e-3
    one["deflection"], one["stiffness"], one["velocity"] = dx, 5000.0 * np.exp(267.0 * dx), dv
    other["slope"], other["damping_slope"] = 267.0, -100.0 / dv
    found = compared(one, other)
    assert not found.exceeds_threshold
    assert found.discrepancies(bank(), 0.0, False) == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("weight", [0.0, 0.4, 1.0])
def test_the_excess_is_what_the_difference_has_beyond_the_threshold(weight):
    difference, comparison = 0.04, compared(filtered(), bank(), weight)
    comparison.add(DT, filtered(), bank(ln_difference=difference), 0.0)
    assert comparison.discrepancies(bank(), 0.0, False) == pytest.approx(
        (difference**2 - DIFFERENCE_THRESHOLD**2 * 2.0 * VARIANCE, 0.0), rel=1e-6
    )
    comparison.add(DT, filtered(), bank(), 0.0)
    assert comparison.discrepancies(bank(), 0.0, False)[0] < 1e-3 * difference**2


def test_the_excess_is_no_more_than_an_error_by_a_wrong_law():
    comparison = LawComparison()
    comparison.add(0.0, filtered(), bank(ln_difference=0.2), 1.0)
    assert comparison.discrepancies(bank(), 0.0, False) == pytest.approx((LAW_DISCREPANCY_STD**2, 0.0))


def test_a_difference_within_the_threshold_has_no_excess():
    found = compared(filtered(), bank(ln_difference=0.99 * DIFFERENCE_THRESHOLD * np.sqrt(2.0 * VARIANCE)), 0.0)
    assert found.discrepancies(bank(), 0.0, False) == (0.0, 0.0)


@pytest.mark.parametrize(("difference", "expected"), [(0.0, False), (0.1, True)])
def test_after_a_new_estimate_the_next_difference_decides_and_the_widening_stays(difference, expected):
    comparison = compared(filtered(), bank(ln_difference=0.1))
    before = comparison.discrepancies(bank(), 0.0, False)
    comparison.restart_test()
    assert comparison.discrepancies(bank(), 0.0, False) == before
    comparison.add(DT, filtered(), bank(ln_difference=difference), 1.0)
    assert comparison.exceeds_threshold is expected


def test_a_new_estimate_leaves_a_consistent_pair_consistent():
    comparison = compared(filtered(), bank())
    comparison.restart_test()
    comparison.add(DT, filtered(), bank(ln_difference=np.sqrt(2.0 * VARIANCE)), 1.0)
    assert not comparison.exceeds_threshold


@pytest.mark.parametrize("weight", [0.05, 1.0])
@pytest.mark.parametrize("std", [3e-3, 2e-2, 2.0])
def test_an_error_that_the_bank_cannot_show_has_its_posterior_variance(std, weight):
    uncertain, rest = bank(), 4000.0
    std_of_damping = 10.0 * std
    uncertain["ln_stiffness_variance"], uncertain["damping_variance"] = std**2, (std_of_damping * rest) ** 2
    stiffness, damping = LawComparison().discrepancies(uncertain, weight, False)
    assert stiffness == pytest.approx(posterior(LAW_DISCREPANCY_STD, std, STIFFNESS_BIAS, weight))
    assert damping == pytest.approx(rest**2 * posterior(DAMPING_DISCREPANCY_STD, std_of_damping, DAMPING_BIAS, weight))


def test_a_law_that_the_evidence_refutes_may_differ_as_much_as_the_shapes_of_laws():
    uncertain, std = bank(), 0.2
    uncertain["ln_stiffness_variance"], uncertain["damping_variance"] = std**2, (std * 4000.0) ** 2
    stiffness, damping = LawComparison().discrepancies(uncertain, 0.9, True)
    assert stiffness == pytest.approx(posterior(SHAPE_STD, std, STIFFNESS_BIAS, 0.9))
    assert damping == pytest.approx(4000.0**2 * posterior(DAMPER_SHAPE_STD, std, DAMPING_BIAS, 0.9))


def test_the_damping_may_differ_by_a_share_of_its_greater_value_at_rest_or_in_motion():
    uncertain = bank()
    uncertain["damping_variance"], uncertain["rest_damping"] = 1e12, 1000.0
    damping = LawComparison().discrepancies(uncertain, 1.0, False)[1]
    assert damping == pytest.approx((DAMPING_DISCREPANCY_STD * 4000.0) ** 2, rel=1e-3)


def test_the_systematic_error_of_the_bank_is_no_choice_of_the_law():
    exact = bank()
    exact["ln_stiffness_variance"], exact["damping_variance"] = STIFFNESS_BIAS**2, (DAMPING_BIAS * 4000.0) ** 2
    assert LawComparison().discrepancies(exact, 1.0, False) == (0.0, 0.0)


@pytest.mark.parametrize("ratio", [0.5, 4.0])
def test_the_impedance_of_the_bank_at_the_motion_of_the_filter(ratio):
    """It follows its slopes; the variances grow by the slopes' own and by a motion that is less certain (`ratio`)."""
    one, other = filtered(), bank()
    one["deflection"], one["acceleration"] = 0.012, 0.03
    other["slope"], other["slope_variance"], other["damping_slope"] = 250.0, 4.0, -2e5
    other["motion"], other["motion_covariance"] = (0.011, 0.5e-3, 0.0), np.diag([1e-10, 1e-8, 1e-4])
    covariance, moved = ratio * other["motion_covariance"][0], other.copy()
    move_to(one, covariance, moved)
    after, before, growth = moved[0], other[0], max(ratio - 1.0, 0.0)
    assert after["ln_stiffness"] == pytest.approx(before["ln_stiffness"] + 250.0 * 1e-3)
    assert after["ln_stiffness_variance"] == pytest.approx(VARIANCE + 4.0 * 1e-6 + growth * 250.0**2 * 1e-10)
    assert after["damping"] == pytest.approx(4000.0 - 2e5 * 0.5e-3)
    assert after["damping_variance"] == pytest.approx(DAMPING_STD**2 + growth * 2e5**2 * 1e-8)
    assert after["motion"].tolist() == [0.012, 1e-3, 0.03]
    assert np.array_equal(after["motion_covariance"], covariance)
