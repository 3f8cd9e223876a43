# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The running suite in the tests of faults: its messages, injection of faults, kills and restarts."""

import signal
import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from services import answer_of
from std_srvs.srv import SetBool
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import nanoseconds
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance
from vsa_msgs.srv import InjectFailure

VALID, STALE = TransmissionImpedance.STATUS_VALID, TransmissionImpedance.STATUS_STALE
DETECTED = 0.5  # [s] after the end of a fault, for a second detection: the encoder steps back


class Lab:
    """The running suite, its messages with their times of arrival, and injection of faults."""

    def __init__(self, harness, parameters, processes):
        self.harness, self.parameters, self.processes = harness, parameters, processes
        self.joints, self.sides, self.states = [], {1: [], 2: []}, {1: [], 2: []}
        self.diagnostics: dict[str, list] = {}
        subscribe = harness.node.create_subscription
        subscribe(JointImpedance, "joint_impedance", lambda m: self.joints.append((time.monotonic(), m)), RELIABLE)
        for i in (1, 2):
            side = f"transmission_{i}"
            subscribe(TransmissionImpedance, f"{side}/impedance", lambda m, i=i: self.keep(self.sides[i], m), RELIABLE)
            subscribe(EstimatorState, f"{side}/estimator_state", lambda m, i=i: self.keep(self.states[i], m), RELIABLE)
        subscribe(DiagnosticArray, "/diagnostics", self.on_diagnostics, RELIABLE)
        self.motors = []
        subscribe(JointState, "motor_states", self.motors.append, RELIABLE)
        self.commands = harness.node.create_publisher(JointState, "motor_commands", RELIABLE)
        self.commanding = self.broken = False
        self.fault_end = 0.0  # of the last fault [s]
        harness.node.create_timer(0.02, self.command)

    @staticmethod
    def keep(kept, message):
        kept.append((time.monotonic(), message))

    def on_diagnostics(self, message):
        for status in message.status:
            node, _, task = status.name.rsplit("/", 1)[-1].partition(": ")
            status.message = f"{task}: {status.message}"
            self.diagnostics.setdefault(node, []).append((time.monotonic(), status))

    def command(self):
        if self.commanding:
            sway = 0.1 * np.sin(2.0 * np.pi * np.array([0.3, 0.4]) * time.monotonic())
            self.commands.publish(JointState(name=["motor_1", "motor_2"], position=(0.5 + sway).tolist()))

    def until(self, condition, seconds=30.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, {name: one[-1][1].message for name, one in self.diagnostics.items()}
            self.harness._executor.spin_once(timeout_sec=0.005)

    def call(self, kind, service, **fields):
        return answer_of(self.harness.node, self.until, kind, service, kind.Request(**fields))

    def arm(self):
        """Arm the driver after the first message of the motors."""
        self.motors.clear()
        self.until(lambda: self.motors)
        assert self.call(SetBool, "driver/arm", data=True).success

    def fail(self, failure):
        """Inject a failure; the instant before it [s], of the steady clock; `injected` is that of the system clock."""
        begin = time.monotonic()
        self.injected = time.time()
        assert self.call(InjectFailure, "rig_simulator/failure", failure=failure).success
        self.fault_end = time.monotonic() + float(failure.partition("-t ")[2] or 0.0)
        return begin

    def reported(self, node, text, since):
        """Whether a diagnostic of `node` since then contains the text."""
        return any(text in status.message for at, status in self.diagnostics.get(node, []) if at >= since)

    def value(self, node, key):
        statuses = (status for _, status in reversed(self.diagnostics[node]))
        return next(item.value for status in statuses for item in status.values if item.key == key)

    def all_valid(self):
        """Whether joint and both sides are valid, by messages not older than 0.2 s."""
        now = time.monotonic()
        newest = [self.joints, *self.sides.values()]
        return all(m and now - m[-1][0] < 0.2 and m[-1][1].stiffness_valid and m[-1][1].status == VALID for m in newest)

    def samples_valid(self):
        """Whether every sample gave a valid stiffness; predictions in silence do not count."""
        return all(m.stiffness_valid for side in self.sides.values() for _, m in side if m.status != STALE)

    def tracking(self):
        """Whether both filters have taken over from the initialization, so that damping is valid at rest as well."""
        return all(m[-1][1].damping_valid for m in self.sides.values())

    def restart(self, name):
        one = next(one for one in self.processes if one.name == name)
        self.harness.group.start(name, [*one.command(self.parameters), "-p", "autostart:=true"], one.nice)

    def settle(self):
        """Wait for the end of the last fault and for valid estimates."""
        self.until(lambda: time.monotonic() > self.fault_end + DETECTED)
        self.until(lambda: self.all_valid() and self.tracking(), 60.0)

    def recover(self):
        """Settle and discard all messages."""
        self.settle()
        self.clear()

    def clear(self):
        """Discard all messages."""
        for messages in (self.joints, *self.sides.values(), *self.states.values()):
            messages.clear()

    def kill(self, name):
        """Send SIGKILL and wait for the end of the process; the instant before [s]."""
        begin = time.monotonic()
        self.harness.group[name].signal(signal.SIGKILL)
        self.until(lambda: self.harness.group[name].wait(0.0) is not None)
        self.harness.group._processes.pop(name)
        return begin


def first(messages, condition, since):
    """Time of arrival of the first message since then that meets the condition; None without one."""
    return next((at for at, message in messages if at >= since and condition(message)), None)


def is_stale(message):
    return message.status == STALE


def is_invalid(message):
    return not message.stiffness_valid


def stamp(message):
    """Stamp of a message [s]."""
    return nanoseconds(message.header.stamp) * 1e-9
