# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The rig on a bus in real time: frames, commands, ground truth file."""

import csv
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from vsa_common.ros.diagnostics import ERROR, CounterDelta
from vsa_driver.can.bus import Bus, BusConfig, BusError, open_bus
from vsa_driver.can.frames import RIG_DBC, FrameSet
from vsa_simulator.frames import RigFrames
from vsa_simulator.ground_truth import HEADER, TruthFile
from vsa_simulator.loop import FrameDelays, RigLoop
from vsa_simulator.node import RigSimulatorNode
from vsa_simulator.rig.config import MotorConfig, RigConfig, SensorErrorConfig
from vsa_simulator.rig.rig import Rig

pytestmark = pytest.mark.live

FRAMES = FrameSet(RIG_DBC)
RATE = 500
BUS = BusConfig(channel="239.74.163.71", options=("hop_limit=0", "port=43871"))


def run(tmp_path, samples, during=lambda bus: None, sender=None, config=None):
    """Frames on the bus and rows of the truth file of a run of `samples` samples."""
    path, received = tmp_path / "truth.csv", []
    config = config or RigConfig(rate_hz=RATE)
    Rig(config).advance(1)
    with open_bus(BUS) as receiver:
        loop = RigLoop(Rig(config), sender or open_bus(BUS), RigFrames(FRAMES), 5, samples, TruthFile(path))
        loop.open()
        loop.start_clock()
        during(receiver)
        while not loop.done:
            frame = receiver.receive(0.1)
            if frame is not None:
                received.append(frame)
        loop.close()
        while (frame := receiver.receive(0.05)) is not None:
            received.append(frame)
    with path.open() as file:
        rows = list(csv.DictReader(file))
    return loop, received, rows


def decoded(received, name):
    message = FRAMES.message(name)
    return [message.decode(bytes(frame.data)) for frame in received if frame.arbitration_id == message.id]


@pytest.fixture(scope="module")
def quiet_run(tmp_path_factory):
    return run(tmp_path_factory.mktemp("rig"), 300)


def test_every_sample_has_a_frame_of_each_transmission_and_a_row_of_truth(quiet_run):
    loop, received, rows = quiet_run
    for name in ("Transmission1", "Transmission2"):
        assert [frame["RollingCounter"] for frame in decoded(received, name)] == list(range(300))
    assert [int(row["sample"]) for row in rows] == list(range(300))
    assert tuple(rows[0]) == HEADER
    assert (loop.sent, loop.done, loop.send_failures) == (300, True, 0)


def test_the_frames_carry_the_truth_within_sensor_noise(quiet_run):
    _, received, rows = quiet_run
    for side in (1, 2):
        frames = decoded(received, f"Transmission{side}")
        force = np.array([frame["Force"] for frame in frames]) - [float(row[f"force_{side}"]) for row in rows]
        deflection = np.array([frame["EncoderCount"] * 1e-5 for frame in frames])
        deflection -= [float(row[f"deflection_{side}"]) for row in rows]
        assert np.abs(force).max() < 5 * 0.017  # noise of the sensor
        assert np.abs(deflection).max() < 6e-5
    angles = [frame["Angle"] for frame in decoded(received, "Joint")]
    np.testing.assert_allclose(angles, [float(row["angle"]) for row in rows[::5]], atol=6e-4)
    motors = [frame["Position1"] for frame in decoded(received, "MotorState")]
    np.testing.assert_allclose(motors, [float(row["motor_1"]) for row in rows[::5]], atol=1e-5)


def test_the_frames_keep_the_rate(quiet_run):
    _, received, _ = quiet_run
    stamps = np.array([frame.timestamp for frame in received if frame.arbitration_id == 0x101])
    ideal = np.arange(300) / RATE
    assert np.median(stamps - stamps[0] - ideal) == pytest.approx(0.0, abs=0.02)


def test_frame_delays_are_uniform_and_the_same_for_a_seed():
    one, same, other = (FrameDelays(1e-3, seed) for seed in (1, 1, 2))
    draws = np.array([one.draw() for _ in range(5000)])
    assert draws.tolist() == [same.draw() for _ in range(5000)]
    assert draws[0] != other.draw()
    assert 0.0 <= draws.min() < 1e-5 < 9.9e-4 < draws.max() <= 1e-3
    assert (draws.mean(), draws.std()) == (pytest.approx(5e-4, rel=0.03), pytest.approx(1e-3 / 12**0.5, rel=0.03))


def test_with_jitter_the_frames_are_sent_later_by_these_delays(tmp_path, monkeypatch):
    slept = []
    monkeypatch.setattr("vsa_simulator.loop.FrameDelays.wait", lambda delays: slept.append(delays.draw()))
    config = RigConfig(rate_hz=RATE, seed=4, sensor_errors=SensorErrorConfig(frame_jitter=1e-3))
    _, received, _ = run(tmp_path, 50, config=config)
    expected = FrameDelays(1e-3, 4)
    assert slept == [expected.draw() for _ in range(50)]
    assert len(decoded(received, "Transmission1")) == 50


def test_a_command_from_the_bus_moves_the_motors_and_its_end_holds_them(tmp_path):
    command = FRAMES.message("MotorCommand")

    def during(bus):
        for number in range(3):
            bus.send(command.id, command.encode({"Position1": 2.5, "Position2": 1.0, "RollingCounter": number}))

    config = RigConfig(rate_hz=RATE, motors=MotorConfig(watchdog=0.2))
    loop, received, rows = run(tmp_path, 300, during, config=config)
    assert loop.commands == 3
    holding = [frame["WatchdogHolding"] for frame in decoded(received, "MotorState")]
    assert holding[0] == 0
    assert holding[-1] == 1
    assert float(rows[-1]["motor_1"]) == pytest.approx(2.5, abs=0.01)
    assert float(rows[-1]["motor_2"]) == pytest.approx(1.0, abs=0.01)


def test_a_command_frame_that_is_too_short_is_counted_and_ignored(tmp_path):
    loop, _, rows = run(tmp_path, 50, lambda bus: bus.send(0x200, b"\x01\x02"))
    assert (loop.commands, loop.bad_frames) == (0, 1)
    assert float(rows[-1]["motor_1"]) == pytest.approx(float(rows[0]["motor_1"]), abs=0.01)


class DeadBus(Bus):
    """A bus that fails to send and receive, as an interface that is down."""

    def __init__(self):
        self.name = "dead"

    def send(self, *_, **__):
        raise BusError("dead: bus-off")

    def receive(self, timeout=0.0):
        raise BusError("dead: bus-off")

    def close(self):
        pass


def test_failures_of_the_bus_are_counted_and_the_rig_continues(tmp_path):
    loop, received, rows = run(tmp_path, 50, sender=DeadBus())
    assert (len(rows), received) == (50, [])
    assert loop.send_failures == 2 * 50 + 2 * 10
    assert loop.reason == "dead: bus-off"


class FullDisk(TruthFile):
    """A truth file on a disk that is full after 20 rows."""

    def write(self, sample, row):
        if sample >= 20:
            raise OSError(28, "No space left on device")
        super().write(sample, row)


def test_a_failure_of_the_truth_file_ends_the_clock_and_is_named(tmp_path):
    loop = RigLoop(
        Rig(RigConfig(rate_hz=RATE)), open_bus(BUS), RigFrames(FRAMES), 5, None, FullDisk(tmp_path / "truth.csv")
    )
    loop.open()
    loop.start_clock()
    end = time.monotonic() + 20.0
    while not loop.failure and time.monotonic() < end:
        time.sleep(0.01)
    assert "No space left on device" in loop.failure
    assert not loop.running
    node = SimpleNamespace(_loop=loop, _delta=CounterDelta(), config=RigConfig(rate_hz=RATE))
    level, text, _ = RigSimulatorNode._simulation(node)
    assert level == ERROR
    assert "No space left on device" in text
    loop.close()


def test_the_clock_runs_from_its_start_to_its_stop(tmp_path):
    with TruthFile(tmp_path / "t.csv") as truth:
        loop = RigLoop(Rig(RigConfig(rate_hz=RATE)), open_bus(BUS), RigFrames(FRAMES), 5, None, truth)
        loop.open()
        assert (loop.running, loop.sent) == (False, 0)
        with open_bus(BUS) as receiver:
            loop.start_clock()
            assert receiver.receive(2.0) is not None
            loop.stop_clock()
        loop.close()
    assert not any(thread.name == "rig" for thread in threading.enumerate())
