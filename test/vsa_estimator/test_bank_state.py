# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Choice of the law in state message and interval."""

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.tuning.filter import NIS_THRESHOLD


def test_the_state_of_the_filter_contains_what_the_choice_of_the_law_leaves_open():
    recording = record(TRANSMISSION_1, MULTISINE, 15.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    laws, narrow = estimator._supervisor.laws, estimator.state()
    assert not laws.publishes_bank
    before = laws.discrepancies[0]
    assert before < 1e-3
    laws.discrepancies = (before + 1.0, 0.0)
    wide = estimator.state()
    assert wide.ln_stiffness_reference_variance == pytest.approx(narrow.ln_stiffness_reference_variance + 1.0)
    assert narrow.ln_stiffness_reference_valid
    assert not wide.ln_stiffness_reference_valid
    added = np.subtract(wide.elastic_ln_stiffness_covariance, narrow.elastic_ln_stiffness_covariance)
    assert np.allclose(added, 1.0)
    of_coefficients = np.subtract(wide.coefficient_covariance, narrow.coefficient_covariance)
    assert of_coefficients[0] == pytest.approx(1.0)
    assert np.count_nonzero(of_coefficients) == 1


def test_a_bank_that_does_not_explain_the_force_leaves_the_interval_as_it_was():
    recording = record(TRANSMISSION_1, MULTISINE, 25.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    supervisor = estimator._supervisor
    laws = supervisor.laws
    before = laws.discrepancies
    assert not laws.publishes_bank
    assert min(before) > 0.0
    laws._laws._mean_nis = 10.0 * NIS_THRESHOLD
    assert not laws._laws.is_adequate
    laws.choose(supervisor.tracker, supervisor.modes, supervisor.step_ns)
    assert not laws.publishes_bank
    assert laws.discrepancies == pytest.approx(before, rel=1e-9)
