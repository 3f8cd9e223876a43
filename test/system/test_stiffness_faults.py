# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness control on one running suite while sensors, an estimator and the commands fail: the motors hold."""

import signal
import time

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from host import undisturbed
from priority import RIG, raised_priority, with_nice
from sensor_msgs.msg import JointState
from services import answer_of
from std_srvs.srv import SetBool
from vsa_common.ros.node import RELIABLE, STEADY
from vsa_msgs.msg import JointImpedance, StiffnessCommand
from vsa_msgs.srv import InjectFailure
from vsa_tools.demo.command import PROCESSES
from vsa_tools.demo.harness import ProcessHarness, ProcessSpec
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, write_parameters

pytestmark = pytest.mark.live

RATE = 250
INITIALIZATION = 14.0  # [s] of motion before the first command
RECOVERY = 90.0  # [s] until control is active again at most, with queued messages on a busy machine
SOFT, STIFF, PERIOD = 1.0, 1.4, 1.0  # [N m/rad, s] alternating commands, so that the motors move
COMMAND_PERIOD = 0.02  # [s]
COMMAND_GAP = 0.2  # [s] between two commands of this process above which control may stop: timeout 0.5 s, and transport
MOVED = 0.02  # [rad] minimum difference of motor commands that move the motors
CONTROLLER = ProcessSpec("stiffness_controller", "vsa_joint", "stiffness_controller")
SUITE = (*(one for one in PROCESSES if one.name != "recorder"), CONTROLLER)


class Lab:
    """The suite under stiffness control and its messages; instants of a steady clock."""

    def __init__(self, harness):
        self.harness, self.commanding = harness, False
        self.statuses, self.joints, self.motors = [], [], []
        self.commanded_at = self.gap_at = 0.0  # this process may be late with its commands, too
        subscribe = harness.node.create_subscription
        subscribe(DiagnosticStatus, "stiffness_controller/status", lambda m: self.statuses.append((now(), m)), RELIABLE)
        subscribe(JointImpedance, "joint_impedance", lambda m: self.joints.append((now(), m)), RELIABLE)
        subscribe(JointState, "motor_commands", lambda m: self.motors.append((now(), tuple(m.position))), RELIABLE)
        self.commands = harness.node.create_publisher(StiffnessCommand, "stiffness_command", RELIABLE)
        self.failure = harness.node.create_client(InjectFailure, "rig_simulator/failure")
        harness.node.create_timer(COMMAND_PERIOD, self.command, clock=STEADY)

    def command(self):
        if self.commanding:
            stiffness = SOFT if int(now() / PERIOD) % 2 else STIFF
            self.commands.publish(StiffnessCommand(stiffness=stiffness))
            self.update_gap()
            self.commanded_at = now()

    def update_gap(self):
        """Keep the instant of the last gap between the commands."""
        if now() - self.commanded_at > COMMAND_GAP:
            self.gap_at = now()

    def until(self, condition, seconds=20.0):
        end = now() + seconds
        while not condition():
            assert now() < end, [status.message for _, status in self.statuses[-5:]]
            self.harness.spin(0.005)

    def is_active(self):
        """Whether control is active and has moved the motors since, without a gap between the commands."""
        self.update_gap()
        active = [at for at, status in self.statuses if status.message == "active"]
        held = [at for at, status in self.statuses if status.level == DiagnosticStatus.ERROR]
        since = now() - 1.5 * PERIOD
        return bool(active) and (not held or active[-1] > held[-1]) and max(active[-1], self.gap_at) < since

    def resume(self):
        self.commanding = True
        self.until(self.is_active, RECOVERY)
        self.statuses.clear()

    def fail(self, failure):
        """Inject a failure; the instant before it can have begun."""
        self.until(self.failure.service_is_ready)
        begin = now()
        answer = self.failure.call_async(InjectFailure.Request(failure=failure))
        self.until(answer.done)
        assert answer.result().success
        return begin

    def hold_after(self, failure):
        """As `evaluate`, for a failure."""
        return self.evaluate(lambda: self.held(self.fail(failure)))

    def evaluate(self, trial):
        """Time until the controller holds the motors [s] and its reason; the motors must not move afterwards."""
        delay, reason, moved = undisturbed(trial, self.resume)
        assert moved < 1e-9
        return delay, reason

    def held(self, since):
        """Time until the motors hold [s], the reason, and their motion after that [rad]."""
        self.until(lambda: any(status.level == DiagnosticStatus.ERROR for _, status in self.statuses))
        at, status = next((at, status) for at, status in self.statuses if status.level == DiagnosticStatus.ERROR)
        self.harness.spin(0.3)
        after = [position for when, position in self.motors if when > at + 0.02]
        assert len(after) > 10
        print(f"held after {1e3 * (at - since):.0f} ms: {status.message}")
        moved = max(abs(a - b) for position in after for a, b in zip(position, after[0], strict=True))
        return at - since, status.message, moved


def now():
    return time.monotonic()


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stiffness_faults")
    domain = claim_domain()
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={domain.bus_port}"]}
    run = {
        "rig_simulator": {"rate_hz": RATE, "autostart_clock": False, "bus": bus, **RIG},
        "driver": {"autostart": False, "bus": bus},
    }
    write_parameters(folder / "parameters.yaml", base_parameters(), run)
    with raised_priority() as nice, ProcessHarness(domain.environment(), folder / "logs") as harness:
        harness.start(with_nice(SUITE, nice), folder / "parameters.yaml")
        harness.wait_until_active(*(one.name for one in SUITE if one.name != "driver"))
        harness.activate("driver")
        lab = Lab(harness)
        harness.request("rig_simulator/start")
        harness.spin(INITIALIZATION)
        lab.until(lambda: lab.joints and lab.joints[-1][1].stiffness_range_valid, RECOVERY)
        assert answer_of(harness.node, lab.until, SetBool, "driver/arm", SetBool.Request(data=True)).success
        yield lab


@pytest.fixture
def control(lab):
    lab.resume()
    return lab


def test_control_moves_the_motors_and_reports_an_unreachable_command(control):
    positions = [position[0] for _, position in control.motors[-100:]]
    assert max(positions) - min(positions) > MOVED
    control.commanding = False
    control.commands.publish(StiffnessCommand(stiffness=50.0))
    control.until(lambda: any("cannot be reached" in status.message for _, status in control.statuses))
    values = {v.key: v.value for _, status in control.statuses for v in status.values if "cannot" in status.message}
    assert values["accepted"] == "False"
    assert 0.2 < float(values["stiffness_min"]) < float(values["stiffness_max"]) < 9.0


def test_the_end_of_commands_stops_the_motors(control):
    def trial():
        control.commanding = False
        return control.held(control.commanded_at)

    delay, reason = control.evaluate(trial)
    assert reason == "stiffness_command stopped"
    assert 0.4 < delay < 0.55


@pytest.mark.parametrize("side", [1, 2])
def test_a_disconnected_force_sensor_stops_the_motors_within_a_tenth_of_a_second(control, side):
    delay, reason = control.hold_after(f"force off -i {side} -t 0.6")
    assert delay < 0.1
    assert f"transmission_{side}" in reason


def test_missing_frames_of_one_side_stop_the_motors_within_a_tenth_of_a_second(control):
    delay, reason = control.hold_after("can_signal off -i 1 -t 0.6")
    assert delay < 0.1
    assert "transmission_1" in reason


@pytest.mark.parametrize("side", [1, 2])
def test_a_frozen_force_stops_the_motors_within_a_second(control, side):
    delay, reason = control.hold_after(f"force stuck -i {side} -t 1.5")
    assert delay < 1.0
    assert f"transmission_{side}" in reason


def test_a_killed_estimator_stops_the_motors_within_a_tenth_of_a_second(control):
    since = now()
    process = control.harness.group[SUITE[1].name]
    process.signal(signal.SIGKILL)
    control.harness.group._processes.pop(SUITE[1].name)
    delay, reason, moved = control.held(since)
    assert moved < 1e-9
    assert SUITE[1].name == "estimator_2"
    assert delay < 0.1
    assert reason
    assert not control.joints[-1][1].stiffness_valid
    assert control.joints[-1][1].reason == "transmission_2 silent"
    process.wait(5.0)
