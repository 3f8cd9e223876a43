# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The driver as its own process, between real CAN frames on a multicast socket and a real ROS 2 subscriber."""

import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from driver_rig import BUS, OPTIONS, PORT, Rig, start_driver
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from std_srvs.srv import SetBool, Trigger
from vsa_common.ros.throttle import PERIOD_NS
from vsa_common.stamps import nanoseconds
from vsa_driver.can.frames import RIG_DBC

pytestmark = pytest.mark.live

NO_CAN = ("bus.interface:=socketcan", "bus.channel:=can_none", "bus.options:=['']")


@pytest.fixture(scope="module")
def driver():
    process = start_driver(OPTIONS, f"bus.channel:={BUS.channel}")
    yield process
    process.send_signal(signal.SIGINT)
    assert process.wait(10.0) == 0
    assert "Traceback" not in process.stderr.read()


@pytest.fixture(scope="module")
def rig(driver):
    rig = Rig()
    rig.until(
        lambda: all(rig.received.values()) and rig.arm.service_is_ready() and rig.tare.service_is_ready(),
        timeout=60.0,
    )
    yield rig
    rig.close()


@pytest.fixture
def fresh(rig):
    """The rig with empty lists of messages and disarmed motors."""
    rig.call(rig.arm, SetBool.Request(data=False))
    rig.serve(0.2)
    rig.sent_commands()
    for messages in rig.received.values():
        messages.clear()
    return rig


def test_every_sample_becomes_force_and_encoder_with_one_stamp_and_a_sequence_number(fresh):
    first = fresh.sequence + 1
    forces = [10.0 + 0.01 * i for i in range(400)]
    for i, force in enumerate(forces):
        fresh.sample(force, count=100 + i)
        fresh.serve(0.001)
    counters = fresh.received["transmission_1/capture_counters"]
    fresh.until(lambda: sum(len(message.counter) for message in counters) == len(forces), send=False)
    force, encoder = fresh.received["transmission_1/force"], fresh.received["transmission_1/encoder"]
    others = fresh.received["transmission_2/force"]
    fresh.until(
        lambda: min(map(len, (force, encoder, others))) == len(forces), send=False
    )  # a late one may arrive again
    stamps = [nanoseconds(message.header.stamp) for message in force]
    np.testing.assert_allclose([message.wrench.force.x for message in force], forces, atol=1e-9)
    np.testing.assert_allclose([message.position[0] for message in encoder], (101 + np.arange(400)) * 1e-5, atol=1e-9)
    np.testing.assert_allclose([message.wrench.force.x for message in others], 2 * np.array(forces))
    assert stamps == [nanoseconds(message.header.stamp) for message in encoder]
    assert np.all(np.diff(stamps) > 0)
    assert abs(stamps[-1] - time.time_ns()) < 5e9
    assert [nanoseconds(stamp) for message in counters for stamp in message.stamp] == stamps
    assert [n for message in counters for n in message.counter] == list(range(first, first + 400))
    assert {message.header.frame_id for message in force} == {"transmission_1"}


def test_joint_and_motors_are_published_in_si(fresh):
    fresh.until(lambda: all(fresh.received[topic] for topic in ("joint_states", "external_torque", "motor_states")))
    assert fresh.received["joint_states"][0].position[0] == pytest.approx(0.125)
    assert fresh.received["external_torque"][0].wrench.torque.z == pytest.approx(-0.75)
    motor = fresh.received["motor_states"][0]
    assert dict(zip(motor.name, motor.position, strict=True)) == pytest.approx({"motor_1": 0.5, "motor_2": -0.25})


def test_the_throttled_angle_has_one_message_per_period(fresh):
    fresh.until(lambda: len(fresh.received["joint_states_throttle"]) > 4)
    stamps = [nanoseconds(message.header.stamp) for message in fresh.received["joint_states_throttle"]]
    fresh.until(lambda: nanoseconds(fresh.received["joint_states"][-1].header.stamp) >= stamps[-1])
    assert set(stamps) <= {nanoseconds(message.header.stamp) for message in fresh.received["joint_states"]}
    assert len({stamp // PERIOD_NS for stamp in stamps}) == len(stamps)


def test_no_command_reaches_the_bus_before_arming_and_the_first_after_it_is_the_measured_position(fresh):
    for _ in range(20):
        fresh.command(0.5, 0.5)
        fresh.serve(0.01)
    assert fresh.sent_commands() == []
    answer = fresh.call(fresh.arm, SetBool.Request(data=True))
    assert answer.success, answer.message
    commands = []
    fresh.until(lambda: commands.extend(fresh.sent_commands()) or commands)
    assert commands[0] == pytest.approx((0.5, -0.25))


def test_an_armed_command_is_approached_at_the_speed_limit_and_an_invalid_one_is_refused(fresh):
    fresh.call(fresh.arm, SetBool.Request(data=True))
    commands, goal = [], (0.7, -0.3)
    end = time.monotonic() + 5.0
    while not commands or commands[-1] != pytest.approx(goal, abs=1e-5):
        assert time.monotonic() < end
        fresh.command(*goal)
        fresh.command(float("nan"), 0.0)
        fresh.command(11.0, 0.0)
        fresh.sample()
        fresh.serve(0.01)
        commands += fresh.sent_commands()
    assert commands[0][0] < goal[0]
    assert np.max(np.diff([one for one, _ in commands])) <= 5.0 * 0.2 + 1e-4
    assert all(0.5 - 1e-4 <= one <= 0.7 + 1e-4 for one, _ in commands)


def test_a_limit_of_the_motors_changes_while_active_and_a_signal_does_not(fresh):
    def change(name, **value):
        request = SetParameters.Request(parameters=[Parameter(name=name, value=ParameterValue(**value))])
        return fresh.call(setter, request).results[0]

    setter = fresh.node.create_client(SetParameters, "driver/set_parameters")
    fresh.until(setter.service_is_ready)
    fresh.call(fresh.arm, SetBool.Request(data=True))
    assert change("motors.position_max", type=2, integer_value=0).successful
    refused = fresh.count("motors.commands_refused")
    fresh.command(0.5, 0.5)
    fresh.until(lambda: fresh.count("motors.commands_refused") > refused)
    assert change("motors.position_max", type=3, double_value=8.0).successful
    result = change("motors.holding_signal", type=4, string_value="")
    assert not result.successful
    assert "ros2 lifecycle set /vsa/driver deactivate" in result.reason


def test_commands_end_when_the_controller_times_out(fresh):
    fresh.call(fresh.arm, SetBool.Request(data=True))
    fresh.until(fresh.sent_commands)
    timed_out_at = time.monotonic() + 0.6
    fresh.until(lambda: time.monotonic() > timed_out_at)
    fresh.sent_commands()
    end = time.monotonic() + 0.3
    fresh.until(lambda: time.monotonic() > end)
    assert fresh.sent_commands() == []


def test_tare_makes_a_constant_force_zero(fresh):
    steady = time.monotonic() + 1.5
    fresh.until(lambda: time.monotonic() > steady)
    fresh.until(lambda: fresh.call(fresh.tare, Trigger.Request()).success)  # again after a stall of this machine
    fresh.received["transmission_1/force"].clear()
    fresh.until(lambda: fresh.received["transmission_1/force"])
    assert fresh.received["transmission_1/force"][-1].wrench.force.x == pytest.approx(0.0, abs=1e-9)


def test_invalid_frames_are_counted_and_reported(fresh):
    fresh.until(lambda: len(fresh.reports) >= 1)
    names = ("bus.unmapped_frames", "transmission_1.wrong_length", "transmission_1.lost")
    before = {name: fresh.count(name) for name in names}
    for _ in range(7):
        fresh.bus.send(0x7AB, b"\x01")
    fresh.bus.send(0x101, b"\x01\x02\x03")
    fresh.sequence += 5
    fresh.until(
        lambda: (
            fresh.reports[-1].level == b"\x01" and fresh.count("transmission_1.lost") > before["transmission_1.lost"]
        )
    )
    fresh.until(lambda: fresh.count("bus.unmapped_frames") == before["bus.unmapped_frames"] + 7)
    assert fresh.count("transmission_1.wrong_length") == before["transmission_1.wrong_length"] + 1
    assert fresh.count("transmission_1.lost") == before["transmission_1.lost"] + 5


def test_a_flood_of_unmapped_and_malformed_frames_loses_no_sample(fresh):
    fresh.until(lambda: fresh.reports)
    before = {name: fresh.count(name) for name in ("bus.unmapped_frames", "bus.malformed", "transmission_1.lost")}
    fresh.received["transmission_1/force"].clear()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other_sender:
        other_sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        for i in range(200):
            fresh.sample()
            for k in range(20):  # five times the frames of a sample
                fresh.bus.send(0x400 + k, bytes(8))
            if i % 10 == 0:
                other_sender.sendto(b"no frame", (BUS.channel, PORT))
            fresh.serve(0.005)
    fresh.until(lambda: len(fresh.received["transmission_1/force"]) >= 200, send=False)
    fresh.until(lambda: fresh.count("bus.malformed") == before["bus.malformed"] + 20)
    fresh.until(lambda: fresh.count("bus.unmapped_frames") == before["bus.unmapped_frames"] + 4000)
    assert fresh.count("transmission_1.lost") == before["transmission_1.lost"]


def test_missing_samples_are_an_error_that_names_the_transmissions_and_clears_when_they_return(fresh):
    fresh.until(lambda: fresh.reports and fresh.reports[-1].level == b"\x02", send=False)
    tasks = fresh.reports[-1].tasks
    assert [tasks[name].message[:10] for name in ("transmission_1", "transmission_2")] == 2 * ["no samples"]
    fresh.until(lambda: fresh.reports[-1].tasks["bus"].level == b"\x00", send=False)
    fresh.until(lambda: fresh.reports[-1].level == b"\x00")


def test_a_failed_start_is_reported_in_one_line(tmp_path):
    dbc = tmp_path / "lacking.dbc"
    dbc.write_text(Path(RIG_DBC).read_text().replace("SG_ Force ", "SG_ Strain "))
    malformed = tmp_path / "malformed.yaml"
    malformed.write_text("driver:\n  ros__parameters:\n    dbc: [open\n")
    cases = {
        "transmission_1.force_signal": start_driver(OPTIONS, f"dbc:={dbc}"),
        "cannot open CAN bus socketcan": start_driver(*NO_CAN),
        "no such interface": start_driver("bus.interface:=nonsense"),
        "motors.speed_max = -1.0 rad/s": start_driver("motors.speed_max:=-1.0"),
        str(malformed): subprocess.Popen(
            [sys.executable, "-m", "vsa_driver.node", "--ros-args", "--params-file", str(malformed)],
            stderr=subprocess.PIPE, text=True,
        ),
    }  # fmt: skip
    for words, process in cases.items():
        _, error = process.communicate(timeout=60.0)
        assert process.returncode == 1
        assert words in error
        assert len(error.strip().splitlines()) == 1, error


def test_sigterm_ends_a_busy_driver_cleanly(rig):
    process = start_driver(OPTIONS, f"bus.channel:={BUS.channel}", "silence:=1.0")
    count = rig.node.count_publishers("/vsa/transmission_1/force")
    rig.until(lambda: rig.node.count_publishers("/vsa/transmission_1/force") > count, timeout=20.0)
    moment = time.monotonic() + 0.5
    rig.until(lambda: time.monotonic() > moment)
    process.terminate()
    rig.until(lambda: process.poll() is not None)
    assert process.returncode == 0
    log = process.stderr.read()
    assert "Traceback" not in log
    assert "active: CAN bus udp_multicast 239.74.163.88, transmission_1 and transmission_2, motor commands at" in log
