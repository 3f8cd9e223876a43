# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Initializer: slices of a regression, and readiness for hand-over."""

from dataclasses import replace

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.force_law.state import C
from vsa_estimator.initialization.scheduler import Initializer
from vsa_estimator.tuning.initialization import HANDOVER_STD, MAX_SLICES, MIN_SAMPLES, SLICE_RATE

NOISE = {"force_noise_std": 0.017, "deflection_noise_std": 1.04e-5, "jerk_density": 1e-3}


def begun(samples: int, cross_check: bool = False) -> Initializer:
    """An initializer with the last `samples` of a multisine, after the begin of a regression."""
    recording = record(TRANSMISSION_1, MULTISINE, 40.0)
    initializer = Initializer(wrong_start(TRANSMISSION_1).initial, 100.0)
    for stamp_ns, deflection, force in list(
        zip(recording.stamp_ns, recording.deflection, recording.force, strict=True)
    )[-samples:]:
        initializer.add(1e-9 * stamp_ns, deflection, force)
    initializer.begin(0.01, float(recording.deflection[-1]), **NOISE, cross_check=cross_check)
    return initializer


def fitted(initializer: Initializer):
    while (fit := initializer.advance(0.01)) is None:
        assert initializer.is_running
    return fit


def test_too_few_samples_begin_no_regression():
    assert not begun(MIN_SAMPLES - 1).is_running
    assert begun(MIN_SAMPLES).is_running


@pytest.mark.parametrize("period", [0.01, 1.0])
def test_slices_are_limited_by_rate_and_by_number(period):
    initializer, executed = begun(2000), 0

    def count():
        nonlocal executed
        while True:
            executed += 1
            yield

    initializer._slices = count()
    assert initializer.advance(period) is None
    assert executed == min(SLICE_RATE * period, MAX_SLICES)


def test_hand_over_requires_two_successive_sufficient_fits():
    initializer = begun(2000)
    fit = fitted(initializer)
    assert not initializer.ready_to_hand_over
    initializer.evaluate(fit, 0.017)
    assert not initializer.ready_to_hand_over
    initializer.evaluate(fit, 0.017)
    assert initializer.ready_to_hand_over
    assert initializer.ready_to_hand_over  # a query without side effect
    initializer.evaluate(fit, 1e-6)  # beside so small a noise the linearisation error dominates
    assert not initializer.ready_to_hand_over
    initializer.evaluate(fit, 0.017)
    assert not initializer.ready_to_hand_over


@pytest.mark.parametrize("coefficient", [C.S, C.D1])
def test_no_fit_is_handed_over_whose_stiffness_or_damping_is_uncertain_by_a_tenth(coefficient):
    initializer = begun(2000)
    fit = fitted(initializer)
    scale = 1.0 if coefficient == C.S else float(fit.mean[coefficient])
    for std, ready in ((0.9 * HANDOVER_STD, True), (1.1 * HANDOVER_STD, False)):
        covariance = fit.covariance.copy()
        covariance[coefficient, coefficient] = (std * scale) ** 2
        for _ in range(2):
            initializer.evaluate(replace(fit, covariance=covariance), 0.017)
        assert initializer.ready_to_hand_over is ready


def test_a_cross_check_requires_one_sufficient_fit():
    initializer = begun(4000, cross_check=True)
    initializer.evaluate(fitted(initializer), 0.017)
    assert initializer.ready_to_hand_over


def test_cleared_data_and_fits_are_not_used_again():
    initializer = begun(4000, cross_check=True)
    initializer.evaluate(fitted(initializer), 0.017)
    initializer.clear()
    assert not initializer.ready_to_hand_over
    initializer.begin(0.01, 0.01, **NOISE, cross_check=False)
    assert not initializer.is_running


def test_the_range_is_that_of_the_data():
    recording = record(TRANSMISSION_1, MULTISINE, 40.0)
    highest, lowest = begun(2000).range
    assert (highest, lowest) == (np.max(recording.deflection[-2000:]), np.min(recording.deflection[-2000:]))
