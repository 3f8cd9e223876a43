# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The operating mode: transitions, duration of a hold, held positions; instants are given."""

import pytest
from vsa_joint.control.mode import TRANSITIONS, Event, Mode, OperatingMode

MS = 1_000_000
POSITIONS = (1.0, 2.0)


def active():
    mode = OperatingMode()
    assert mode.resume(0)
    return mode


def test_the_table_has_one_transition_for_each_mode_and_event():
    assert set(TRANSITIONS) == {(mode, event) for mode in Mode for event in Event}
    assert Mode.IDLE not in TRANSITIONS.values()


def test_idle_becomes_active_without_delay():
    mode = OperatingMode()
    assert mode.mode is Mode.IDLE
    assert mode.needs_engagement(0)
    assert mode.resume(0)
    assert mode.mode is Mode.ACTIVE


def test_a_hold_keeps_its_first_positions():
    mode = active()
    mode.hold(POSITIONS, 10 * MS)
    mode.hold((3.0, 4.0), 20 * MS)
    assert (mode.mode, mode.held) == (Mode.HOLDING, POSITIONS)


def test_a_hold_without_positions_takes_the_first_measured_ones():
    mode = OperatingMode()
    mode.hold(None, 10 * MS)
    mode.hold(POSITIONS, 20 * MS)
    assert mode.held == POSITIONS


@pytest.mark.parametrize(("held", "healthy"), [(50, 50), (100, 100), (110, 500), (2000, 500)])
def test_control_resumes_after_the_duration_of_a_short_hold_or_the_recovery_time(held, healthy):
    mode = active()
    mode.hold(POSITIONS, 0)
    end = held * MS
    assert not mode.resume(end)
    assert not mode.resume(end + healthy * MS - 1)
    assert mode.mode is Mode.HOLDING
    assert mode.resume(end + healthy * MS)
    assert mode.mode is Mode.ACTIVE


def test_a_fault_during_recovery_restarts_the_duration():
    mode = active()
    mode.hold(POSITIONS, 0)
    mode.resume(1000 * MS)
    mode.hold(POSITIONS, 1200 * MS)
    assert not mode.resume(1300 * MS)
    assert not mode.resume(1700 * MS)
    assert mode.resume(1800 * MS)


@pytest.mark.parametrize(("instant", "needed"), [(500, False), (501, True)])
def test_the_control_state_is_outdated_after_the_recovery_time(instant, needed):
    mode = active()
    mode.hold(POSITIONS, 0)
    assert mode.needs_engagement(instant * MS) is needed
