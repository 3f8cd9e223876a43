"""What makes the motors hold, how soon, and what is said; instants are given."""

import math
from dataclasses import replace

import pytest
from vsa_common.types import Status
from vsa_joint.control.controller import Target
from vsa_joint.control.springs import Spring
from vsa_joint.control.supervisor import Inputs, JointMeasurement, Mode, Supervisor
from vsa_joint.settings import ControlConfig

MS = 1_000_000
SPRINGS = (
    Spring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    Spring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)
GOOD = JointMeasurement(1.5, True, 0.9, True, (25.0, 25.0), True, Status.VALID, "")
MOTORS = (2.6, 2.2)
TARGET = Target(0.0, 1.5)


class Feed:
    """All inputs at 100 Hz, but for what a test breaks."""

    def __init__(self, **config):
        self.supervisor = Supervisor(ControlConfig(**config))
        self.inputs = Inputs()
        self.now = 0

    def run(self, ms, joint=GOOD, commands=True, motors=MOTORS, quiet=(), frozen=(), late=None):
        """Steps for `ms`; `quiet` names inputs that stop, `late` has ages by stamp [ms].

        Returns (instant, mode, reason, motors) of each.
        """
        out = []
        for _ in range(ms // 10):
            self.now += 10 * MS
            i = self.inputs
            noise = 1e-4 * (self.now // MS % 7)
            if "joint" not in quiet:
                noisy = tuple(t + (0.0 if side in frozen else noise) for side, t in enumerate(joint.tension))
                i.joint, i.joint_ns = replace(joint, tension=noisy), self.now
            if "angle" not in quiet:
                i.angle, i.angle_ns = 0.0, self.now
            if "motors" not in quiet:
                i.motors, i.motors_ns = motors, self.now
            if "springs" not in quiet:
                i.springs, i.springs_ns = SPRINGS, (self.now, self.now)
            i.measured_ns = {topic: self.now - age * MS for topic, age in (late or {}).items()}
            if commands:
                self.supervisor.command(TARGET, i, self.now)
            sent = self.supervisor.step(i, self.now)
            out.append((self.now, self.supervisor.mode, self.supervisor.reason, sent))
        return out


def working():
    feed = Feed()
    assert feed.run(500)[-1][1] is Mode.ACTIVE
    return feed


def first_hold(feed, out, since):
    held = [row for row in out if row[1] is Mode.HOLDING]
    assert held, "never held"
    return (held[0][0] - since) / MS, held[-1][2]


def test_nothing_is_said_to_the_motors_before_the_first_command():
    feed = Feed()
    out = feed.run(200, commands=False)
    assert {row[3] for row in out} == {None}
    assert out[-1][1] is Mode.IDLE


@pytest.mark.parametrize(
    ("quiet", "reason"),
    [
        ("joint", "joint_impedance silent"),
        ("angle", "joint_states silent"),
        ("motors", "motor_states silent"),
    ],
)
def test_a_silent_input_holds_within_a_hundred_milliseconds(quiet, reason):
    feed = working()
    since = feed.now
    delay, told = first_hold(feed, feed.run(300, quiet=(quiet,)), since)
    assert delay <= 100
    assert told == reason


@pytest.mark.parametrize(
    ("joint", "reason"),
    [
        (replace(GOOD, stiffness_valid=False, reason="transmission_1 CONVERGING"), "transmission_1 CONVERGING"),
        (replace(GOOD, status=Status.STALE, reason="transmission_2 silent"), "transmission_2 silent"),
        (replace(GOOD, force_valid=False, status=Status.DEGRADED, reason="transmission_1 DEGRADED"), "transmission_1"),
    ],
)
def test_an_invalid_estimate_holds_at_once_where_the_motors_are(joint, reason):
    feed = working()
    since = feed.now
    out = feed.run(200, joint=joint)
    delay, told = first_hold(feed, out, since)
    assert delay <= 10
    assert reason in told
    assert {row[3] for row in out} == {MOTORS}


@pytest.mark.parametrize("side", [0, 1])
def test_a_frozen_force_holds_within_a_second(side):
    feed = working()
    since = feed.now
    delay, told = first_hold(feed, feed.run(1200, frozen=(side,)), since)
    assert delay <= 1000
    assert f"force of transmission_{side + 1} frozen" in told


@pytest.mark.parametrize(
    ("tension", "said"), [((0.0, 25.0), "transmission_1 slack"), ((25.0, 110.0), "over its limit")]
)
def test_a_force_that_cannot_be_holds_at_once(tension, said):
    feed = working()
    since = feed.now
    delay, told = first_hold(feed, feed.run(100, joint=replace(GOOD, tension=tension)), since)
    assert delay <= 10
    assert said in told


def test_a_command_that_stops_holds_after_its_timeout():
    feed = working()
    since = feed.now
    delay, told = first_hold(feed, feed.run(1000, commands=False), since)
    assert 500 <= delay <= 520
    assert told == "stiffness_command stopped"


@pytest.mark.parametrize(("silence", "still"), [(200, 20), (1000, 40)])
def test_control_resumes_by_itself_after_all_was_well_for_a_while(silence, still):
    feed = working()
    feed.run(silence, quiet=("joint",))
    out = feed.run(1000)
    assert out[still][1] is Mode.HOLDING
    assert out[-1][1] is Mode.ACTIVE
    resumed = next(row for row in out if row[1] is Mode.ACTIVE)
    assert resumed[3] == pytest.approx(MOTORS, abs=0.05)


def test_a_short_silence_costs_no_more_than_twice_itself():
    feed = working()
    held = [row for row in feed.run(120, quiet=("joint",)) if row[1] is Mode.HOLDING]
    out = feed.run(300)
    resumed = next(row for row in out if row[1] is Mode.ACTIVE)
    assert (resumed[0] - held[0][0]) / MS <= 130


@pytest.mark.parametrize("topic", ["joint_impedance", "joint_states", "motor_states"])
def test_a_backlog_is_old_though_it_arrives(topic):
    feed = working()
    assert feed.run(200, late={topic: 30})[-1][1] is Mode.ACTIVE
    delay, told = first_hold(feed, feed.run(100, late={topic: 150}), feed.now)
    assert delay <= 10
    assert told.startswith(f"{topic} comes late")


def test_of_a_joint_that_comes_late_the_side_is_named_that_has_no_samples():
    feed = working()
    feed.inputs.complaints = ("", "no samples")
    _, told = first_hold(feed, feed.run(20, late={"joint_impedance": 80}), feed.now)
    assert told.endswith("(transmission_2: no samples)")


def test_of_a_joint_that_falls_silent_the_estimators_are_named_that_do_too():
    feed = working()
    _, told = first_hold(feed, feed.run(100, quiet=("joint", "springs")), feed.now)
    assert told.endswith("(transmission_1: silent; transmission_2: silent)")


def test_an_age_that_nobody_can_know_holds():
    feed = working()
    out = feed.run(100, late={"joint_impedance": -3000})
    assert out[0][1] is Mode.HOLDING
    assert "in the future" in out[0][2]


def test_at_a_slow_rate_control_works_too():
    feed = Feed(rate=10.0)
    assert feed.run(500)[-1][1] is Mode.ACTIVE


def test_motors_that_do_not_follow_are_noticed():
    feed = Feed()
    out = feed.run(3000, joint=replace(GOOD, tension=(15.0, 15.0), stiffness=0.6))
    assert any("do not follow" in row[2] for row in out)


def test_a_refused_command_keeps_the_target():
    feed = working()
    judgement = feed.supervisor.command(Target(0.0, 50.0), feed.inputs, feed.now)
    assert not judgement.accepted
    assert "within reach" in judgement.text
    assert feed.supervisor.target == TARGET
    assert feed.supervisor.refused == 1


def test_one_invalid_damping_does_not_stop_control():
    feed = working()
    out = feed.run(200, joint=replace(GOOD, damping_valid=False))
    assert {row[1] for row in out} == {Mode.ACTIVE}


def test_a_hold_says_what_the_estimator_complains_of():
    feed = working()
    feed.inputs.complaints = ("", "force sensor stuck")
    out = feed.run(
        100, joint=replace(GOOD, force_valid=False, status=Status.DEGRADED, reason="transmission_2 DEGRADED")
    )
    assert out[-1][2] == "tension invalid: transmission_2 DEGRADED (transmission_2: force sensor stuck)"
