# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State message with the choice of the law."""

import numpy as np
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator


def test_the_state_of_the_filter_contains_what_the_choice_of_the_law_leaves_open():
    recording = record(TRANSMISSION_1, MULTISINE, 15.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    laws, narrow = estimator._supervisor.laws, estimator.state()
    assert not laws.publishes_bank
    assert laws.discrepancies[0] == 0.0
    laws.discrepancies = (1.0, 0.0)
    wide = estimator.state()
    assert wide.ln_stiffness_reference_variance == narrow.ln_stiffness_reference_variance + 1.0
    assert narrow.ln_stiffness_reference_valid
    assert not wide.ln_stiffness_reference_valid
    added = np.subtract(wide.elastic_ln_stiffness_covariance, narrow.elastic_ln_stiffness_covariance)
    assert np.allclose(added, 1.0)
