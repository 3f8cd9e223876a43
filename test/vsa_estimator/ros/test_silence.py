# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Instants of predictions in silence, and their deferral after a starved moment."""

from vsa_estimator.ros.silence import MAX_STEPS, STARVED_NS, Watchdog, prediction_stamps

MS = 1_000_000


def test_predictions_begin_after_fifty_milliseconds_in_steps_of_ten():
    assert prediction_stamps(1000 * MS, 1000 * MS, 49 * MS) == []
    assert prediction_stamps(1000 * MS, 1000 * MS, 71 * MS) == [1050 * MS, 1060 * MS, 1070 * MS]


def test_no_stamp_is_predicted_twice_and_a_long_silence_is_divided():
    stamp, published, all_stamps = 1000 * MS, 1000 * MS, []
    while due := prediction_stamps(stamp, published, 400 * MS):
        assert len(due) <= MAX_STEPS
        all_stamps += due
        published = due[-1]
    assert all_stamps == [stamp + step * 10 * MS for step in range(5, 41)]


def test_after_a_starved_moment_queued_samples_come_first_unless_the_silence_is_long():
    watchdog, now = Watchdog(), 10_000 * MS
    assert not watchdog.may_predict(now, 60 * MS)
    for step in range(1, 20):
        assert watchdog.may_predict(now + step * 5 * MS, 60 * MS) == (step * 5 * MS >= STARVED_NS)
    starved = now + 500 * MS
    assert watchdog.may_predict(starved, 300 * MS)
    assert not watchdog.may_predict(starved + MS, 60 * MS)
