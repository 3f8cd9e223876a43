# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The action Excite and `./vsa excite` with the simulated rig on a CAN interface: from wrong start values to known."""

import signal
import subprocess
import time

import pytest
from priority import RIG, raised_priority, with_nice
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from services import answer_of
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.subprocesses import executable
from vsa_msgs.action import Excite
from vsa_msgs.msg import EstimatorState
from vsa_msgs.srv import InjectFailure
from vsa_simulator.rig.config import SecondTransmissionConfig, TransmissionConfig
from vsa_tools.demo.harness import ProcessHarness, ProcessSpec
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, perturbed_initial_values, write_parameters

pytestmark = pytest.mark.live

RATE = 200
SEED = 4
CORE = ("estimator_1", "estimator_2", "joint", "driver")
SUITE = (
    ProcessSpec("composed", "vsa_bringup", "composed", nodes=CORE),
    ProcessSpec("rig_simulator", "vsa_simulator", "rig_simulator"),
    ProcessSpec("excitation", "vsa_joint", "excitation"),
)
TRUTH = {"transmission_1": TransmissionConfig(), "transmission_2": SecondTransmissionConfig()}
SHORT, LONG = 30.0, 90.0  # [s] limits for an answer and for a run, on a machine under full load


class Lab:
    """The running suite with its motor commands and motor positions."""

    def __init__(self, harness, environment):
        self.harness, self.node, self.environment = harness, harness.node, environment
        self.commands, self.motors, self.states = [], [], []
        self.node.create_subscription(JointState, "motor_commands", self.commands.append, RELIABLE)
        self.node.create_subscription(JointState, "motor_states", self.motors.append, RELIABLE)
        self.node.create_subscription(EstimatorState, "transmission_1/estimator_state", self.states.append, RELIABLE)
        self.publisher = self.node.create_publisher(JointState, "motor_commands", RELIABLE)
        self.client = ActionClient(self.node, Excite, "excitation/excite")
        self.feedback = []

    def until(self, condition, seconds=SHORT):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, self.states[-1:]
            self.harness.spin(0.02)

    def arm(self, armed):
        assert answer_of(self.node, self.until, SetBool, "driver/arm", SetBool.Request(data=armed)).success

    def begin(self, **goal):
        """Handle of an accepted goal."""
        self.feedback.clear()
        self.until(self.client.server_is_ready)
        keep = lambda message: self.feedback.append(message.feedback)  # noqa: E731
        future = self.client.send_goal_async(Excite.Goal(**goal), feedback_callback=keep)
        self.until(future.done)
        assert future.result().accepted
        return future.result()

    def result(self, handle):
        future = handle.get_result_async()
        self.until(future.done, LONG)
        return future.result().result

    def moving(self):
        """Whether a motion is chosen and the motors have moved since the last start."""
        return bool(self.feedback) and " Hz" in self.feedback[-1].motion

    def command_line(self, *arguments):
        command = [executable("vsa_joint", "excite"), *arguments]
        return subprocess.Popen(
            command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def quiet(self):
        """Motor commands have ended; those in transit are received first."""
        self.harness.spin(0.5)
        self.commands.clear()
        self.harness.spin(0.5)
        assert self.commands == []

    def move_to(self, goal, seconds=2.0):
        """Command the motors along a straight line to the positions `goal` [rad]; then they are free again."""
        names, start, begin = self.motors[-1].name, list(self.motors[-1].position), time.monotonic()

        def command():
            share = min((time.monotonic() - begin) / seconds, 1.0)
            position = [one + share * (other - one) for one, other in zip(start, goal, strict=True)]
            header = Header(stamp=self.node.get_clock().now().to_msg())
            self.publisher.publish(JointState(header=header, name=names, position=position))

        timer = self.node.create_timer(0.02, command)
        self.until(lambda: list(self.motors[-1].position) == pytest.approx(goal, abs=0.005))
        timer.cancel()
        self.node.destroy_timer(timer)
        self.harness.spin(1.2)

    def output(self, process):
        """Output of a command line at its end."""
        self.until(lambda: process.poll() is not None, LONG)
        return process.communicate()[0]


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("excitation")
    domain = claim_domain()
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={domain.bus_port}"]}
    rig = base_parameters()["rig_simulator"]
    rig = {**rig, "rate_hz": RATE, "profile": {**rig["profile"], "kind": "hold"}}
    run = {
        "rig_simulator": {**rig, "autostart_clock": False, "bus": bus, **RIG},
        "driver": {"autostart": False, "bus": bus, "motors": {"command_rate": float(RATE)}},
        "excitation": {"input_timeout": 1.0},  # of a machine under full load
    }
    write_parameters(folder / "parameters.yaml", base_parameters(), run, perturbed_initial_values(rig, SEED))
    environment = domain.environment()
    with raised_priority() as nice, ProcessHarness(environment, folder / "logs") as harness:
        harness.start(with_nice(SUITE, nice), folder / "parameters.yaml")
        harness.wait_until_active(*CORE[:-1], "rig_simulator", "excitation")
        harness.activate("driver")
        lab = Lab(harness, environment)
        harness.request("rig_simulator/start")
        lab.until(lambda: lab.motors)
        yield lab


@pytest.fixture
def armed(lab):
    """A repeated trial has a new suite: each test arms."""
    lab.arm(True)
    return lab


def test_a_disarmed_driver_ends_the_run_with_the_reason(lab):
    lab.arm(False)
    result = lab.result(lab.begin())
    assert not result.success
    assert "motors do not follow: is the driver armed?" in result.message
    lab.quiet()


def test_all_wanted_quantities_become_known_from_wrong_start_values(armed):
    armed.motors.clear()
    process = armed.command_line("--duration", "60")
    text = armed.output(process)
    assert process.returncode == 0, text
    assert "all wanted quantities are known after" in text
    assert text.count("known after") == 2  # the title of the column and the sentence
    armed.until(lambda: armed.motors)
    travels = [
        max(one.position[i] for one in armed.motors) - min(one.position[i] for one in armed.motors) for i in (0, 1)
    ]
    assert 0.2 < max(travels) < 2 * (0.0035 + 0.001) * 2 / 0.010  # [rad], of the motion to both sides
    armed.quiet()


def test_the_known_values_are_those_of_the_rig(armed):
    result = armed.result(armed.begin())
    assert result.success
    assert len(result.quantities) == 8
    for one in result.quantities:
        truth = TRUTH[one.transmission]
        expected = {"k2": truth.k2, "damping": truth.d1, "d2": truth.d2}.get(one.quantity)
        assert one.known
        assert 0.0 <= one.known_after <= result.elapsed
        if expected is not None:
            assert one.value == pytest.approx(expected, rel=0.1)


def test_a_canceled_run_stops_the_motors(armed):
    handle = armed.begin(quantities=["inertia"])
    armed.until(armed.moving)
    cancelation = handle.cancel_goal_async()
    armed.until(cancelation.done)
    result = armed.result(handle)
    assert result.message.startswith("canceled after")
    assert not result.success
    armed.quiet()


def test_an_interrupt_of_the_command_line_cancels(armed):
    armed.commands.clear()
    process = armed.command_line("--quantity", "inertia")
    armed.until(lambda: len(armed.commands) > 50)
    process.send_signal(signal.SIGINT)
    text = armed.output(process)
    assert process.returncode == 130, text
    assert "canceled after" in text
    armed.quiet()


def test_a_lost_sensor_stops_the_motors(armed):
    assert armed.result(armed.begin()).success  # a repeated trial has a new suite: its stiffness is not known yet
    known = list(armed.motors[-1].position)
    handle = armed.begin(quantities=["inertia"])
    armed.until(armed.moving)
    request = InjectFailure.Request(failure="force off -i 1 -t 4")
    assert answer_of(armed.node, armed.until, InjectFailure, "rig_simulator/failure", request).success
    result = armed.result(handle)
    assert result.message.startswith("stopped after")
    assert "transmission_1" in result.message
    armed.quiet()
    armed.move_to(known)  # the motors may have stopped in a part of the stroke that no valid force has been measured in
    armed.states.clear()
    armed.until(lambda: armed.states and armed.states[-1].status == EstimatorState.STATUS_VALID)


def test_an_active_controller_is_not_disturbed(armed):
    position = list(armed.motors[-1].position)
    timer = armed.node.create_timer(0.02, lambda: armed.publisher.publish(JointState(position=position)))
    armed.harness.spin(0.5)
    result = armed.result(armed.begin())
    assert result.message == "refused: harness commands the motors"
    timer.cancel()
    armed.node.destroy_timer(timer)
    armed.harness.spin(1.2)


def test_a_second_goal_and_a_bad_goal_are_refused(armed):
    first = armed.begin(quantities=["inertia"])
    armed.until(armed.moving)
    second = armed.begin()
    assert armed.result(second).message == "refused: another excitation is running"
    first.cancel_goal_async()
    assert armed.result(first).message.startswith("canceled")
    assert armed.result(armed.begin(quantities=["mass"])).message.startswith("refused: no quantity mass")
    assert armed.result(armed.begin(travel=-1.0)).message.startswith("refused: travel = -1")


def test_a_quantity_that_the_duration_does_not_suffice_for_is_reported(armed):
    assert answer_of(armed.node, armed.until, Trigger, "estimator_1/reset", Trigger.Request()).success
    process = armed.command_line("--quantity", "k2", "inertia", "--duration", "1.5")
    text = armed.output(process)
    assert process.returncode == 1, text
    assert "not known after 1.5 s" in text
    assert "inertia of transmission_1 (not observable at this excitation" in text
