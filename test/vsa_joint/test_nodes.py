# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Joint node and stiffness controller as processes: estimates in, motor commands out, holds."""

import math
import os
import signal
import subprocess
import sys
import time

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.experimental import EventsExecutor
from sensor_msgs.msg import JointState
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import nanoseconds, set_stamp
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.control.stiffness_range import tendon_travel
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.impedance.reflection import Impedance, virtual_work
from vsa_msgs.msg import EstimatorState, JointImpedance, StiffnessCommand, TransmissionImpedance

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 50) % 80
ENVIRONMENT = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
PERIOD = 0.01  # s
MOTOR_NAMES = ["flexor", "extensor"]
FORCE = 40.0  # N
SPRINGS = (
    ExponentialSpring(0.0, math.log(267.2 * 0.776), 267.2, 16.39),
    ExponentialSpring(0.0, math.log(165.6 * 7.031), 165.6, 8.269),
)
MOTORS = [tendon_travel(FORCE, spring.deflection(FORCE), 1e5) / 0.01 for spring in SPRINGS]


def start(module, *parameters):
    file = {"joint": "node", "stiffness_controller": "controller_node"}[module]
    code = f"import sys; sys.argv[0] = '{module}'; from vsa_joint.{file} import main; sys.exit(main())"
    arguments = [word for given in parameters for word in ("-r" if given.startswith("__") else "-p", given)]
    command = [sys.executable, "-c", code, "--ros-args", *arguments]
    return subprocess.Popen(command, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)


class Harness:
    """Publishes estimates and measurements of a joint at rest under equal forces."""

    def __init__(self):
        joint = start("joint", "frame_prefix:=left/", "joint_name:=elbow")
        self.processes = [joint, start("stiffness_controller", "input_timeout:=0.08", "law_error_max:=0.01")]
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("harness", namespace="vsa", context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        publish = self.node.create_publisher
        self.impedance = [publish(TransmissionImpedance, f"transmission_{n}/impedance", RELIABLE) for n in (1, 2)]
        self.state = [publish(EstimatorState, f"transmission_{n}/estimator_state", RELIABLE) for n in (1, 2)]
        self.angle = publish(JointState, "joint_states", RELIABLE)
        self.motors = publish(JointState, "motor_states", RELIABLE)
        self.command = publish(StiffnessCommand, "stiffness_command", RELIABLE)
        self.joints, self.commands, self.statuses = [], [], []
        self.subscribe(JointImpedance, "joint_impedance", self.joints)
        self.subscribe(JointState, "motor_commands", self.commands)
        self.subscribe(DiagnosticStatus, "stiffness_controller/status", self.statuses)
        self.diagnostics = []
        self.subscribe(DiagnosticArray, "/diagnostics", self.diagnostics)

    def subscribe(self, kind, topic, messages):
        self.node.create_subscription(kind, topic, lambda m: messages.append((time.monotonic(), m)), RELIABLE)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def wait(self, condition, timeout=60.0, **inputs):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, "timeout"
            self.feed(**inputs)

    def feed(self, transmissions=(0, 1), stiffness=None, delay=0.0, valid=True):
        """Publish one period of estimates and measurements, `delay` s old; their stamp [ns]."""
        stamp = time.time_ns() - int(delay * 1e9)
        for index in transmissions:
            message, spring = TransmissionImpedance(), SPRINGS[index]
            set_stamp(message.header.stamp, stamp)
            message.force, message.force_valid = FORCE + 1e-6 * (stamp % 1000), True
            message.stiffness, message.stiffness_variance = spring.stiffness(FORCE), 100.0
            message.damping, message.inertia, message.status = 4000.0, 0.3, TransmissionImpedance.STATUS_VALID
            message.stiffness_valid = message.damping_valid = message.inertia_valid = valid
            self.impedance[index].publish(message)
            state = EstimatorState(deflection_reference=0.0, ln_stiffness_reference=spring.ln_stiffness, k2=spring.k2)
            state.force_offset, state.k2_valid, state.d1, state.d2 = spring.force_offset, True, 4000.0, -1e8
            self.state[index].publish(state)
        angle = JointState(name=["joint"], position=[0.0])
        motors = JointState(name=MOTOR_NAMES, position=MOTORS)
        motors.header.frame_id = "left/motors"
        for publisher, message in ((self.angle, angle), (self.motors, motors)):
            set_stamp(message.header.stamp, stamp)
            publisher.publish(message)
        if stiffness is not None:
            self.command.publish(StiffnessCommand(stiffness=stiffness))
        self.spin(PERIOD)
        return stamp

    def run(self, seconds, **inputs):
        """Feed for a duration [s]; the stamps of all periods [ns]."""
        return [self.feed(**inputs) for _ in range(round(seconds / PERIOD))]

    def close(self):
        for process in self.processes:
            process.send_signal(signal.SIGTERM)
        codes = [process.wait(10) for process in self.processes]
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        return codes


@pytest.fixture(scope="module")
def harness():
    harness = Harness()
    harness.wait(lambda: harness.joints and harness.joints[-1][1].stiffness_valid)
    harness.wait(
        lambda: harness.node.count_subscribers("/vsa/stiffness_command") and harness.joints[-1][1].stiffness_range_valid
    )
    yield harness
    assert harness.close() == [0, 0]


def joint_truth():
    transmissions = tuple(Impedance(spring.stiffness(FORCE), 4000.0, 0.3) for spring in SPRINGS)
    return virtual_work(transmissions, Joint((TendonPath(0.0215, 1e5), TendonPath(0.0215, 1e5)), 0.01, 1e-3))


def test_the_joint_message_has_impedance_tension_range_and_both_stamps(harness):
    harness.run(0.2)
    last = harness.joints[-1][1]
    truth = joint_truth()
    assert (last.stiffness, last.damping, last.inertia) == pytest.approx(
        (truth.stiffness, truth.damping, truth.inertia), rel=1e-9
    )
    assert last.header.frame_id == "left/elbow"
    assert list(last.tension) == pytest.approx([20.0, 20.0], abs=1e-3)
    assert last.stiffness_min == pytest.approx(0.30, abs=0.01)
    assert last.stiffness_max > 7.0
    assert max(nanoseconds(stamp) for stamp in last.transmission_stamp) == nanoseconds(last.header.stamp)


def test_motors_close_to_their_limit_clip_the_range(harness):
    widest = harness.joints[-1][1].stiffness_max
    narrow = start("joint", "motor_max:=3.0", "__node:=narrow")
    harness.joints.clear()
    harness.wait(lambda: any(m.stiffness_range_valid and m.stiffness_max < 0.9 * widest for _, m in harness.joints))
    narrow.send_signal(signal.SIGTERM)
    assert narrow.wait(10) == 0


def test_no_motor_command_before_a_command_and_the_first_is_the_measured_position(harness):
    assert not harness.commands
    harness.wait(lambda: harness.commands, stiffness=joint_truth().stiffness)
    first = harness.commands[0][1]
    assert list(first.position) == pytest.approx(MOTORS, abs=0.02)
    assert (first.name, first.header.frame_id) == (MOTOR_NAMES, "left/motors")


def test_an_unreachable_command_is_refused_with_the_range(harness):
    harness.run(0.2, stiffness=joint_truth().stiffness)
    harness.statuses.clear()
    harness.run(0.1, stiffness=50.0)
    refusals = [{v.key: v.value for v in m.values} for _, m in harness.statuses if "cannot be reached" in m.message]
    refusal = next(values for values in refusals if values.get("accepted") == "False")
    assert float(refusal["stiffness_max"]) < 8.0


def test_the_diagnostics_state_why_a_command_is_refused_and_that_it_is_accepted_again(harness):
    def control():
        found = [m for _, array in harness.diagnostics for m in array.status if m.name.endswith("controller: control")]
        return found[-1] if found else None

    harness.wait(
        lambda: control() and "command refused: 50 N m/rad cannot be reached" in control().message, stiffness=50.0
    )
    status = control()
    assert status.level == DiagnosticStatus.WARN
    values = {value.key: value.value for value in status.values}
    assert values["command_accepted"] == "False"
    assert values["command_reason"].startswith("50 N m/rad cannot be reached")
    good = joint_truth().stiffness
    harness.wait(lambda: control().level == DiagnosticStatus.OK, stiffness=good)
    assert control().message == "active"


def test_a_healthy_joint_is_ok(harness):
    def impedance():
        found = [m for _, array in harness.diagnostics for m in array.status if m.name == "/vsa/joint: impedance"]
        return found[-1] if found else None

    harness.wait(lambda: impedance() and impedance().level == DiagnosticStatus.OK, stiffness=joint_truth().stiffness)
    assert impedance().message.startswith("active")


def test_a_stopped_estimator_invalidates_the_joint_and_the_motors_hold_in_time(harness):
    good = joint_truth().stiffness
    stopped = harness.run(1.0, stiffness=good)[-1]
    harness.joints.clear()
    harness.statuses.clear()
    harness.run(0.5, transmissions=(0,), stiffness=good)
    harness.wait(
        lambda: any(m.level == b"\x02" for _, m in harness.statuses), timeout=5.0, transmissions=(0,), stiffness=good
    )
    assert harness.joints[-1][1].reason == "transmission_2 silent"
    status = next(m for _, m in harness.statuses if m.level == b"\x02")
    held = int(next(value.value for value in status.values if value.key == "stamp_ns"))
    assert (held - stopped) * 1e-9 < 0.1
    assert status.message
    assert not any(m.stiffness_valid and nanoseconds(m.header.stamp) > stopped for _, m in harness.joints)
    assert list(harness.commands[-1][1].position) == pytest.approx(MOTORS)


def test_a_hold_for_an_invalid_stiffness_has_its_end_and_its_duration(harness):
    good = joint_truth().stiffness
    harness.run(1.5, stiffness=good)
    harness.statuses.clear()

    def values():
        return [{v.key: v.value for v in m.values} for _, m in harness.statuses]

    def held():
        return [one for one in values() if one["mode"] == "holding" and float(one["mode_duration_s"]) >= 1.0]

    harness.wait(held, timeout=20.0, stiffness=good, valid=False)
    assert held()[0]["waits_for"].startswith("a valid stiffness: move the joint by hand")
    modes = [one["mode"] for one in values() if one["mode"] != "active"]
    assert list(dict.fromkeys(modes)) == ["feed_forward", "holding"]

    def control():
        return [m.message for _, array in harness.diagnostics for m in array.status if m.name.endswith(": control")][-1]

    assert control().startswith("holding for ")
    assert "waits for a valid stiffness" in control()
    harness.wait(lambda: control() == "active", timeout=20.0, stiffness=good)


def test_a_backlog_is_detected_by_its_stamps(harness):
    harness.run(1.5, stiffness=joint_truth().stiffness)
    harness.spin(0.3)
    harness.statuses.clear()
    harness.run(0.3, stiffness=joint_truth().stiffness, delay=0.3)
    assert any("comes late" in m.message for _, m in harness.statuses)


def test_control_resumes_with_the_estimator_and_stops_with_the_commands(harness):
    good = joint_truth().stiffness
    harness.statuses.clear()
    harness.run(1.5, stiffness=good)
    assert any(m.level == b"\x00" for _, m in harness.statuses)
    harness.statuses.clear()
    harness.run(1.0)
    assert any(m.message == "stiffness_command stopped" for _, m in harness.statuses)


@pytest.mark.parametrize(
    ("module", "parameter", "expected"),
    [
        ("joint", "max_skew:=-1.0", "max_skew = -1.0 s"),
        ("joint", "radius:=[0.02]", "must be two numbers"),
        ("stiffness_controller", "rate:=0.0", "rate = 0.0 Hz"),
    ],
)
def test_an_invalid_parameter_gives_a_one_line_error(module, parameter, expected):
    process = start(module, parameter)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert expected in errors
    assert "Traceback" not in errors
