# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The table of operating modes."""

import pytest
from vsa_estimator.estimator import Estimator
from vsa_estimator.modes import TRANSITIONS, Event, Mode, ModeMachine
from vsa_estimator.settings import EstimatorConfig
from vsa_msgs.msg import EstimatorState


def machine_after(*events):
    machine = ModeMachine()
    for event in events:
        machine.handle(event, "reason")
    return machine


def test_every_mode_is_reached_from_the_first_sample_on_and_left_again():
    assert set(TRANSITIONS.values()) == set(Mode) - {Mode.WAITING}
    assert {mode for mode, _ in TRANSITIONS} == set(Mode)


def test_the_numbers_are_those_of_the_message():
    assert {name: getattr(EstimatorState, f"MODE_{name}") for name in Mode.__members__} == dict(Mode.__members__)


def test_the_state_has_the_mode():
    estimator = Estimator(EstimatorConfig())
    assert estimator.state().mode is Mode.WAITING
    for i in range(3):
        estimator.add(10_000_000 * (i + 1), 20.0, 0.01)
    assert estimator.state().mode is Mode.INITIALIZING


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
