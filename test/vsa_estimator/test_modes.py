# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The table of operating modes."""

import pytest
from vsa_estimator.modes import TRANSITIONS, Event, Mode, ModeMachine


def machine_after(*events):
    machine = ModeMachine()
    for event in events:
        machine.handle(event, "reason")
    return machine


def test_every_mode_is_reached_from_the_first_sample_on_and_left_again():
    assert set(TRANSITIONS.values()) == set(Mode) - {Mode.WAITING}
    assert {mode for mode, _ in TRANSITIONS} == set(Mode)


def test_every_event_has_a_transition():
    assert {event for _, event in TRANSITIONS} == set(Event)


def test_the_coefficients_are_initialized_from_hand_over_until_they_are_rejected():
    assert not machine_after(Event.FIRST_SAMPLE).initialized
    assert machine_after(Event.FIRST_SAMPLE, Event.HAND_OVER).initialized
    assert machine_after(Event.FIRST_SAMPLE, Event.HAND_OVER, Event.INCONSISTENT).mode is Mode.SUSPENDED
    assert machine_after(Event.FIRST_SAMPLE, Event.HAND_OVER, Event.INCONSISTENT).initialized
    rejected = machine_after(Event.FIRST_SAMPLE, Event.HAND_OVER, Event.INCONSISTENT, Event.REJECTED)
    assert rejected.mode is Mode.INITIALIZING


def test_a_suspended_bank_estimates_again_where_the_sensors_are_consistent():
    events = Event.FIRST_SAMPLE, Event.REFUTED, Event.INCONSISTENT
    suspended = machine_after(*events)
    assert suspended.mode is Mode.GENERAL_SUSPENDED
    assert suspended.general and suspended.suspended and suspended.initialized
    assert machine_after(*events, Event.CONSISTENT).mode is Mode.GENERAL
    assert machine_after(*events, Event.REJECTED).mode is Mode.INITIALIZING


def test_a_reason_stands_only_while_updates_are_suspended():
    machine = machine_after(Event.FIRST_SAMPLE, Event.HAND_OVER)
    assert machine.reason == ""
    machine.handle(Event.INCONSISTENT, "sensor drift")
    assert machine.reason == "sensor drift"
    machine.handle(Event.INCONSISTENT, "encoder step")
    assert machine.reason == "encoder step"
    machine.handle(Event.CONSISTENT)
    assert (machine.mode, machine.reason) == (Mode.TRACKING, "")


@pytest.mark.parametrize("event", [Event.HAND_OVER, Event.INCONSISTENT, Event.REJECTED])
def test_an_event_that_the_mode_cannot_have_is_an_error(event):
    with pytest.raises(KeyError):
        ModeMachine().handle(event)
