"""Joint and stiffness controller as processes of their own: estimates in, motor commands out, and what stops them."""

import math
import os
import signal
import subprocess
import sys
import time

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.experimental import EventsExecutor
from sensor_msgs.msg import JointState
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import nanoseconds, set_stamp
from vsa_joint.control.springs import Spring, tendon_travel
from vsa_joint.impedance.reflection import Impedance, Joint, TendonPath, virtual_work
from vsa_msgs.msg import EstimatorState, JointImpedance, StiffnessCommand, TransmissionImpedance

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 50) % 80
ENVIRONMENT = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
PERIOD = 0.01  # s
FORCE = 40.0  # N
SPRINGS = (Spring(0.0, math.log(267.2 * 0.776), 267.2, 16.39), Spring(0.0, math.log(165.6 * 7.031), 165.6, 8.269))
MOTORS = [tendon_travel(FORCE, spring.deflection(FORCE), 1e5) / 0.01 for spring in SPRINGS]


def start(module, *parameters):
    code = f"import sys; sys.argv[0] = '{module}'; from vsa_joint.{module} import main; sys.exit(main())"
    arguments = [word for given in parameters for word in ("-r" if given.startswith("__") else "-p", given)]
    command = [sys.executable, "-c", code, "--ros-args", *arguments]
    return subprocess.Popen(command, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)


class Lab:
    """Plays estimators and driver at rest under equal forces."""

    def __init__(self):
        self.processes = [start("joint"), start("stiffness_controller", "input_timeout:=0.08")]
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("lab", namespace="vsa", context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        publish = self.node.create_publisher
        self.impedance = [publish(TransmissionImpedance, f"transmission_{n}/impedance", RELIABLE) for n in (1, 2)]
        self.state = [publish(EstimatorState, f"transmission_{n}/estimator_state", RELIABLE) for n in (1, 2)]
        self.angle = publish(JointState, "joint_states", RELIABLE)
        self.motors = publish(JointState, "motor_states", RELIABLE)
        self.command = publish(StiffnessCommand, "stiffness_command", RELIABLE)
        self.joints, self.commands, self.said = [], [], []
        self.listen(JointImpedance, "joint_impedance", self.joints)
        self.listen(JointState, "motor_commands", self.commands)
        self.listen(DiagnosticStatus, "stiffness_controller/status", self.said)

    def listen(self, kind, topic, heard):
        self.node.create_subscription(kind, topic, lambda m: heard.append((time.monotonic(), m)), RELIABLE)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def wait(self, true, timeout=60.0, **what):
        end = time.monotonic() + timeout
        while not true():
            assert time.monotonic() < end, "timeout"
            self.feed(**what)

    def feed(self, sides=(0, 1), stiffness=None, delay=0.0):
        """One period of estimates (of `sides`) and measurements, `delay` s old. Returns their stamp [ns]."""
        stamp = time.time_ns() - int(delay * 1e9)
        for side in sides:
            message, spring = TransmissionImpedance(), SPRINGS[side]
            set_stamp(message.header.stamp, stamp)
            message.force, message.force_valid = FORCE + 1e-6 * (stamp % 1000), True
            message.stiffness, message.stiffness_variance = spring.stiffness(FORCE), 100.0
            message.damping, message.inertia, message.status = 4000.0, 0.3, TransmissionImpedance.VALID
            message.stiffness_valid = message.damping_valid = message.inertia_valid = True
            self.impedance[side].publish(message)
            state = EstimatorState(deflection_reference=0.0, ln_stiffness_reference=spring.ln_stiffness, k2=spring.k2)
            state.force_offset, state.k2_valid, state.d1, state.d2 = spring.force_offset, True, 4000.0, -1e8
            self.state[side].publish(state)
        angle = JointState(name=["joint"], position=[0.0])
        motors = JointState(name=["motor_1", "motor_2"], position=MOTORS)
        for publisher, message in ((self.angle, angle), (self.motors, motors)):
            set_stamp(message.header.stamp, stamp)
            publisher.publish(message)
        if stiffness is not None:
            self.command.publish(StiffnessCommand(stiffness=stiffness))
        self.spin(PERIOD)
        return stamp

    def run(self, seconds, **what):
        """Stamps of all periods [ns]."""
        return [self.feed(**what) for _ in range(round(seconds / PERIOD))]

    def close(self):
        for process in self.processes:
            process.send_signal(signal.SIGTERM)
        codes = [process.wait(10) for process in self.processes]
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        return codes


@pytest.fixture(scope="module")
def lab():
    lab = Lab()
    lab.wait(lambda: lab.joints and lab.joints[-1][1].stiffness_valid)
    lab.wait(lambda: lab.node.count_subscribers("/vsa/stiffness_command") and lab.joints[-1][1].stiffness_range_valid)
    yield lab
    assert lab.close() == [0, 0]


def joint_truth():
    sides = tuple(Impedance(spring.stiffness(FORCE), 4000.0, 0.3) for spring in SPRINGS)
    return virtual_work(sides, Joint((TendonPath(0.0215, 1e5), TendonPath(0.0215, 1e5)), 0.01, 1e-3))


def test_the_joint_carries_impedance_tension_range_and_both_stamps(lab):
    lab.run(0.2)
    last = lab.joints[-1][1]
    truth = joint_truth()
    assert (last.stiffness, last.damping, last.inertia) == pytest.approx(
        (truth.stiffness, truth.damping, truth.inertia), rel=1e-9
    )
    assert list(last.tension) == pytest.approx([20.0, 20.0], abs=1e-3)
    assert last.stiffness_min == pytest.approx(0.30, abs=0.01)
    assert last.stiffness_max > 7.0
    assert max(nanoseconds(stamp) for stamp in last.transmission_stamp) == nanoseconds(last.header.stamp)


def test_motors_that_are_nearly_wound_up_narrow_the_range(lab):
    widest = lab.joints[-1][1].stiffness_max
    narrow = start("joint", "motor_max:=3.0", "__node:=narrow")
    lab.joints.clear()
    lab.wait(lambda: any(m.stiffness_range_valid and m.stiffness_max < 0.9 * widest for _, m in lab.joints))
    narrow.send_signal(signal.SIGTERM)
    assert narrow.wait(10) == 0


def test_nothing_is_commanded_before_a_command_and_the_first_is_where_the_motors_are(lab):
    assert not lab.commands
    lab.wait(lambda: lab.commands, stiffness=joint_truth().stiffness)
    assert list(lab.commands[0][1].position) == pytest.approx(MOTORS, abs=0.02)


def test_what_cannot_be_reached_is_refused_with_the_range(lab):
    lab.run(0.2, stiffness=joint_truth().stiffness)
    lab.said.clear()
    lab.run(0.1, stiffness=50.0)
    refusals = [{v.key: v.value for v in m.values} for _, m in lab.said if "cannot be reached" in m.message]
    verdict = next(values for values in refusals if values.get("accepted") == "False")
    assert float(verdict["stiffness_max"]) < 8.0


def test_a_dead_estimator_makes_the_joint_invalid_and_the_motors_hold_in_time(lab):
    good = joint_truth().stiffness
    died = lab.run(1.0, stiffness=good)[-1]
    lab.joints.clear()
    lab.said.clear()
    lab.run(0.5, sides=(0,), stiffness=good)
    lab.wait(lambda: any(m.level == b"\x02" for _, m in lab.said), timeout=5.0, sides=(0,), stiffness=good)
    assert lab.joints[-1][1].reason == "transmission_2 silent"
    said = next(m for _, m in lab.said if m.level == b"\x02")
    held = int(next(value.value for value in said.values if value.key == "stamp_ns"))
    assert (held - died) * 1e-9 < 0.1
    assert said.message
    assert not any(m.stiffness_valid and nanoseconds(m.header.stamp) > died for _, m in lab.joints)
    assert list(lab.commands[-1][1].position) == pytest.approx(MOTORS)


def test_a_backlog_is_old_however_fast_it_comes(lab):
    lab.run(1.5, stiffness=joint_truth().stiffness)
    lab.spin(0.3)
    lab.said.clear()
    lab.run(0.3, stiffness=joint_truth().stiffness, delay=0.3)
    assert any("comes late" in m.message for _, m in lab.said)


def test_control_comes_back_with_the_estimator_and_stops_with_the_commands(lab):
    good = joint_truth().stiffness
    lab.said.clear()
    lab.run(1.5, stiffness=good)
    assert any(m.level == b"\x00" for _, m in lab.said)
    lab.said.clear()
    lab.run(1.0)
    assert any(m.message == "stiffness_command stopped" for _, m in lab.said)


@pytest.mark.parametrize(
    ("module", "parameter", "said"),
    [
        ("joint", "max_skew:=-1.0", "max_skew = -1.0 s"),
        ("joint", "radius:=[0.02]", "must be two numbers"),
        ("stiffness_controller", "rate:=0.0", "rate = 0.0 Hz"),
    ],
)
def test_a_bad_parameter_is_refused_in_one_line(module, parameter, said):
    process = start(module, parameter)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert said in errors
    assert "Traceback" not in errors
