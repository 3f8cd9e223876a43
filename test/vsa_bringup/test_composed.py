# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Driver, estimators and joint in one process: estimates as in separate processes; two joints on one CAN FD bus."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
import rclpy
from cantools import database
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from std_srvs.srv import Trigger
from vsa_bringup import composed
from vsa_bringup.composed import MAX_CALLBACKS, BusSpinner, DirectDriver, nodes
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import nanoseconds
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.can.bus import BusConfig, open_bus
from vsa_estimator.node import EstimatorNode
from vsa_joint.node import JointNode
from vsa_msgs.msg import JointImpedance, TransmissionImpedance
from vsa_simulator.frames import RigFrames
from vsa_simulator.rig.config import RigConfig
from vsa_simulator.rig.rig import Rig

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 60) % 80
ENVIRONMENT = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
RATE_HZ, SAMPLES = 200, 500
SIDES = ("transmission_1", "transmission_2")
PORT = 44_000 + os.getpid() % 1000

# One CAN FD frame carries a sample of two joints, four transmissions.
FD_DBC = (
    """VERSION ""
BU_: Rig
BO_ 256 Sample: 24 Rig
"""
    + "".join(
        f' SG_ {name}Force : {40 * i}|24@1- (0.0001,0) [-838|838] "N" Rig\n'
        f' SG_ {name}Count : {40 * i + 24}|16@1+ (1,0) [0|65535] "" Rig\n'
        for i, name in enumerate(("Left1", "Left2", "Right1", "Right2"))
    )
    + ' SG_ Counter : 160|16@1+ (1,0) [0|65535] "" Rig\n'
)

NOTHING_ELSE = """
    joint: {angle_signal: "", torque_signal: "", counter_signal: ""}
    motors:
      position_signals: [""]
      command_signals: [""]
      holding_signal: ""
      counter_signal: ""
      command_counter_signal: ""
"""


def spin_until(executor: Executor, condition, timeout=40.0):
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "timeout"
        executor.spin_once(timeout_sec=0.01)


class Received:
    """Messages of the nodes in one namespace, by stamp."""

    def __init__(self, node, namespace):
        self.joints, self.impedances = {}, {name: {} for name in SIDES}
        self.listen(node, JointImpedance, f"/{namespace}/joint_impedance", self.joints)
        for name, kept in self.impedances.items():
            self.listen(node, TransmissionImpedance, f"/{namespace}/{name}/impedance", kept)

    @staticmethod
    def listen(node, kind, topic, kept):
        node.create_subscription(kind, topic, lambda m: kept.setdefault(nanoseconds(m.header.stamp), m), RELIABLE)


def assert_equal_messages(direct, separate):
    """Messages of the same stamps are equal; predictions on a busy machine have other stamps."""
    for side in SIDES:
        one, other = direct.impedances[side], separate.impedances[side]
        both = one.keys() & other.keys()
        assert len(both) > 0.9 * SAMPLES
        assert all(one[stamp] == other[stamp] for stamp in both)
    for received in (direct.joints, separate.joints):  # the first estimates depend on the order of the sides
        for stamp in [stamp for stamp, message in received.items() if "no sample yet" in message.reason]:
            del received[stamp]
    for stamp in (common := direct.joints.keys() & separate.joints.keys()):
        for message in (direct.joints[stamp], separate.joints[stamp]):
            message.stiffness_min = message.stiffness_max = 0.0  # computed ten times a second, by another timer
            message.stiffness_range_valid = False
        assert direct.joints[stamp] == separate.joints[stamp]
    assert len(common) > 0.9 * SAMPLES


@pytest.fixture
def ros():
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    sensors = [f"{side}/{topic}" for side in SIDES for topic in ("force", "encoder", "capture_counters")]
    remaps = [word for topic in sensors for word in ("-r", f"/apart/{topic}:=/together/{topic}")]
    bus = [
        "-p",
        "driver:bus.interface:=virtual",
        "-p",
        "driver:bus.options:=['']",
        "-p",
        "driver:bus.channel:=composed",
    ]
    rclpy.init(args=["--ros-args", *remaps, *bus], domain_id=DOMAIN)
    yield rclpy
    rclpy.try_shutdown()


def test_samples_passed_by_calls_give_the_same_estimates_as_samples_by_topics(ros):
    """The same samples, once by function calls, once through DDS to nodes that subscribe to the driver's topics."""
    together = nodes("together")
    apart = [EstimatorNode(f"estimator_{i}", "apart", transmission=side) for i, side in enumerate(SIDES, 1)]
    apart.append(JointNode("joint", "apart"))
    node, executor = rclpy.create_node("listener"), EventsExecutor()
    direct, separate = Received(node, "together"), Received(node, "apart")
    for one in [*apart, *together]:
        executor.add_node(one)
        one.autostart()
    executor.add_node(node)
    driver, estimator = together[-1], together[1]
    try:
        spin_until(
            executor, lambda: all(node.count_publishers(f"/{space}/joint_impedance") for space in ("together", "apart"))
        )
        spin_until(executor, lambda: node.count_subscribers("/together/transmission_2/encoder") == 1)
        rig, frames = Rig(RigConfig(rate_hz=RATE_HZ)), RigFrames(load_frames(driver.config.dbc))
        with open_bus(driver.config.bus) as bus:

            def send(count):
                first, _, readings = rig.advance(count)
                for k in range(count):
                    for side in range(2):
                        force, encoder = readings.forces[k, side], int(readings.counts[k, side])
                        frame = frames.transmission(side, first + k, force, encoder)
                        bus.send(frame.arbitration_id, frame.data)
                    due = time.monotonic() + 1.0 / RATE_HZ
                    while (left := due - time.monotonic()) > 0.0:
                        executor.spin_once(timeout_sec=left)

            send(SAMPLES)
            spin_until(executor, lambda: max(direct.joints) in separate.joints)
            assert_equal_messages(direct, separate)

            spin_until(executor, lambda: max(direct.joints) >= together[0]._fusion.newest.stamp_ns)  # none in transit
            estimator.trigger_deactivate()
            direct.joints.clear()
            send(20)
            spin_until(executor, lambda: direct.joints)
            assert not any(message.stiffness_valid or message.status == 2 for message in direct.joints.values())
            estimator.trigger_activate()
            before = len(direct.impedances[SIDES[0]])
            send(20)
            spin_until(executor, lambda: len(direct.impedances[SIDES[0]]) > before)
    finally:
        for one in [*reversed(together), *apart]:
            one.close()


@pytest.fixture
def two_joints(tmp_path):
    (tmp_path / "fd.dbc").write_text(FD_DBC)
    sections = ["/**/driver:\n  ros__parameters:\n    dbc: " + str(tmp_path / "fd.dbc") + NOTHING_ELSE]
    sections[0] += f"    bus: {{options: [hop_limit=0, port={PORT}]}}\n"
    for space in ("left", "right"):
        signals = [
            f"    transmission_{i}: {{force_signal: Sample.{space.title()}{i}Force, "
            f"encoder_signal: Sample.{space.title()}{i}Count, counter_signal: Sample.Counter}}\n"
            for i in (1, 2)
        ]
        sections.append(f"/{space}/driver:\n  ros__parameters:\n" + "".join(signals))
    (tmp_path / "two.yaml").write_text("".join(sections))
    command = [sys.executable, "-m", "vsa_bringup.composed", "--ros-args", "--params-file", str(tmp_path / "two.yaml")]
    process = subprocess.Popen(command, env=ENVIRONMENT)
    yield process, tmp_path / "fd.dbc"
    process.kill()
    process.wait()


def test_two_joints_on_one_can_fd_bus_need_one_parameter_file(two_joints):
    process, dbc = two_joints
    message = database.load_file(Path(dbc)).get_message_by_name("Sample")
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node, executor = rclpy.create_node("lab", context=context), EventsExecutor(context=context)
    executor.add_node(node)
    joints, health = {"left": [], "right": []}, {}
    for space, received in joints.items():
        node.create_subscription(JointImpedance, f"/{space}/joint_impedance", received.append, RELIABLE)
    node.create_subscription(
        DiagnosticArray, "/diagnostics", lambda m: health.update({s.name: s for s in m.status}), RELIABLE
    )
    number = 0
    with open_bus(BusConfig(options=("hop_limit=0", f"port={PORT}"))) as bus:

        def sample(forces=(20.0, 30.0, 60.0, 70.0)):
            nonlocal number
            values = {"Counter": number % 65536}
            for name, force in zip(("Left1", "Left2", "Right1", "Right2"), forces, strict=True):
                values |= {f"{name}Force": force, f"{name}Count": 500}
            bus.send(message.frame_id, message.encode(values), fd=True)
            number += 1

        def fed(condition):
            def step():
                sample()
                return condition()

            return step

        def tensions(space):
            return [list(joint.tension) for joint in joints[space][-1:]]

        tasks = ("driver: bus", "estimator_1: estimation", "estimator_2: estimation", "joint: impedance")
        expected = {f"/{space}/{task}" for space in joints for task in tasks}
        spin_until(executor, fed(lambda: expected <= health.keys() and all(joints.values())))
        spin_until(executor, fed(lambda: (tensions("left"), tensions("right")) == ([[10.0, 15.0]], [[30.0, 35.0]])))
        reset = node.create_client(Trigger, "/right/estimator_2/reset")
        spin_until(executor, fed(reset.service_is_ready))
        future = reset.call_async(Trigger.Request())
        spin_until(executor, fed(lambda: future.done() and joints["right"][-1].reset_count == 1))
        assert joints["left"][-1].reset_count == 0
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) == 0
    node.destroy_node()
    rclpy.shutdown(context=context)


def test_an_estimator_of_the_wrong_transmission_is_rejected_by_name(tmp_path):
    (tmp_path / "wrong.yaml").write_text("/**/estimator_2: {ros__parameters: {transmission: transmission_1}}\n")
    command = [
        sys.executable,
        "-m",
        "vsa_bringup.composed",
        "--ros-args",
        "--params-file",
        str(tmp_path / "wrong.yaml"),
    ]
    done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "[vsa.estimator_2]: transmission = 'transmission_1': must be transmission_2" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(("busy_s", "least"), [(0.0, 1), (0.005, 4)], ids=["idle", "busy"])
def test_after_a_long_turn_several_callbacks_are_served(busy_s, least):
    spins = []
    executor = SimpleNamespace(spin_once=lambda timeout_sec: spins.append(timeout_sec))
    turn = BusSpinner()
    turn(executor, [], 0.0)
    spins.clear()
    time.sleep(busy_s)  # a long turn of frames
    turn(executor, [], 0.0)
    assert least <= len(spins) <= MAX_CALLBACKS


@pytest.mark.parametrize(("allowed_s", "waited_s"), [(1.0, composed.WAIT_S), (0.0, 0.0)], ids=["asleep", "busy"])
def test_a_polling_turn_does_not_wait(monkeypatch, allowed_s, waited_s):
    waits = []
    monkeypatch.setattr(composed, "select", lambda *sets: waits.append(sets[3]) or ([], [], []))
    BusSpinner()(SimpleNamespace(spin_once=lambda timeout_sec: None), [], allowed_s)
    assert waits == [waited_s]


def test_a_turn_pauses_only_when_no_frame_is_left_to_read(monkeypatch):
    slept, found = [], [[7], [7], []]
    monkeypatch.setattr(composed, "select", lambda *_: (found.pop(0), [], []))
    monkeypatch.setattr(composed.time, "sleep", slept.append)
    monkeypatch.setattr(composed.Coalescer, "pause", lambda _: 0.004)
    turn = BusSpinner(0.004)
    for _ in range(3):
        turn(SimpleNamespace(spin_once=lambda timeout_sec: None), [], 1.0)
    assert (found, slept) == ([], [0.004])


class PendingEstimator:
    """An estimator with pending work."""

    def __init__(self, done, left):
        self.arrival_ns, self._done, self.left = 1_000, done, left

    def finish_pending(self):
        if self.left:
            self._done.append(self.left.pop(0))
            return True
        return False

    def predict_silence(self, silence_ns):
        self._done.append(silence_ns)


def test_between_two_samples_pending_work_is_done_step_by_step_before_predictions():
    done = []
    driver = SimpleNamespace(
        estimators={"1": PendingEstimator(done, ["step 1", "fit 1"]), "2": PendingEstimator(done, ["step 2"])}
    )
    for count in (1, 2, 3, 5):
        DirectDriver._on_idle(driver, 5_000)
        assert len(done) == count
    assert done == ["step 1", "fit 1", "step 2", 4_000, 4_000]
