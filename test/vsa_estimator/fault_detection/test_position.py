# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Deflections that the filter rejects at rest: an encoder step or a motion, by the change of the force."""

import pytest
from vsa_estimator.fault_detection.position import PositionMonitor, PositionUpdate
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import Z
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.settings import EstimatorConfig

DT_NS, VARIANCE, JERK = 10_000_000, 1e-10, 1e-6
AT, STEP = 0.01, 3e-4  # [m]


def after_a_step(stiction, change_of_force, samples=1):
    """Monitor and filter eight steps after the encoder's deflection has changed by STEP, in a rest with stiction [N].

    `change_of_force`: relative to that of a motion of STEP. `samples`: over which the deflection changes.
    """
    tracker, monitor, jerk = Tracker(EstimatorConfig().initial, 100.0), PositionMonitor(), JerkDensity()
    tracker.start(AT, 30.0, VARIANCE)
    moved = tracker.z.copy()
    moved[Z.X] += STEP
    at_rest = tracker.predicted_force(tracker.z)
    elastic = tracker.predicted_force(moved) - at_rest
    force, results = at_rest + stiction, []
    for i in range(308):
        stepped = i >= 300
        rise = STEP / samples if i == 300 else 0.0
        tracker.predict(1e-9 * DT_NS, JERK)
        deflection = AT + (STEP if stepped else 0.0)
        measured = force + (change_of_force * elastic if stepped else 0.0)
        block = Decimated(i * DT_NS, deflection, measured, 5, 5, rise, 0.0)
        results.append(monitor.update(tracker, jerk, block, VARIANCE, True))
    return monitor, tracker, results


@pytest.mark.parametrize("stiction", [-1.0, 0.0, 0.5, 1.0])
def test_an_encoder_step_at_rest_is_isolated_under_any_stiction(stiction):
    monitor, tracker, results = after_a_step(stiction, 0.0)
    assert results[:300] == [PositionUpdate.ACCEPTED] * 300
    assert PositionUpdate.ACCEPTED not in results[300:]
    assert monitor.encoder_step(tracker)
    assert monitor.step_size == pytest.approx(STEP, rel=0.05)


@pytest.mark.parametrize("stiction", [-1.0, 0.0, 0.5, 1.0])
def test_a_motion_changes_the_force_and_is_no_encoder_step(stiction):
    monitor, tracker, _ = after_a_step(stiction, 1.0)
    assert not monitor.encoder_step(tracker)


def test_a_motion_is_spread_over_samples_and_a_step_is_within_one():
    monitor, tracker, results = after_a_step(0.0, 0.0, samples=5)  # beyond v*: the force hardly changes
    assert not monitor.encoder_step(tracker)
    assert results[300:302] == [PositionUpdate.REJECTED, PositionUpdate.ACCEPTED]  # followed from the second one on
