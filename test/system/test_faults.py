# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults on one running suite: real processes, real CAN frames, real kills. Rows of docs/faults.md."""

import itertools
import resource
import signal
import subprocess
import sys
import time
from functools import partial

import pytest
from fault_lab import STALE, VALID, Lab, first, is_invalid, is_stale, stamp
from geometry_msgs.msg import WrenchStamped
from host import undisturbed
from priority import RIG, raised_priority, with_nice
from rcl_interfaces.srv import GetParameters
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import SetBool
from vsa_common.io import bags
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.subprocesses import renice
from vsa_msgs.msg import EstimatorState, JointImpedance
from vsa_tools.demo.command import PROCESSES
from vsa_tools.demo.harness import ProcessHarness
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, write_parameters

pytestmark = pytest.mark.live

RATE = 250
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("faults")


@pytest.fixture(scope="module")
def lab(folder):
    domain = claim_domain()
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={domain.bus_port}"]}
    run = {
        "rig_simulator": {"rate_hz": RATE, "autostart_clock": False, "bus": bus, **RIG},
        "driver": {"autostart": False, "bus": bus},
        "recorder": {"out": str(folder / "bag"), "flush_period": 0.2},
    }
    parameters = folder / "parameters.yaml"
    write_parameters(parameters, base_parameters(), run)
    with raised_priority() as nice, ProcessHarness(domain.environment(), folder / "logs") as harness:
        processes = with_nice(PROCESSES, nice)
        harness.start(processes, parameters)
        harness.wait_until_active(*(one.name for one in PROCESSES if one.name != "driver"))
        harness.activate("driver")
        harness.wait_until_connected()
        lab = Lab(harness, parameters, processes)
        harness.request("rig_simulator/start")
        lab.until(lambda: lab.all_valid() and lab.tracking(), 90.0)
        yield lab


@pytest.fixture
def healthy(lab):
    """The suite with valid estimates, all messages discarded."""
    assert not lab.broken, "did not recover from an earlier test"
    lab.commanding, lab.broken = False, True
    lab.settle()
    lab.broken = False
    lab.clear()
    return lab


def test_a_sensor_that_stops_is_stale_then_invalid_and_recovers(healthy):
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
    healthy.until(lambda: healthy.reported("driver", "transmission_1: no samples", begin))
    healthy.until(healthy.all_valid)


@pytest.mark.parametrize("name", ["estimator_2", "joint"])
def test_a_node_is_valid_after_a_restart_and_the_others_run_on(healthy, name):
    def trial():
        begin = healthy.kill(name)
        if name != "joint":
            healthy.until(lambda: first(healthy.joints, is_invalid, begin))
        invalid = first(healthy.joints, is_invalid, begin)
        return invalid and invalid - begin, all(m.status == VALID for _, m in healthy.sides[1])

    def back():
        healthy.restart(name)
        healthy.until(healthy.all_valid, 90.0)
        healthy.clear()

    delay, others_run = undisturbed(trial, back)
    assert name == "joint" or delay < 0.1
    assert others_run
    back()


@pytest.mark.parametrize(
    ("failure", "side", "text"),
    [
        ("encoder stuck -i 1 -t 0.6", 1, "encoder stuck"),
        ("force stuck -i 2 -t 1.2", 2, "force sensor stuck"),
        ("force saturated -i 1 -t 0.4", 1, "saturated"),
        ("encoder wrong -i 2 -v 0.002 -t 1", 2, "encoder step"),
    ],
)
def test_a_sensor_fault_is_named_and_the_estimate_recovers(healthy, failure, side, text):
    healthy.fail(failure)
    healthy.until(lambda: any(text in m.reason for _, m in healthy.states[side]))
    assert next(stamp(m) for _, m in healthy.states[side] if text in m.reason) - healthy.injected < 1.0
    assert all(not m.stiffness_valid or m.status != VALID for _, m in healthy.sides[side][-1:])
    healthy.until(healthy.all_valid)


@pytest.mark.parametrize(
    ("failure", "text"),
    [
        ("force spike -i 1", "force_rejected"),
        ("encoder spike -i 2", "deflection_rejected"),
        ("can_signal duplicate -t 0.3", "duplicates"),
        ("can_signal intermittent -t 0.3", "lost"),
        ("can_signal garbage -i 2 -t 0.3", "wrong_length"),
        ("can_signal reordered -t 0.3", "late"),
    ],
)
def test_a_transient_fault_is_counted_and_reported_while_the_estimate_stays_valid(healthy, failure, text):
    def trial():
        begin = healthy.fail(failure)
        nodes = ("driver", "estimator_1", "estimator_2")
        healthy.until(lambda: any(healthy.reported(node, text, begin) for node in nodes))
        return healthy.samples_valid()

    valid = undisturbed(trial, healthy.recover)
    assert valid or "garbage" in failure  # no sample is usable during garbage
    healthy.until(healthy.all_valid)


def test_a_late_subscriber_gets_an_estimate_within_one_period_and_parameters_and_status(healthy):
    arrivals, states = [], []
    node = healthy.harness.node
    subscriptions = [
        node.create_subscription(
            JointImpedance, "joint_impedance", lambda m: arrivals.append(time.monotonic()), RELIABLE
        ),
        node.create_subscription(EstimatorState, "transmission_1/estimator_state", states.append, RELIABLE),
    ]
    healthy.until(lambda: len(arrivals) > 10 and states)
    assert sorted(b - a for a, b in itertools.pairwise(arrivals))[len(arrivals) // 2] < 2.5 / RATE
    assert states[0].status == VALID
    answer = healthy.call(GetParameters, "estimator_1/get_parameters", names=["initial.k2"])
    assert answer.values[0].double_value == 267.2
    for subscription in subscriptions:
        node.destroy_subscription(subscription)


def test_a_subscriber_with_another_policy_receives_or_the_diagnostics_name_the_policy(healthy):
    node, received, begin = healthy.harness.node, [], time.monotonic()
    # A queued event of a destroyed endpoint ends the process: ros2/rclpy#1644.
    subscribe = partial(
        node.create_subscription, event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False)
    )
    advertise = partial(node.create_publisher, event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))
    best_effort = subscribe(JointImpedance, "joint_impedance", received.append, BEST_EFFORT)
    healthy.until(lambda: received)
    lasting = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    incompatible = subscribe(JointImpedance, "joint_impedance", received.append, lasting)
    healthy.until(lambda: healthy.reported("joint", "durability", begin))
    unreliable = advertise(WrenchStamped, "transmission_1/force", BEST_EFFORT)
    healthy.until(lambda: healthy.reported("estimator_1", "reliability", begin))
    for entity, destroy in ((best_effort, node.destroy_subscription), (incompatible, node.destroy_subscription)):
        destroy(entity)
    node.destroy_publisher(unreliable)


def test_a_suspended_estimator_resumes_with_the_newest_samples_and_counts_the_reset(healthy):
    process = healthy.harness.group["estimator_1"]
    stopped = 6.0
    process.signal(signal.SIGSTOP)
    try:
        begin = time.monotonic()
        healthy.until(lambda: time.monotonic() - begin > stopped, stopped + 5.0)
        assert not healthy.joints[-1][1].stiffness_valid
    finally:
        process.signal(signal.SIGCONT)
    resumed = time.monotonic()
    side = healthy.sides[1]
    healthy.until(lambda: side and time.time() - stamp(side[-1][1]) < 0.2 and healthy.all_valid())
    assert time.monotonic() - resumed < 5.0
    healthy.until(lambda: healthy.reported("estimator_1", "resets", resumed))


def test_one_busy_core_does_not_affect_validity(healthy):
    nice = healthy.processes[-1].nice
    busy = [sys.executable, "-c", "while True: pass"]

    def trial():
        load = subprocess.Popen(busy, start_new_session=True, preexec_fn=lambda: renice(nice))
        try:
            begin = time.monotonic()
            healthy.until(lambda: time.monotonic() - begin > 2.0)
        finally:
            load.kill()
            load.wait()
        return [m.stiffness_valid for _, m in healthy.joints]

    valid = undisturbed(trial, healthy.recover)
    assert len(valid) > RATE
    assert sum(valid) > 0.9 * len(valid)


def test_a_full_disk_ends_the_recording_readable_and_affects_no_other_node(healthy, folder):
    recorder = healthy.harness.group["recorder"].pid
    size = (folder / "bag" / "bag.mcap").stat().st_size
    begin = time.monotonic()
    resource.prlimit(recorder, resource.RLIMIT_FSIZE, (size + 100_000, resource.RLIM_INFINITY))

    def trial():
        healthy.until(lambda: healthy.reported("recorder", "readable", begin))
        reported = time.time()
        healthy.until(lambda: healthy.joints and stamp(healthy.joints[-1][1]) > reported + 0.5)
        return healthy.samples_valid()

    assert undisturbed(trial, healthy.recover)
    healthy.until(healthy.all_valid)
    assert sum(1 for _ in bags.read(folder / "bag", ["/vsa/joint_impedance"])) > RATE


def test_the_joint_is_invalid_in_time_after_the_driver_is_killed_and_recovers_with_it(healthy):
    others = {name: healthy.harness.group[name].pid for name in ("estimator_1", "estimator_2", "joint")}

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
        healthy.until(healthy.all_valid, 60.0)
        command()

    command()
    assert undisturbed(trial, back) < 0.1
    later = time.monotonic() + 0.3
    healthy.until(lambda: first(healthy.joints, lambda m: m.status == STALE, later))  # the status is still published
    healthy.until(lambda: healthy.value("rig_simulator", "motors") == "holding")  # the device's watchdog
    begin = time.monotonic()
    healthy.restart("driver")
    healthy.until(healthy.all_valid, 60.0)
    assert {name: healthy.harness.group[name].pid for name in others} == others
    healthy.until(lambda: healthy.reported("driver", "", begin))
    assert healthy.value("driver", "motors") == "disarmed"


def test_after_bus_off_the_same_process_reopens_the_bus_and_commands_need_arming(healthy):
    driver = healthy.harness.group["driver"].pid
    healthy.arm()
    healthy.commanding = True
    begin = healthy.fail("can_signal bus_off -t 0.6")
    healthy.until(lambda: healthy.reported("driver", "bus-off", begin))
    assert next(at for at, s in healthy.diagnostics["driver"] if at >= begin and "bus-off" in s.message) - begin < 1.0
    healthy.until(healthy.all_valid)
    healthy.until(lambda: healthy.value("driver", "reopened") != "0")
    assert healthy.value("driver", "motors") == "disarmed"
    assert healthy.harness.group["driver"].pid == driver
    healthy.until(lambda: healthy.value("rig_simulator", "motors") == "holding")
    healthy.arm()
    healthy.until(lambda: healthy.value("rig_simulator", "motors") == "moving")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_motors_and_ends_every_node_with_exit_code_0(lab, number):
    names = ("driver", "joint") if number == signal.SIGINT else ("estimator_1", "estimator_2", "rig_simulator")
    lab.call(SetBool, "driver/arm", data=True) if "driver" in names else None
    for name in names:
        lab.harness.group[name].signal(number)
    assert [lab.harness.group[name].wait(10.0) for name in names] == [0] * len(names)
    for name in names:
        assert "Traceback" not in lab.harness.group[name].log.read_text()
