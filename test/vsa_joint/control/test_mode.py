# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The operating mode: transitions, duration of a hold, held positions; instants are given."""

import pytest
from vsa_joint.control.mode import TRANSITIONS, Event, Mode, OperatingMode

MS = 1_000_000
POSITIONS = (1.0, 2.0)


def active():
    mode = OperatingMode()
    assert mode.handle(Event.VALID, POSITIONS, 0)
    return mode


def hold(mode, now_ns, positions=POSITIONS):
    mode.handle(Event.FAULT, positions, now_ns)
    assert mode.mode is Mode.HOLDING


def becomes_active(mode, now_ns):
    return mode.handle(Event.VALID, POSITIONS, now_ns) and mode.mode is Mode.ACTIVE


def test_the_table_has_one_transition_for_each_mode_and_event():
    assert set(TRANSITIONS) == {(mode, event) for mode in Mode for event in Event}
    assert Mode.IDLE not in TRANSITIONS.values()


@pytest.mark.parametrize("mode", [mode for mode in Mode if mode is not Mode.IDLE])
def test_every_mode_ends_with_a_valid_stiffness_and_with_a_fault(mode):
    assert TRANSITIONS[mode, Event.VALID] is Mode.ACTIVE
    assert TRANSITIONS[mode, Event.FAULT] is Mode.HOLDING


def test_idle_becomes_active_without_delay():
    mode = OperatingMode()
    assert mode.mode is Mode.IDLE
    assert mode.duration(5 * MS) == 0.0
    assert mode.needs_engagement(0)
    assert becomes_active(mode, 0)
    assert mode.duration(5 * MS) == pytest.approx(0.005)


def test_an_invalid_stiffness_is_tolerated_then_re_excited_until_it_is_valid():
    mode = active()
    mode.handle(Event.TOLERABLE, POSITIONS, 10 * MS)
    assert (mode.mode, mode.duration(30 * MS)) == (Mode.FEED_FORWARD, pytest.approx(0.02))
    assert mode.handle(Event.INVALID, POSITIONS, 40 * MS)
    assert not mode.handle(Event.TOLERABLE, POSITIONS, 50 * MS)
    assert (mode.mode, mode.duration(60 * MS)) == (Mode.EXCITING, pytest.approx(0.02))
    assert not mode.needs_engagement(10_000 * MS)
    assert becomes_active(mode, 60 * MS)


def test_a_hold_keeps_its_first_positions():
    mode = active()
    hold(mode, 10 * MS)
    hold(mode, 20 * MS, (3.0, 4.0))
    assert mode.held == POSITIONS


def test_a_hold_without_positions_takes_the_first_measured_ones():
    mode = OperatingMode()
    hold(mode, 10 * MS, None)
    hold(mode, 20 * MS)
    assert mode.held == POSITIONS


@pytest.mark.parametrize(("held", "healthy"), [(50, 50), (110, 110), (500, 500), (2000, 500)])
def test_control_resumes_after_the_duration_of_the_fault_or_the_recovery_time(held, healthy):
    mode = active()
    hold(mode, 0)
    end = held * MS
    assert not becomes_active(mode, end)
    assert not becomes_active(mode, end + healthy * MS - 1)
    assert mode.mode is Mode.HOLDING
    assert becomes_active(mode, end + healthy * MS)


def test_a_fault_during_recovery_adds_its_duration():
    mode = active()
    hold(mode, 0)
    assert not becomes_active(mode, 1000 * MS)
    hold(mode, 1200 * MS)
    assert not becomes_active(mode, 1300 * MS)
    assert not becomes_active(mode, 1700 * MS - 1)
    assert becomes_active(mode, 1700 * MS)


def test_a_hold_lasts_as_long_as_the_inputs_are_faulty_for_half_of_the_time():
    mode = active()
    for k in range(50):
        hold(mode, 40 * k * MS)
        assert not becomes_active(mode, (40 * k + 20) * MS)
    assert becomes_active(mode, (40 * k + 40) * MS)


@pytest.mark.parametrize(("instant", "needed"), [(500, False), (501, True)])
def test_the_control_state_is_outdated_after_the_recovery_time(instant, needed):
    mode = active()
    hold(mode, 0)
    assert mode.needs_engagement(instant * MS) is needed
