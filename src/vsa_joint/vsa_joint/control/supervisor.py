# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Supervision of stiffness control: accepts commands, checks the inputs, and steps the control or holds the motors.

Instants are of a steady clock and are arguments.
"""

import math

from vsa_joint.control.controller import StiffnessControl
from vsa_joint.control.input_monitor import SECOND_NS, InputMonitor
from vsa_joint.control.mode import Mode, OperatingMode
from vsa_joint.control.records import Feasibility, Inputs, Measurement, Target
from vsa_joint.settings import ControlConfig
from vsa_joint.tuning import FOLLOWING_ERROR, FOLLOWING_TIMEOUT_NS


class Supervisor:
    """Motor positions for each control period, from commands and inputs."""

    def __init__(self, config: ControlConfig) -> None:
        self.control = StiffnessControl(config)
        self.reason = "no stiffness_command yet"
        self.refused = 0  # commands
        self.feasibility: Feasibility | None = None  # of the last command
        self.target: Target | None = None
        self._mode = OperatingMode()
        self._monitor = InputMonitor(config)
        self._command_timeout_ns = int(config.command_timeout * SECOND_NS)
        self._command_ns = 0
        self._sent: tuple[float, float] | None = None  # motor positions [rad]
        self._followed_ns = 0
        self._damping = 1.0  # N m s/rad, last valid

    def reconfigure(self, config: ControlConfig) -> None:
        """Apply the tunable parameters of another configuration, without a change of mode."""
        self.control.reconfigure(config)
        self._monitor.reconfigure(config)
        self._command_timeout_ns = int(config.command_timeout * SECOND_NS)

    @property
    def mode(self) -> Mode:
        """The operating mode."""
        return self._mode.mode

    def command(self, target: Target, inputs: Inputs, now_ns: int) -> Feasibility:
        """Accept or refuse a command; a refused one does not change the target."""
        self._command_ns = now_ns
        fault = self._monitor.fault(inputs, now_ns)
        measurement = None if fault else self._update_measurement(inputs)
        if measurement is None:
            feasibility = Feasibility(False, fault or "no estimate yet", None, math.inf)
        else:
            if self.mode is Mode.IDLE:
                self.control.engage(measurement)
            feasibility = self.control.check_command(target, measurement)
        self.feasibility = feasibility
        if feasibility.accepted:
            self.target = target
        elif measurement is not None:
            self.refused += 1
        return feasibility

    def step(self, inputs: Inputs, now_ns: int) -> tuple[float, float] | None:
        """Motor positions [rad] for this period; None before the first accepted command."""
        self._monitor.update(inputs, now_ns)
        if self.target is None:
            return None
        fault = self._update_fault(inputs, now_ns)
        measurement = self._update_measurement(inputs)
        if fault or measurement is None:
            self.reason = fault or "no estimate yet"
            self._mode.hold(inputs.motors if inputs.motors is not None else self._sent, now_ns)
            return self._mode.held
        if self.mode is not Mode.ACTIVE:
            engage = self._mode.needs_engagement(now_ns)
            if not self._mode.resume(now_ns):
                return self._mode.held
            if engage:
                self.control.engage(measurement)
            self._followed_ns = now_ns
        self.reason = self.feasibility.text if self.feasibility is not None else ""
        self._sent = self.control.step(self.target, measurement)
        return self._sent

    def _update_fault(self, inputs: Inputs, now_ns: int) -> str:
        fault = self._monitor.fault(inputs, now_ns)
        if not fault and now_ns - self._command_ns > self._command_timeout_ns:
            fault = "stiffness_command stopped"
        if not fault and self.mode is Mode.ACTIVE and not self._update_following(inputs, now_ns):
            fault = "motors do not follow: is the driver armed?"
        return fault

    def _update_following(self, inputs: Inputs, now_ns: int) -> bool:
        """Whether the motors are, or were within the timeout, close to their commanded positions."""
        if self._sent is None or inputs.motors is None:
            return True
        if max(abs(a - b) for a, b in zip(self._sent, inputs.motors, strict=True)) < FOLLOWING_ERROR:
            self._followed_ns = now_ns
        return now_ns - self._followed_ns <= FOLLOWING_TIMEOUT_NS

    def _update_measurement(self, inputs: Inputs) -> Measurement | None:
        joint, (first, second) = inputs.joint, inputs.springs
        if joint is None or inputs.motors is None or first is None or second is None:
            return None
        if joint.damping_valid:
            self._damping = joint.damping  # at speeds beyond the dampers' peak the last valid value applies
        return Measurement(inputs.angle, joint.tension, joint.stiffness, self._damping, inputs.motors, (first, second))
