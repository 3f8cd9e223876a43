# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Deadlines of the rig's samples, at given times."""

import pytest
from vsa_simulator.pacing import Pacer

MS = 1_000_000


def test_every_sample_is_taken_at_its_absolute_deadline_for_any_delay_of_the_loop():
    pacer = Pacer(rate_hz=1000)
    pacer.start(5 * MS)
    now, taken = 5 * MS, []
    for delay_ns in [100, 200_000, 50, 999_999, 3] * 200:
        now += round(pacer.wait(now) * 1e9) + delay_ns
        taken.append(pacer.take_due(now))
    assert taken == [1] * 1000
    assert 5 * MS + 999 * MS <= now < 5 * MS + 1000 * MS  # the delays of a thousand wake-ups do not add up
    assert pacer.overruns == 0


def test_a_rate_that_does_not_divide_a_second_does_not_drift_either():
    pacer = Pacer(rate_hz=300)
    pacer.start(0)
    assert (
        sum(pacer.take_due(now) for now in range(0, 3_600 * 1000 * MS, 20 * MS)) == 3_600 * 300 - 5
    )  # 20 ms before the end


def test_late_samples_follow_in_bursts_and_are_counted():
    pacer = Pacer(rate_hz=1000, burst=10)
    pacer.start(0)
    assert pacer.take_due(0) == 1
    assert [pacer.take_due(25 * MS) for _ in range(4)] == [10, 10, 5, 0]  # samples 1 to 25
    assert pacer.overruns == 24  # all but the one that was just due
    assert pacer.wait(25 * MS) == pytest.approx(0.001)


def test_a_restarted_clock_has_no_overdue_samples():
    pacer = Pacer(rate_hz=1000)
    pacer.start(0)
    pacer.take_due(0)
    pacer.stop()
    assert (pacer.take_due(5000 * MS), pacer.running) == (0, False)
    pacer.start(10_000 * MS)
    assert pacer.take_due(10_000 * MS) == 1
    assert pacer.overruns == 0
