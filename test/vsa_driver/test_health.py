# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Diagnostics of joint and motors by the frames of a rig; the steady clock is that of the test."""

from types import SimpleNamespace

import pytest
from vsa_common.ros.diagnostics import ERROR, OK, WARN
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.acquisition.router import Router
from vsa_driver.can.bus import Frame
from vsa_driver.health import DriverHealth
from vsa_driver.motors.motor import MotorGate, MotorLimits
from vsa_driver.settings import DriverSettings

LINK = SimpleNamespace(up=True, reason="", last_reason="", malformed=0, failures=0, reopened=0)
MESSAGES = {"joint": 0x110, "motors": 0x120}


class Rig:
    """Frames of joint and motors every 10 ms; `other_daq` has neither."""

    def __init__(self, monkeypatch, settings=None):
        self.now, self.count = 100.0, 0
        monkeypatch.setattr("vsa_driver.health.time", SimpleNamespace(monotonic=lambda: self.now))
        settings = settings or DriverSettings()
        self.router = Router(load_frames(settings.dbc), settings)
        self.gate = MotorGate(MotorLimits(-3.0, 8.0, 5.0, 0.2))
        self.health = DriverHealth(self.router, LINK, self.gate)

    def run(self, seconds, silent=(), holding=False):
        """Health of joint and motors at the end."""
        for _ in range(round(seconds * 100)):
            self.now += 0.01
            self.count += 1
            number = self.count.to_bytes(2, "little")
            data = {"joint": bytes(6) + number, "motors": bytes(6) + bytes([holding]) + number[:1]}
            for name, identifier in MESSAGES.items():
                if name not in silent:
                    frame = Frame(arbitration_id=identifier, is_extended_id=False, data=data[name])
                    self.router.add(frame, round(self.now * 1e9))
            if self.count % 20 == 0:
                self.tasks = self.health.assess((), 0, holding)
        return {name: self.tasks[name] for name in MESSAGES}


@pytest.fixture
def rig(monkeypatch):
    return Rig(monkeypatch)


@pytest.mark.parametrize("silent", ["joint", "motors"])
def test_silent_joint_or_motors_are_an_error_until_their_samples_return(rig, silent):
    assert {level for level, *_ in rig.run(2.0).values()} == {OK}
    tasks = rig.run(1.0, silent=(silent,))
    assert tasks[silent][:2] == (ERROR, "no samples")
    assert [level for name, (level, *_) in tasks.items() if name != silent] == [OK]
    assert rig.run(3.0)[silent][0] == OK


def test_joint_and_motors_that_never_send_are_an_error_within_a_second(rig):
    assert {level for level, *_ in rig.run(1.0, silent=MESSAGES).values()} == {ERROR}


def test_the_watchdog_of_silent_motors_is_unknown(rig):
    watchdog = [
        rig.run(1.0, holding=True)["motors"][2]["device_watchdog"],
        rig.run(1.0, silent=("motors",), holding=True)["motors"][2]["device_watchdog"],
        rig.run(1.0)["motors"][2]["device_watchdog"],
    ]
    assert watchdog == ["holding", "unknown", "fed"]


def test_a_controller_that_times_out_is_a_warning(rig):
    rig.run(2.0)
    rig.gate.update_position((0.0, 0.0), rig.now)
    rig.gate.arm(rig.now)
    assert rig.gate.step(rig.now + 0.3) is None
    level, text, values = rig.run(0.4)["motors"]
    assert (level, values["command_timeouts"]) == (WARN, 1)
    assert "command_timeouts +1" in text
    assert rig.run(2.0)["motors"][:2] == (OK, "holding")


def test_joint_and_motors_that_are_not_mapped_are_no_error(monkeypatch, other_daq):
    tasks = Rig(monkeypatch, other_daq).run(2.0)
    assert {name: health[:2] for name, health in tasks.items()} == dict.fromkeys(MESSAGES, (OK, "not mapped"))
