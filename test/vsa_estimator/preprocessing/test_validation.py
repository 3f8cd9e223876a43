# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Input validation of raw samples."""

import math

import pytest
from vsa_estimator.preprocessing.validation import ACCEPT, DROP, TIME_RESET, initial_validation, validate


@pytest.fixture
def validation():
    return initial_validation(200.0, 0.02)[0]


@pytest.mark.parametrize(
    "sample",
    [
        (0, 30.0, 0.01),
        (-5, 30.0, 0.01),
        (10, math.nan, 0.01),
        (10, 30.0, math.inf),
        (10, 2000.0, 0.01),
        (10, 30.0, 0.2),
    ],
)
def test_samples_without_a_stamp_or_with_an_implausible_magnitude_are_dropped(validation, sample):
    assert validate(validation, *sample) == DROP
    assert validate(validation, 10, 30.0, 0.01) == ACCEPT


def test_late_and_repeated_stamps_are_dropped(validation):
    assert [validate(validation, stamp, 30.0, 0.01) for stamp in (10, 20, 20, 15, 21)] == [
        ACCEPT, ACCEPT, DROP, DROP, ACCEPT,
    ]  # fmt: skip


def test_a_stamp_far_back_is_a_time_reset_and_its_sample_is_accepted_then(validation):
    assert validate(validation, 5_000_000_000, 30.0, 0.01) == ACCEPT
    assert validate(validation, 3_000_000_000, 30.0, 0.01) == TIME_RESET
    assert validate(validation, 3_000_000_000, 30.0, 0.01) == ACCEPT


def test_fifty_late_samples_in_a_row_are_a_time_reset(validation):
    assert validate(validation, 1000, 30.0, 0.01) == ACCEPT
    outcomes = [validate(validation, stamp, 30.0, 0.01) for stamp in range(1, 51)]
    assert outcomes == [DROP] * 49 + [TIME_RESET]
