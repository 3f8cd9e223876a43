# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Diagnostics of the estimator: a converged one is OK, silence is an error, increases of counters are warnings."""

import pytest
from transmission_data import SLOW, TRANSMISSION_1, record, run, wrong_start
from vsa_common.ros.diagnostics import ERROR, OK, WARN
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.ros.health import NO_SAMPLES, EstimatorHealth

STAMPS = {"transmission_1/force": 0, "transmission_1/encoder": 0}
COUNTS = {"unpaired": 0, "estimates_overtaken": 0}


@pytest.fixture(scope="module")
def state():
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    run(estimator, record(TRANSMISSION_1, SLOW, 16.0))
    return estimator.state()


def test_a_converged_estimator_is_ok_and_one_that_converges_warns(state):
    health = EstimatorHealth()
    assert health.assess(state, state.status, STAMPS, COUNTS)[:2] == (OK, "active")
    beginning = Estimator(wrong_start(TRANSMISSION_1)).state()
    level, text, values = health.assess(beginning, beginning.status, STAMPS, COUNTS)
    assert (level, text, values["status"]) == (WARN, "no sample yet", "INITIALIZING")


def test_silence_is_an_error(state):
    assert EstimatorHealth().assess(state, Status.STALE, STAMPS, COUNTS)[:2] == (ERROR, NO_SAMPLES)


def test_increases_are_warnings_with_their_names(state):
    health = EstimatorHealth()
    health.assess(state, state.status, STAMPS, COUNTS)
    level, text, _ = health.assess(state, state.status, STAMPS, COUNTS | {"unpaired": 3})
    assert (level, text) == (WARN, "in the last second: unpaired +3")
    level, text, _ = health.assess(state, state.status, STAMPS | {"transmission_1/force": 1}, COUNTS)
    assert (level, text) == (WARN, "stamps of transmission_1/force are zero or in the future")
