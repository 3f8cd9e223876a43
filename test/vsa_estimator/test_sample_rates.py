# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sample rates of which no whole number of samples makes a filter step."""

import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, record, run, wrong_start
from vsa_estimator.estimator import Estimator


@pytest.mark.parametrize("rate", [60, 130, 250, 330])
def test_stiffness_converges_at_a_rate_that_does_not_divide_evenly(rate):
    recording = record(TRANSMISSION_1, MULTISINE, 15.0, rate=rate)
    last = run(Estimator(wrong_start(TRANSMISSION_1)), recording)[-1]
    assert last.stiffness_valid
    assert last.stiffness == pytest.approx(recording.stiffness[-1], rel=0.03)
