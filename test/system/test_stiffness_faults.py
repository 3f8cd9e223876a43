"""Stiffness control on one running suite while sensors, an estimator and the commands fail: the motors hold."""

import signal
import time

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from favour import RIG, favoured, with_weight
from host import undisturbed
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
LEARNING = 14.0  # s of motion before the first command
RESUMING = 90.0  # s until control works again at most: what has queued up on a starved machine comes first
SOFT, STIFF, SWAY = 1.0, 1.4, 1.0  # N m/rad and s, commanded in turn, so that there is motion to stop
MOVED = 0.02  # rad between two commands that move the motors
CONTROLLER = ProcessSpec("stiffness_controller", "vsa_joint", "stiffness_controller")
SUITE = (*(part for part in PROCESSES if part.name != "recorder"), CONTROLLER)


class Lab:
    """The suite under stiffness control, and ears; instants of a steady clock."""

    def __init__(self, stage):
        self.stage, self.commanding = stage, False
        self.said, self.joints, self.motors = [], [], []
        listen = stage.node.create_subscription
        listen(DiagnosticStatus, "stiffness_controller/status", lambda m: self.said.append((now(), m)), RELIABLE)
        listen(JointImpedance, "joint_impedance", lambda m: self.joints.append((now(), m)), RELIABLE)
        listen(JointState, "motor_commands", lambda m: self.motors.append((now(), tuple(m.position))), RELIABLE)
        self.commands = stage.node.create_publisher(StiffnessCommand, "stiffness_command", RELIABLE)
        self.failure = stage.node.create_client(InjectFailure, "rig_simulator/failure")
        stage.node.create_timer(0.02, self.command, clock=STEADY)

    def command(self):
        if self.commanding:
            stiffness = SOFT if int(now() / SWAY) % 2 else STIFF
            self.commands.publish(StiffnessCommand(stiffness=stiffness))

    def until(self, true, seconds=20.0):
        end = now() + seconds
        while not true():
            assert now() < end, [status.message for _, status in self.said[-5:]]
            self.stage.spin(0.005)

    def works(self):
        """Whether control has said that it is active, and moved the motors since."""
        active = [at for at, status in self.said if status.message == "active"]
        held = [at for at, status in self.said if status.level == DiagnosticStatus.ERROR]
        return bool(active) and (not held or active[-1] > held[-1]) and now() - active[-1] > 1.5 * SWAY

    def resume(self):
        self.commanding = True
        self.until(self.works, RESUMING)
        self.said.clear()

    def fail(self, words):
        """Inject a failure; the instant before it can have begun."""
        self.until(self.failure.service_is_ready)
        begin = now()
        answer = self.failure.call_async(InjectFailure.Request(failure=words))
        self.until(answer.done)
        assert answer.result().success
        return begin

    def provoked(self, words):
        """As `judged` says of a failure."""
        return self.judged(lambda: self.held(self.fail(words)))

    def judged(self, trial):
        """Seconds until the controller said that the motors hold, and why; they must stand still from then on."""
        delay, reason, moved = undisturbed(trial, self.resume)
        assert moved < 1e-9
        return delay, reason

    def held(self, since):
        """Seconds until the motors hold, why, and how far they move after that [rad]."""
        self.until(lambda: any(status.level == DiagnosticStatus.ERROR for _, status in self.said))
        at, status = next((at, status) for at, status in self.said if status.level == DiagnosticStatus.ERROR)
        self.stage.spin(0.3)
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
    corner = claim_domain()
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={corner.bus_port}"]}
    run = {
        "rig_simulator": {"rate_hz": RATE, "autostart_clock": False, "bus": bus, **RIG},
        "driver": {"autostart": False, "bus": bus},
    }
    write_parameters(folder / "parameters.yaml", base_parameters(), run)
    with favoured() as nice, ProcessHarness(corner.environment(), folder / "logs") as stage:
        stage.start(with_weight(SUITE, nice), folder / "parameters.yaml")
        stage.wait_until_active(*(part.name for part in SUITE if part.name != "driver"))
        stage.activate("driver")
        lab = Lab(stage)
        stage.request("rig_simulator/start")
        stage.spin(LEARNING)
        lab.until(lambda: lab.joints and lab.joints[-1][1].stiffness_range_valid, RESUMING)
        assert answer_of(stage.node, lab.until, SetBool, "driver/arm", SetBool.Request(data=True)).success
        yield lab


@pytest.fixture
def control(lab):
    lab.resume()
    return lab


def test_control_moves_the_motors_and_says_what_it_could_not_reach(control):
    positions = [position[0] for _, position in control.motors[-100:]]
    assert max(positions) - min(positions) > MOVED
    control.commanding = False
    control.commands.publish(StiffnessCommand(stiffness=50.0))
    control.until(lambda: any("cannot be reached" in status.message for _, status in control.said))
    values = {v.key: v.value for _, status in control.said for v in status.values if "cannot" in status.message}
    assert values["accepted"] == "False"
    assert 0.2 < float(values["stiffness_min"]) < float(values["stiffness_max"]) < 9.0


def test_a_command_that_stops_stops_the_motors(control):
    def trial():
        control.commanding = False
        return control.held(now())

    delay, reason = control.judged(trial)
    assert reason == "stiffness_command stopped"
    assert 0.4 < delay < 0.55


@pytest.mark.parametrize("side", [1, 2])
def test_a_pulled_force_sensor_stops_the_motors_within_a_tenth_of_a_second(control, side):
    delay, reason = control.provoked(f"force off -i {side} -t 0.6")
    assert delay < 0.1
    assert f"transmission_{side}" in reason


def test_silent_frames_of_one_side_stop_the_motors_within_a_tenth_of_a_second(control):
    delay, reason = control.provoked("can_signal off -i 1 -t 0.6")
    assert delay < 0.1
    assert "transmission_1" in reason


@pytest.mark.parametrize("side", [1, 2])
def test_a_frozen_force_stops_the_motors_within_a_second(control, side):
    delay, reason = control.provoked(f"force stuck -i {side} -t 1.5")
    assert delay < 1.0
    assert f"transmission_{side}" in reason


def test_a_dead_estimator_stops_the_motors_within_a_tenth_of_a_second(control):
    since = now()
    process = control.stage.group[SUITE[1].name]
    process.signal(signal.SIGKILL)
    control.stage.group._processes.pop(SUITE[1].name)
    delay, reason, moved = control.held(since)
    assert moved < 1e-9
    assert SUITE[1].name == "estimator_2"
    assert delay < 0.1
    assert reason
    assert not control.joints[-1][1].stiffness_valid
    assert control.joints[-1][1].reason == "transmission_2 silent"
    process.wait(5.0)
