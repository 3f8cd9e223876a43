"""Faults on one running suite: real processes, real CAN frames, real kills. Rows of docs/faults.md."""

import itertools
import resource
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from favour import RIG, favoured, with_weight
from geometry_msgs.msg import WrenchStamped
from host import undisturbed
from rcl_interfaces.srv import GetParameters
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from services import answer_of
from std_srvs.srv import SetBool
from vsa_common.io import bags
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.subprocesses import renice
from vsa_common.stamps import nanoseconds
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance
from vsa_msgs.srv import InjectFailure
from vsa_tools.demo.command import PROCESSES
from vsa_tools.demo.harness import ProcessHarness
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, write_parameters

pytestmark = pytest.mark.live

RATE = 250
VALID, STALE = TransmissionImpedance.VALID, TransmissionImpedance.STALE
NOTICED = 0.5  # s after a fault's end, within which an estimator is startled once more: an encoder jumps back
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


class Lab:
    """The suite on stage, and ears."""

    def __init__(self, stage, parameters, parts):
        self.stage, self.parameters, self.parts = stage, parameters, parts
        self.joints, self.sides, self.states = [], {1: [], 2: []}, {1: [], 2: []}
        self.said: dict[str, list] = {}
        listen = stage.node.create_subscription
        listen(JointImpedance, "joint_impedance", lambda m: self.joints.append((time.monotonic(), m)), RELIABLE)
        for i in (1, 2):
            side = f"transmission_{i}"
            listen(TransmissionImpedance, f"{side}/impedance", lambda m, i=i: self.heard(self.sides[i], m), RELIABLE)
            listen(EstimatorState, f"{side}/estimator_state", lambda m, i=i: self.heard(self.states[i], m), RELIABLE)
        listen(DiagnosticArray, "/diagnostics", self.on_diagnostics, RELIABLE)
        self.motors = []
        listen(JointState, "motor_states", self.motors.append, RELIABLE)
        self.commands = stage.node.create_publisher(JointState, "motor_commands", RELIABLE)
        self.commanding = self.broken = False
        self.over = 0.0  # when the last fault ends
        stage.node.create_timer(0.02, self.command)

    @staticmethod
    def heard(kept, message):
        kept.append((time.monotonic(), message))

    def on_diagnostics(self, message):
        for status in message.status:
            self.said.setdefault(status.name.rsplit("/", 1)[-1], []).append((time.monotonic(), status))

    def command(self):
        if self.commanding:
            sway = 0.1 * np.sin(2.0 * np.pi * np.array([0.3, 0.4]) * time.monotonic())
            self.commands.publish(JointState(name=["motor_1", "motor_2"], position=(0.5 + sway).tolist()))

    def until(self, true, seconds=30.0):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, {name: one[-1][1].message for name, one in self.said.items()}
            self.stage._executor.spin_once(timeout_sec=0.005)

    def call(self, kind, service, **fields):
        return answer_of(self.stage.node, self.until, kind, service, kind.Request(**fields))

    def arm(self):
        """Arm the driver, as soon as it hears of the motors."""
        self.motors.clear()
        self.until(lambda: self.motors)
        assert self.call(SetBool, "driver/arm", data=True).success

    def fail(self, words):
        """Inject a failure; the instant after which it can have begun, on both clocks [s]."""
        begin = time.monotonic()
        self.injected = time.time()
        assert self.call(InjectFailure, "rig_simulator/failure", failure=words).success
        self.over = time.monotonic() + float(words.partition("-t ")[2] or 0.0)
        return begin

    def told(self, node, words, since):
        """Whether a diagnostic of `node` since then has these words."""
        return any(words in status.message for at, status in self.said.get(node, []) if at >= since)

    def value(self, node, key):
        return next(item.value for item in self.said[node][-1][1].values if item.key == key)

    def well(self):
        """Whether joint and both sides are valid, by messages of the last moment."""
        now = time.monotonic()
        newest = [self.joints, *self.sides.values()]
        return all(m and now - m[-1][0] < 0.2 and m[-1][1].stiffness_valid and m[-1][1].status == VALID for m in newest)

    def relied_on(self):
        """Whether every sample that was heard of gave a valid stiffness; silence of a busy machine is none."""
        return all(m.stiffness_valid for side in self.sides.values() for _, m in side if m.status != STALE)

    def learned(self):
        """Whether both filters have taken over from the start-up: then they know the rig at rest, too."""
        return all(m[-1][1].damping_valid for m in self.sides.values())

    def restart(self, name):
        part = next(part for part in self.parts if part.name == name)
        self.stage.group.start(name, [*part.command(self.parameters), "-p", "autostart:=true"], part.nice)

    def settle(self):
        """Wait until no fault lasts, and all are well."""
        self.until(lambda: time.monotonic() > self.over + NOTICED)
        self.until(lambda: self.well() and self.learned(), 60.0)

    def recover(self):
        """Settle, and listen anew."""
        self.settle()
        self.clear()

    def clear(self):
        """Empty the ears."""
        for heard in (self.joints, *self.sides.values(), *self.states.values()):
            heard.clear()

    def kill(self, name):
        """kill -9, and listen until it is gone; the instant before."""
        begin = time.monotonic()
        self.stage.group[name].signal(signal.SIGKILL)
        self.until(lambda: self.stage.group[name].wait(0.0) is not None)
        self.stage.group._processes.pop(name)
        return begin


def first(heard, true, since):
    """When the first message since then for which something is true was heard."""
    return next((at for at, message in heard if at >= since and true(message)), None)


def is_stale(message):
    return message.status == STALE


def is_invalid(message):
    return not message.stiffness_valid


def stamp(message):
    """Instant that a message speaks of [s]."""
    return nanoseconds(message.header.stamp) * 1e-9


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("faults")


@pytest.fixture(scope="module")
def lab(folder):
    corner = claim_domain()
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={corner.bus_port}"]}
    run = {
        "rig_simulator": {"rate_hz": RATE, "autostart_clock": False, "bus": bus, **RIG},
        "driver": {"autostart": False, "bus": bus},
        "recorder": {"out": str(folder / "bag"), "flush_period": 0.2},
    }
    parameters = folder / "parameters.yaml"
    write_parameters(parameters, base_parameters(), run)
    with favoured() as nice, ProcessHarness(corner.environment(), folder / "logs") as stage:
        parts = with_weight(PROCESSES, nice)
        stage.start(parts, parameters)
        stage.wait_until_active(*(part.name for part in PROCESSES if part.name != "driver"))
        stage.activate("driver")
        stage.wait_until_connected()
        lab = Lab(stage, parameters, parts)
        stage.request("rig_simulator/start")
        lab.until(lambda: lab.well() and lab.learned(), 90.0)
        yield lab


@pytest.fixture
def healthy(lab):
    """The suite, valid all over, with its ears empty."""
    assert not lab.broken, "did not recover from an earlier test"
    lab.commanding, lab.broken = False, True
    lab.settle()
    lab.broken = False
    lab.clear()
    return lab


def test_one_sensor_that_stops_is_stale_then_invalid_and_resumes_by_itself(healthy):
    begin = healthy.fail("can_signal off -i 1 -t 0.8")
    side = healthy.sides[1]
    healthy.until(lambda: first(side, is_stale, begin))
    healthy.until(lambda: first(side, is_invalid, begin))
    healthy.until(lambda: first(healthy.joints, is_invalid, begin))
    stale, invalid = (next(i for i, (_, m) in enumerate(side) if true(m)) for true in (is_stale, is_invalid))
    last = stamp(side[stale - 1][1])
    assert stamp(side[stale][1]) - last < 0.0501  # longer than five periods
    assert stamp(side[invalid][1]) - last < 0.1001
    assert first(healthy.joints, is_invalid, begin) + (time.time() - time.monotonic()) - last < 0.1
    assert all(m.status == VALID for _, m in healthy.sides[2])
    variances = [m.stiffness_variance for _, m in side if m.status == STALE]
    assert variances[-1] > variances[0]
    healthy.until(lambda: healthy.told("driver", "no samples of transmission_1", begin))
    healthy.until(healthy.well)


@pytest.mark.parametrize("name", ["estimator_2", "joint"])
def test_a_node_that_is_killed_and_started_again_is_back_to_valid_and_the_others_live(healthy, name):
    def trial():
        begin = healthy.kill(name)
        if name != "joint":
            healthy.until(lambda: first(healthy.joints, is_invalid, begin))
        told = first(healthy.joints, is_invalid, begin)
        return told and told - begin, all(m.status == VALID for _, m in healthy.sides[1])

    def back():
        healthy.restart(name)
        healthy.until(healthy.well, 90.0)
        healthy.clear()

    delay, others_live = undisturbed(trial, back)
    assert name == "joint" or delay < 0.1
    assert others_live
    back()


@pytest.mark.parametrize(
    ("failure", "side", "words"),
    [
        ("encoder stuck -i 1 -t 0.6", 1, "encoder stuck"),
        ("force stuck -i 2 -t 1.2", 2, "force sensor stuck"),
        ("force saturated -i 1 -t 0.4", 1, "saturated"),
        ("encoder wrong -i 2 -v 0.002 -t 1", 2, "encoder step"),
    ],
)
def test_a_lying_sensor_is_named_and_the_estimate_recovers(healthy, failure, side, words):
    healthy.fail(failure)
    healthy.until(lambda: any(words in m.reason for _, m in healthy.states[side]))
    assert next(stamp(m) for _, m in healthy.states[side] if words in m.reason) - healthy.injected < 1.0
    assert all(not m.stiffness_valid or m.status != VALID for _, m in healthy.sides[side][-1:])
    healthy.until(healthy.well)


@pytest.mark.parametrize(
    ("failure", "words"),
    [
        ("force spike -i 1", "force_rejected"),
        ("encoder spike -i 2", "deflection_rejected"),
        ("can_signal duplicate -t 0.3", "duplicates"),
        ("can_signal intermittent -t 0.3", "lost"),
        ("can_signal garbage -i 2 -t 0.3", "wrong_length"),
        ("can_signal reordered -t 0.3", "late"),
    ],
)
def test_what_is_wrong_for_a_moment_is_counted_and_told_while_the_estimate_stays_valid(healthy, failure, words):
    def trial():
        begin = healthy.fail(failure)
        nodes = ("driver", "estimator_1", "estimator_2")
        healthy.until(lambda: any(healthy.told(node, words, begin) for node in nodes))
        return healthy.relied_on()

    relied_on = undisturbed(trial, healthy.recover)
    assert relied_on or "garbage" in failure  # then there is nothing to estimate from for as long
    healthy.until(healthy.well)


def test_a_late_joiner_hears_an_estimate_within_one_period_and_gets_parameters_and_status(healthy):
    heard, states = [], []
    node = healthy.stage.node
    subscriptions = [
        node.create_subscription(JointImpedance, "joint_impedance", lambda m: heard.append(time.monotonic()), RELIABLE),
        node.create_subscription(EstimatorState, "transmission_1/estimator_state", states.append, RELIABLE),
    ]
    healthy.until(lambda: len(heard) > 10 and states)
    assert sorted(b - a for a, b in itertools.pairwise(heard))[len(heard) // 2] < 2.5 / RATE
    assert states[0].status == VALID
    answer = healthy.call(GetParameters, "estimator_1/get_parameters", names=["initial.k2"])
    assert answer.values[0].double_value == 267.2
    for subscription in subscriptions:
        node.destroy_subscription(subscription)


def test_a_subscriber_with_another_policy_hears_or_the_diagnostics_name_the_policy(healthy):
    node, heard, begin = healthy.stage.node, [], time.monotonic()
    # An event that is still queued for what was destroyed ends the process: ros2/rclpy#1644.
    listen = partial(node.create_subscription, event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False))
    speak = partial(node.create_publisher, event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))
    best_effort = listen(JointImpedance, "joint_impedance", heard.append, BEST_EFFORT)
    healthy.until(lambda: heard)
    lasting = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    deaf = listen(JointImpedance, "joint_impedance", heard.append, lasting)
    healthy.until(lambda: healthy.told("joint", "durability", begin))
    unreliable = speak(WrenchStamped, "transmission_1/force", BEST_EFFORT)
    healthy.until(lambda: healthy.told("estimator_1", "reliability", begin))
    for entity, destroy in ((best_effort, node.destroy_subscription), (deaf, node.destroy_subscription)):
        destroy(entity)
    node.destroy_publisher(unreliable)


def test_a_starved_estimator_takes_the_newest_again_and_counts_what_it_missed(healthy):
    process = healthy.stage.group["estimator_1"]
    stopped = 6.0
    process.signal(signal.SIGSTOP)
    try:
        begin = time.monotonic()
        healthy.until(lambda: time.monotonic() - begin > stopped, stopped + 5.0)
        assert not healthy.joints[-1][1].stiffness_valid
    finally:
        process.signal(signal.SIGCONT)
    woken = time.monotonic()
    side = healthy.sides[1]
    healthy.until(lambda: side and time.time() - stamp(side[-1][1]) < 0.2 and healthy.well())
    assert time.monotonic() - woken < 5.0
    healthy.until(lambda: healthy.told("estimator_1", "resets", woken))


def test_one_busy_core_costs_no_validity(healthy):
    nice = healthy.parts[-1].nice
    busy = [sys.executable, "-c", "while True: pass"]

    def trial():
        hog = subprocess.Popen(busy, start_new_session=True, preexec_fn=lambda: renice(nice))
        try:
            begin = time.monotonic()
            healthy.until(lambda: time.monotonic() - begin > 2.0)
        finally:
            hog.kill()
            hog.wait()
        return [m.stiffness_valid for _, m in healthy.joints]

    valid = undisturbed(trial, healthy.recover)
    assert len(valid) > RATE
    assert sum(valid) > 0.9 * len(valid)


def test_a_full_disk_ends_the_recording_readable_and_touches_nobody_else(healthy, folder):
    recorder = healthy.stage.group["recorder"].pid
    size = (folder / "bag" / "bag.mcap").stat().st_size
    begin = time.monotonic()
    resource.prlimit(recorder, resource.RLIMIT_FSIZE, (size + 100_000, resource.RLIM_INFINITY))

    def trial():
        healthy.until(lambda: healthy.told("recorder", "readable", begin))
        told = time.time()
        healthy.until(lambda: healthy.joints and stamp(healthy.joints[-1][1]) > told + 0.5)
        return healthy.relied_on()

    assert undisturbed(trial, healthy.recover)
    healthy.until(healthy.well)
    assert sum(1 for _ in bags.read(folder / "bag", ["/vsa/joint_impedance"])) > RATE


def test_a_killed_driver_makes_the_joint_invalid_in_time_and_all_recovers_without_a_restart_of_others(healthy):
    others = {name: healthy.stage.group[name].pid for name in ("estimator_1", "estimator_2", "joint")}

    def command():
        healthy.arm()
        healthy.commanding = True
        healthy.until(lambda: int(healthy.value("rig_simulator", "commands")) > 0)

    def trial():
        begin = healthy.kill("driver")
        healthy.until(lambda: first(healthy.joints, is_invalid, begin))
        return first(healthy.joints, is_invalid, begin) - begin

    def back():
        healthy.restart("driver")
        healthy.until(healthy.well, 60.0)
        command()

    command()
    assert undisturbed(trial, back) < 0.1
    later = time.monotonic() + 0.3
    healthy.until(lambda: first(healthy.joints, lambda m: m.status == STALE, later))  # status goes on
    healthy.until(lambda: healthy.value("rig_simulator", "motors") == "holding")  # the device's watchdog
    begin = time.monotonic()
    healthy.restart("driver")
    healthy.until(healthy.well, 60.0)
    assert {name: healthy.stage.group[name].pid for name in others} == others
    healthy.until(lambda: healthy.told("driver", "", begin))
    assert healthy.value("driver", "motors") == "disarmed"


def test_bus_off_is_seen_reopened_in_the_same_process_and_commands_are_held_until_armed_again(healthy):
    driver = healthy.stage.group["driver"].pid
    healthy.arm()
    healthy.commanding = True
    begin = healthy.fail("can_signal bus_off -t 0.6")
    healthy.until(lambda: healthy.told("driver", "bus-off", begin))
    assert next(at for at, s in healthy.said["driver"] if at >= begin and "bus-off" in s.message) - begin < 1.0
    healthy.until(healthy.well)
    healthy.until(lambda: healthy.value("driver", "bus_reopened") != "0")
    assert healthy.value("driver", "motors") == "disarmed"
    assert healthy.stage.group["driver"].pid == driver
    healthy.until(lambda: healthy.value("rig_simulator", "motors") == "holding")
    healthy.arm()
    healthy.until(lambda: healthy.value("rig_simulator", "motors") == "moving")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_motors_and_ends_every_node_with_exit_code_0(lab, number):
    names = ("driver", "joint") if number == signal.SIGINT else ("estimator_1", "estimator_2", "rig_simulator")
    lab.call(SetBool, "driver/arm", data=True) if "driver" in names else None
    for name in names:
        lab.stage.group[name].signal(number)
    assert [lab.stage.group[name].wait(10.0) for name in names] == [0] * len(names)
    for name in names:
        assert "Traceback" not in lab.stage.group[name].log.read_text()
