# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults that hold the motors, delay and reason of the hold, recovery; instants are given."""

import math
from dataclasses import replace

import pytest
from vsa_common.types import Status
from vsa_joint.control.mode import Mode
from vsa_joint.control.records import Inputs, JointMeasurement, Target
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.control.supervisor import Supervisor
from vsa_joint.settings import ControlConfig

MS = 1_000_000
SPRINGS = (
    ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    ExponentialSpring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)
GOOD = JointMeasurement(1.5, True, 0.9, True, (25.0, 25.0), True, Status.VALID, "")
MOTORS = (2.6, 2.2)
TARGET = Target(0.0, 1.5)


class Feed:
    """All inputs at 100 Hz, except for the faults of a test."""

    def __init__(self, **config):
        self.supervisor = Supervisor(ControlConfig(**config))
        self.inputs = Inputs()
        self.now = 0

    def run(self, ms, joint=GOOD, commands=True, motors=MOTORS, silent=(), frozen=(), late=None, target=TARGET):
        """Run for `ms`; `silent` names inputs that stop, `late` has ages by stamp [ms].

        Returns (instant, mode, reason, motors) of each period.
        """
        out = []
        for _ in range(ms // 10):
            self.now += 10 * MS
            i = self.inputs
            noise = 1e-4 * (self.now // MS % 7)
            if "joint" not in silent:
                noisy = tuple(t + (0.0 if index in frozen else noise) for index, t in enumerate(joint.tension))
                i.joint, i.joint_ns = replace(joint, tension=noisy), self.now
            if "angle" not in silent:
                i.angle, i.angle_ns = 0.0, self.now
            if "motors" not in silent:
                i.motors, i.motors_ns = motors, self.now
            if "springs" not in silent:
                i.springs, i.springs_ns = SPRINGS, (self.now, self.now)
            i.measured_ns = {topic: self.now - age * MS for topic, age in (late or {}).items()}
            if commands:
                self.supervisor.command(target, i, self.now)
            sent = self.supervisor.step(i, self.now)
            out.append((self.now, self.supervisor.mode, self.supervisor.reason, sent))
        return out


def test_tunable_parameters_change_without_a_change_of_mode():
    feed = active()
    before = feed.supervisor.mode
    feed.supervisor.reconfigure(ControlConfig(command_timeout=0.1, rate=200.0, force_max=49.0, input_timeout=0.07))
    assert feed.supervisor.mode is before is Mode.ACTIVE
    silence = feed.run(300, commands=False)
    stopped = next(at for at, mode, *_ in silence if mode is Mode.HOLDING)
    assert stopped - silence[0][0] <= 110 * MS
    assert feed.supervisor.reason == "stiffness_command stopped"
    feed.run(1000, joint=replace(GOOD, tension=(40.0, 40.0)))
    assert "over its limit" in feed.supervisor.reason


def active():
    feed = Feed()
    assert feed.run(500)[-1][1] is Mode.ACTIVE
    return feed


def first_hold(feed, out, since):
    held = [row for row in out if row[1] is Mode.HOLDING]
    assert held, "never held"
    return (held[0][0] - since) / MS, held[-1][2]


def test_no_motor_command_before_the_first_stiffness_command():
    feed = Feed()
    out = feed.run(200, commands=False)
    assert {row[3] for row in out} == {None}
    assert out[-1][1] is Mode.IDLE


@pytest.mark.parametrize(
    ("silent", "expected"),
    [
        ("joint", "joint_impedance silent"),
        ("angle", "joint_states silent"),
        ("motors", "motor_states silent"),
    ],
)
def test_a_silent_input_holds_within_a_hundred_milliseconds(silent, expected):
    feed = active()
    since = feed.now
    delay, reason = first_hold(feed, feed.run(300, silent=(silent,)), since)
    assert delay <= 100
    assert reason == expected


@pytest.mark.parametrize(
    ("joint", "expected"),
    [
        (replace(GOOD, stiffness_valid=False, status=Status.FAULT, reason="transmission_1 FAULT"), "transmission_1"),
        (replace(GOOD, status=Status.STALE, reason="transmission_2 silent"), "transmission_2 silent"),
        (replace(GOOD, force_valid=False, status=Status.DEGRADED, reason="transmission_1 DEGRADED"), "transmission_1"),
    ],
)
def test_an_invalid_estimate_holds_immediately_at_the_measured_positions(joint, expected):
    feed = active()
    since = feed.now
    out = feed.run(200, joint=joint)
    delay, reason = first_hold(feed, out, since)
    assert delay <= 10
    assert expected in reason
    assert {row[3] for row in out} == {MOTORS}


@pytest.mark.parametrize("fault", [{"silent": ("motors",)}, {"late": {"motor_states": 300}}])
def test_without_recent_motor_positions_the_last_sent_ones_are_held(fault):
    feed = active()
    moving = feed.run(100, target=Target(0.0, 3.0))[-1][3]
    assert moving != pytest.approx(MOTORS, abs=0.02)
    out = feed.run(300, target=Target(0.0, 3.0), **fault)
    sent = moving
    for _, mode, _, motors in out:
        if mode is Mode.HOLDING:
            assert motors == sent
        sent = motors
    assert out[-1][1] is Mode.HOLDING


@pytest.mark.parametrize("index", [0, 1])
def test_a_frozen_force_holds_within_a_second(index):
    feed = active()
    since = feed.now
    delay, reason = first_hold(feed, feed.run(1200, frozen=(index,)), since)
    assert delay <= 1000
    assert f"force of transmission_{index + 1} frozen" in reason


@pytest.mark.parametrize(
    ("tension", "expected"), [((0.0, 25.0), "transmission_1 slack"), ((25.0, 110.0), "over its limit")]
)
def test_an_implausible_force_holds_immediately(tension, expected):
    feed = active()
    since = feed.now
    delay, reason = first_hold(feed, feed.run(100, joint=replace(GOOD, tension=tension)), since)
    assert delay <= 10
    assert expected in reason


def test_the_end_of_commands_holds_after_the_timeout():
    feed = active()
    since = feed.now
    delay, reason = first_hold(feed, feed.run(1000, commands=False), since)
    assert 500 <= delay <= 520
    assert reason == "stiffness_command stopped"


UNREACHABLE = Target(0.0, 50.0)


def test_refused_commands_do_not_end_a_hold_by_a_missing_command():
    feed = active()
    feed.run(1000, commands=False)
    out = feed.run(2000, target=UNREACHABLE)
    assert {row[1] for row in out} == {Mode.HOLDING}
    assert out[-1][2] == "stiffness_command stopped"
    assert feed.run(1000)[-1][1] is Mode.ACTIVE


def test_a_client_whose_commands_are_refused_in_between_keeps_control_of_the_former_target():
    feed = active()
    assert {row[1] for row in feed.run(2000, target=UNREACHABLE)} == {Mode.ACTIVE}
    assert feed.supervisor.target == TARGET


@pytest.mark.parametrize(("duration", "holding_periods"), [(200, 12), (1000, 40)])
def test_control_resumes_after_the_duration_of_the_fault_or_the_recovery_time(duration, holding_periods):
    feed = active()
    commanded = feed.run(10)[-1][3]
    feed.run(duration, silent=("joint",))
    out = feed.run(1000)
    assert out[holding_periods][1] is Mode.HOLDING
    assert out[-1][1] is Mode.ACTIVE
    resumed = next(row for row in out if row[1] is Mode.ACTIVE)
    begins_anew = duration > 500  # at the measured positions
    assert resumed[3] == pytest.approx(MOTORS if begins_anew else commanded, abs=0.05)


def test_a_short_timeout_costs_no_more_than_twice_its_duration():
    feed = active()
    held = [row for row in feed.run(120, silent=("joint",)) if row[1] is Mode.HOLDING]
    out = feed.run(300)
    resumed = next(row for row in out if row[1] is Mode.ACTIVE)
    assert (resumed[0] - held[0][0]) / MS <= 130


@pytest.mark.parametrize("topic", ["joint_impedance", "joint_states", "motor_states"])
def test_a_backlog_is_detected_by_its_stamps(topic):
    feed = active()
    assert feed.run(200, late={topic: 30})[-1][1] is Mode.ACTIVE
    delay, reason = first_hold(feed, feed.run(100, late={topic: 300}), feed.now)
    assert delay <= 10
    assert reason.startswith(f"{topic} comes late")


def test_a_delayed_joint_estimate_holds_with_the_fault_of_the_estimator():
    feed = active()
    feed.inputs.estimator_faults = ("", "no samples")
    _, reason = first_hold(feed, feed.run(20, late={"joint_impedance": 260}), feed.now)
    assert reason.endswith("(transmission_2: no samples)")


@pytest.mark.parametrize(("topic", "limit"), [("joint_impedance", 60), ("joint_states", 90), ("motor_states", 90)])
def test_a_late_input_gives_feed_forward_without_a_hold_and_states_its_age(topic, limit):
    feed = active()
    out = feed.run(3000, late={topic: 150})
    assert {row[1] for row in out} == {Mode.FEED_FORWARD}
    assert out[-1][2] == f"{topic} comes late: more than {limit} ms old by its stamps"
    assert "recent inputs" in feed.supervisor.waits_for
    assert {row[1] for row in feed.run(200)} == {Mode.ACTIVE}


@pytest.mark.parametrize("topic", ["joint_impedance", "joint_states", "motor_states"])
@pytest.mark.parametrize("joint", [GOOD, replace(GOOD, stiffness_valid=False)])
def test_a_late_input_with_an_inaccurate_law_holds_until_a_newer_one(topic, joint):
    feed = active()
    feed.supervisor.reconfigure(ControlConfig(recovery_amplitude=1e-3))
    feed.supervisor.control.predicted_error = lambda *_: 1.0
    out = feed.run(100, joint=joint, late={topic: 150})
    assert {row[1] for row in out} == {Mode.HOLDING}
    assert feed.supervisor.waits_for == f"a newer {topic}"


@pytest.mark.parametrize("topic", ["joint_impedance", "joint_states", "motor_states"])
def test_a_late_input_before_a_valid_law_is_no_control(topic):
    feed = Feed()
    out = feed.run(300, late={topic: 150})
    assert Mode.FEED_FORWARD not in {row[1] for row in out}


@pytest.mark.parametrize(("valid", "limit"), [(True, 1.0), (False, 0.25)])
def test_a_silent_estimator_state_holds_later_while_the_stiffness_is_valid(valid, limit):
    feed, joint = active(), replace(GOOD, stiffness_valid=valid)
    since = feed.now
    delay, reason = first_hold(feed, feed.run(1200, joint=joint, silent=("springs",)), since)
    assert 1e3 * limit - 20.0 <= delay <= 1e3 * limit
    assert reason.startswith("transmission_1/estimator_state silent")


def test_a_silent_joint_holds_with_the_names_of_the_silent_estimators():
    feed = active()
    _, reason = first_hold(feed, feed.run(100, silent=("joint", "springs")), feed.now)
    assert reason.endswith("(transmission_1: silent; transmission_2: silent)")


def test_a_stamp_in_the_future_holds():
    feed = active()
    out = feed.run(100, late={"joint_impedance": -3000})
    assert out[0][1] is Mode.HOLDING
    assert "in the future" in out[0][2]


def test_control_is_active_at_a_slow_rate():
    feed = Feed(rate=10.0)
    assert feed.run(500)[-1][1] is Mode.ACTIVE


def test_limits_without_a_reachable_stiffness_hold_the_motors_until_there_is_one():
    feed = active()
    feed.supervisor.reconfigure(ControlConfig(deflection_max=0.001))
    out = feed.run(300, motors=MOTORS) + feed.run(300, motors=(MOTORS[0] + 0.05, MOTORS[1]))
    assert {row[1] for row in out} == {Mode.HOLDING}
    assert len({row[3] for row in out}) == 1
    assert "deflection_max" in out[-1][2]
    feed.supervisor.reconfigure(ControlConfig())
    assert feed.run(1000)[-1][1] is Mode.ACTIVE


def test_motors_that_do_not_follow_are_detected():
    feed = Feed()
    out = feed.run(3000, joint=replace(GOOD, tension=(15.0, 15.0), stiffness=0.6))
    assert any("do not follow" in row[2] for row in out)


def test_a_refused_command_keeps_the_target():
    feed = active()
    feasibility = feed.supervisor.command(Target(0.0, 50.0), feed.inputs, feed.now)
    assert not feasibility.accepted
    assert "reachable" in feasibility.text
    assert feed.supervisor.target == TARGET
    assert feed.supervisor.refused == 1


def test_an_invalid_damping_does_not_stop_control():
    feed = active()
    out = feed.run(200, joint=replace(GOOD, damping_valid=False))
    assert {row[1] for row in out} == {Mode.ACTIVE}


def test_the_reason_of_a_hold_includes_the_fault_of_the_estimator():
    feed = active()
    feed.inputs.estimator_faults = ("", "force sensor stuck")
    out = feed.run(
        100, joint=replace(GOOD, force_valid=False, status=Status.DEGRADED, reason="transmission_2 DEGRADED")
    )
    assert out[-1][2] == "tension invalid: transmission_2 DEGRADED (transmission_2: force sensor stuck)"
