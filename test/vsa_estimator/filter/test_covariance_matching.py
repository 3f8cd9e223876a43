"""White jerk is rougher than most motions: by how much, the force tells, and the intervals follow."""

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.filter.excitation import (
    CLEAR_SPEED,
    SHARES,
    SMOOTH_MEMORY,
    accumulate_matching,
    consistency_ratio,
    initial_excitation,
    reset_matching,
)
from vsa_estimator.filter.steps import FOUND


def after(seconds, claimed, shown, speed=1e-3):
    motion = initial_excitation()
    for _ in range(round(100 * seconds)):
        accumulate_matching(motion, speed, claimed, shown, 0.01)
    return motion


def test_what_is_shown_of_the_claimed_variance_is_believed_little_by_little():
    assert consistency_ratio(initial_excitation()) == 1.0
    assert consistency_ratio(after(0.1, 4.0, 1.0)) > 0.95
    assert consistency_ratio(after(5.0 * SMOOTH_MEMORY, 4.0, 1.0)) == pytest.approx(0.25, abs=0.01)
    assert consistency_ratio(after(5.0 * SMOOTH_MEMORY, 4.0, 9.0)) == 1.0
    assert consistency_ratio(after(5.0 * SMOOTH_MEMORY, 4.0, -1.0)) < 0.01
    assert consistency_ratio(after(5.0 * SMOOTH_MEMORY, 4.0, 1.0, speed=0.9 * CLEAR_SPEED)) == 1.0


def test_a_motion_that_becomes_another_is_called_smooth_no_longer():
    motion = after(5.0 * SMOOTH_MEMORY, 4.0, 1.0)
    reset_matching(motion)
    assert consistency_ratio(motion) == 1.0


def test_intervals_narrow_in_smooth_motion_and_widen_when_the_rod_is_pushed():
    recording = record(TRANSMISSION_1, MULTISINE, 41.0, rate=100)
    late = recording.stamp_ns >= recording.stamp_ns[0] + 40_000_000_000
    stroke = np.where(late, 1e-3 * (1.0 - np.cos(25.0 * (np.cumsum(late) - 1.0) / 100.0)), 0.0)  # nobody foresaw it
    estimator, shares = Estimator(wrong_start(TRANSMISSION_1)), []
    deflection = (recording.deflection + stroke).tolist()
    for sample in zip(recording.stamp_ns.tolist(), recording.force.tolist(), deflection, strict=True):
        estimator.add(*sample)
        shares.append(estimator._supervisor.tracker.known[FOUND + SHARES :].copy())
    calm, pushed = np.array(shares)[~late], np.array(shares)[late]
    assert (np.array(shares[0]) == 1.0).all()
    assert (calm[-1] < [0.8, 0.6]).all()
    assert (pushed[20:].max(axis=0) > 0.99).all()
