# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vsa_driver.motors.motor import CommandRefused, MotorGate, MotorLimits

LIMITS = MotorLimits(position_min=-2.0, position_max=3.0, speed_max=5.0, timeout=0.2)


def armed_gate(at=(0.5, -0.25), now=100.0):
    gate = MotorGate(LIMITS)
    gate.update_position(at, now)
    gate.arm(now)
    return gate


def test_nothing_is_sent_before_arming():
    gate = MotorGate(LIMITS)
    gate.update_position((0.0, 0.0), 0.0)
    with pytest.raises(CommandRefused, match="not armed"):
        gate.command((0.1, 0.1), 0.0)
    assert gate.step(0.0) is None
    assert (gate.state, gate.refused) == ("disarmed", 1)


def test_the_first_command_after_arming_is_the_measured_position():
    gate = armed_gate()
    assert gate.step(100.0) == (0.5, -0.25)
    assert gate.step(100.01) == (0.5, -0.25)


def test_arming_without_a_fresh_position_is_refused():
    gate = MotorGate(LIMITS)
    with pytest.raises(CommandRefused, match="not being received"):
        gate.arm(0.0)
    gate.update_position((0.0, 0.0), 10.0)
    with pytest.raises(CommandRefused):
        gate.arm(11.0)


@pytest.mark.parametrize("wrong", [3.01, -2.01, math.nan])
def test_arming_at_a_position_beyond_the_limits_is_refused_with_the_motor_and_the_limits(wrong):
    gate = MotorGate(LIMITS)
    gate.update_position((0.0, wrong), 10.0)
    with pytest.raises(CommandRefused, match=f"motor_2 = {wrong:g} rad: must be within -2 to 3 rad"):
        gate.arm(10.0)
    assert gate.state == "disarmed"


def test_arming_while_armed_changes_nothing():
    gate = armed_gate(at=(0.0, 0.0))
    gate.command((0.04, 0.0), 100.0)
    assert gate.step(100.01) == (0.04, 0.0)
    gate.arm(100.02)
    assert gate.step(100.02) == (0.04, 0.0)
    gate.step(100.3)
    gate.arm(100.4)
    assert (gate.state, gate.step(100.4)) == ("holding", None)


def test_a_distant_command_is_approached_at_the_speed_limit_and_reached():
    gate = armed_gate(at=(0.0, 0.0))
    now, sent = 100.0, []
    for _ in range(100):
        now += 0.01
        gate.command((1.0, -0.02), now)
        sent.append(gate.step(now))
    speeds = [(after[0] - before[0]) / 0.01 for before, after in pairwise(sent)]
    assert max(speeds) <= 5.0 + 1e-6
    assert sent[0][0] == pytest.approx(0.05)
    assert sent[-1] == (1.0, -0.02)
    assert gate.rate_limited == pytest.approx(20, abs=1)


@pytest.mark.parametrize(
    "wrong", [(3.01, 0.0), (0.0, -2.01), (math.nan, 0.0), (0.0, math.inf), (0.0,), (0.0, 0.0, 0.0)]
)
def test_a_command_that_is_not_finite_out_of_limits_or_of_another_length_is_refused_and_the_last_one_held(wrong):
    gate = armed_gate(at=(0.0, 0.0))
    gate.command((0.01, 0.01), 100.0)
    assert gate.step(100.01) == (0.01, 0.01)
    with pytest.raises(CommandRefused):
        gate.command(wrong, 100.02)
    assert gate.step(100.03) == (0.01, 0.01)
    assert gate.refused == 1


def test_commands_end_when_the_controller_times_out_and_a_new_one_continues_from_there():
    gate = armed_gate(at=(0.0, 0.0))
    gate.command((3.0, 0.0), 100.0)
    gate.step(100.1)
    last = gate.step(100.19)
    assert gate.step(100.21) is None
    assert (gate.state, gate.timeouts) == ("holding", 1)
    assert gate.step(105.0) is None
    gate.command((3.0, 0.0), 110.0)
    assert gate.state == "armed"
    assert gate.step(110.0) == last
    assert gate.step(110.01)[0] - last[0] == pytest.approx(LIMITS.speed_max * 0.01)


def test_a_refused_command_does_not_reset_the_watchdog():
    gate = armed_gate()
    for i in range(30):
        with pytest.raises(CommandRefused):
            gate.command((math.nan, 0.0), 100.0 + 0.01 * i)
    assert gate.step(100.3) is None


def test_disarming_takes_effect_at_once_and_the_next_command_is_refused_with_its_reason():
    gate = armed_gate()
    gate.disarm("the bus failed")
    assert gate.step(100.01) is None
    with pytest.raises(CommandRefused, match="the bus failed"):
        gate.command((0.0, 0.0), 100.01)
    gate.update_position((1.0, 1.0), 101.0)
    gate.arm(101.0)
    assert gate.step(101.0) == (1.0, 1.0)


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from("mcasd"), st.floats(), st.floats(), st.floats(0.0, 1.0)), max_size=60))
def test_no_sequence_of_events_gives_an_output_beyond_the_speed_or_position_limits(events):
    gate, now, last, last_s = MotorGate(LIMITS), 0.0, None, 0.0
    for kind, one, two, wait in events:
        now += wait
        try:
            if kind == "m" and math.isfinite(one) and math.isfinite(two):
                gate.update_position((math.fmod(one, 2.0), math.fmod(two, 2.0)), now)
            elif kind == "c":
                gate.command((one, two), now)
            elif kind == "a":
                last = last if gate.armed else None
                gate.arm(now)
            elif kind == "d":
                gate.disarm("test")
        except CommandRefused:
            pass
        sent = gate.step(now)
        if gate.state == "holding":
            last_s = math.inf  # the first output after a hold is the last one before
        if sent is not None:
            assert all(LIMITS.position_min <= position <= LIMITS.position_max for position in sent)
            if last is not None:
                allowed = LIMITS.speed_max * min(max(now - last_s, 0.0), LIMITS.timeout) + 1e-9
                assert all(abs(a - b) <= allowed for a, b in zip(sent, last, strict=True))
            last, last_s = sent, now
