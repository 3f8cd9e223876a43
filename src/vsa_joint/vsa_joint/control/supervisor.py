# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Supervision of stiffness control: accepts commands, checks the inputs, and steps the control or holds the motors.

While the stiffness is invalid without a sensor fault, control goes on with the last valid law, then re-excites both
transmissions. It also goes on with that law while an input comes late. Instants are of a steady clock and are
arguments.
"""

import math
from dataclasses import replace
from typing import NamedTuple

from vsa_common.stamps import NANOSECONDS
from vsa_joint.control.controller import StiffnessControl
from vsa_joint.control.input_monitor import MOTION, InputMonitor, invalidity
from vsa_joint.control.mode import Event, Mode, OperatingMode, Positions
from vsa_joint.control.records import Fault, Feasibility, Inputs, Measurement, Target
from vsa_joint.control.springs import Springs
from vsa_joint.control.stiffness_range import stiffness_at_forces
from vsa_joint.settings import ControlConfig
from vsa_joint.tuning import FOLLOWING_ERROR, FOLLOWING_TIMEOUT_NS, RECOVERY_NS

NO_RANGE = "no stiffness is within slack_margin, force_max and deflection_max"
BY_LAW = "a valid stiffness and recent inputs: control by the last valid law"
BY_EXCITATION = "a valid stiffness: the motors re-excite both transmissions"


class _Condition(NamedTuple):
    """Result of the checks of one control period."""

    event: Event
    reason: str = ""
    waits_for: str = ""


class Supervisor:
    """Motor positions for each control period, from commands and inputs."""

    def __init__(self, config: ControlConfig) -> None:
        self.control = StiffnessControl(config)
        self.reason = "no stiffness_command yet"
        self.waits_for = "stiffness_command"  # empty in mode ACTIVE
        self.refused = 0  # commands
        self.feasibility: Feasibility | None = None  # of the last command
        self.target: Target | None = None
        self.law_error = 0.0  # predicted relative error by the last valid law, while the stiffness is invalid
        self._mode = OperatingMode()
        self._monitor = InputMonitor(config)
        self._config = config
        self._command_ns = 0
        self._sent: Positions | None = None  # motor positions [rad]
        self._followed_ns = 0
        self._damping = 1.0  # N m s/rad, last valid
        self._law: Springs | None = None  # last valid
        self._law_ns = 0

    def reconfigure(self, config: ControlConfig) -> None:
        """Apply the tunable parameters of another configuration, without a change of mode."""
        self._config = config
        self.control.reconfigure(config)
        self._monitor.reconfigure(config)

    @property
    def mode(self) -> Mode:
        """The operating mode."""
        return self._mode.mode

    def duration(self, now_ns: int) -> float:
        """Time in the operating mode [s]."""
        return self._mode.duration(now_ns)

    def command(self, target: Target, inputs: Inputs, now_ns: int) -> Feasibility:
        """Accept or refuse a command; a refused one changes no target and ends no hold by a missing command."""
        fault = self._monitor.fault(inputs, self._law, now_ns)
        measurement = None if fault else self._update_measurement(inputs, now_ns)
        if measurement is None:
            feasibility = Feasibility(False, fault.text if fault else "no estimate yet", None, math.inf)
        else:
            if self.mode is Mode.IDLE:
                self.control.engage(measurement)
            feasibility = self.control.check_command(target, measurement)
            if feasibility.accepted and self.mode in (Mode.HOLDING, Mode.EXCITING):
                feasibility = replace(feasibility, text=f"pursued with {self.waits_for}")
        self.feasibility = feasibility
        if feasibility.accepted or not self._is_command_missing(now_ns):
            self._command_ns = now_ns
        if feasibility.accepted:
            self.target = target
        elif measurement is not None:
            self.refused += 1
        return feasibility

    def step(self, inputs: Inputs, now_ns: int) -> Positions | None:
        """Motor positions [rad] for this period; None before the first accepted command."""
        self._monitor.update(inputs, now_ns)
        if self.target is None:
            return None
        fault = self._fault(inputs, now_ns)
        measurement = None if fault else self._update_measurement(inputs, now_ns)
        condition = self._condition(self.target, fault, measurement, inputs, now_ns)
        controlled, engage = self._is_controlled, self._mode.needs_engagement(now_ns)
        positions = inputs.motors if self._monitor.has_motors(inputs, now_ns) else self._sent
        changed = self._mode.handle(condition.event, positions, now_ns)
        self._explain(condition)
        if self.mode is Mode.HOLDING or measurement is None:
            self._sent = self._mode.held or self._sent
            return self._mode.held
        if engage:
            self.control.engage(measurement)
        if not controlled:
            self._followed_ns = now_ns
        if changed and self.mode is Mode.EXCITING:
            self.control.start_excitation()
        if self.mode is Mode.EXCITING:
            self._sent = self.control.excite(measurement, self._sent or measurement.motors)
        else:
            self._sent = self.control.step(self.target, measurement, feedback=self.mode is Mode.ACTIVE)
        return self._sent

    @property
    def _is_controlled(self) -> bool:
        """Whether the motors have a moving set-point."""
        return self.mode not in (Mode.IDLE, Mode.HOLDING)

    def _is_command_missing(self, now_ns: int) -> bool:
        """Whether the last command, or its repetition, is older than its timeout."""
        return now_ns - self._command_ns > int(self._config.command_timeout * NANOSECONDS)

    def _explain(self, condition: _Condition) -> None:
        """State reason and end of the mode; a hold with healthy inputs keeps its reason."""
        if self.mode is Mode.ACTIVE:
            self.reason, self.waits_for = self.feasibility.text if self.feasibility is not None else "", ""
        elif self.mode is Mode.HOLDING and condition.event is not Event.FAULT:
            self.waits_for = f"inputs without a fault for up to {RECOVERY_NS / NANOSECONDS:g} s"
        else:
            self.reason, self.waits_for = condition.reason, condition.waits_for

    def _fault(self, inputs: Inputs, now_ns: int) -> Fault | None:
        fault = self._monitor.fault(inputs, self._law, now_ns)
        if fault is None and self._is_command_missing(now_ns):
            fault = Fault("stiffness_command stopped", "stiffness_command")
        if fault is None and self._is_controlled and not self._update_following(inputs, now_ns):
            fault = Fault("motors do not follow: is the driver armed?", "motors that follow their commands")
        return fault

    def _condition(
        self, target: Target, fault: Fault | None, measurement: Measurement | None, inputs: Inputs, now_ns: int
    ) -> _Condition:
        if fault is not None or measurement is None:
            fault = fault or Fault("no estimate yet", "an estimate of both transmissions")
            return _Condition(Event.FAULT, fault.text, fault.waits_for)
        if not self.control.has_range(measurement):
            return _Condition(Event.FAULT, NO_RANGE, "limits of force and deflection with a range")
        invalid, late = invalidity(inputs), self._monitor.lateness(inputs, now_ns)
        reason = invalid or (late.text if late else "")
        if not reason:
            self.law_error = 0.0
            return _Condition(Event.VALID)
        age = (now_ns - self._law_ns) / NANOSECONDS
        drift = self._config.law_drift * math.sqrt(age)
        self.law_error = math.hypot(self.control.predicted_error(target, measurement), drift)
        if self.law_error <= self._config.law_error_max:
            return _Condition(Event.TOLERABLE, reason, BY_LAW)
        if late is not None:
            return _Condition(Event.FAULT, late.text, late.waits_for)
        if self._config.recovery_amplitude > 0.0:
            return _Condition(Event.INVALID, reason, BY_EXCITATION)
        return _Condition(Event.FAULT, reason, f"{MOTION}; or set recovery_amplitude")

    def _update_following(self, inputs: Inputs, now_ns: int) -> bool:
        """Whether the motors are, or were within the timeout, close to their commanded positions."""
        if self._sent is None or inputs.motors is None:
            return True
        if max(abs(a - b) for a, b in zip(self._sent, inputs.motors, strict=True)) < FOLLOWING_ERROR:
            self._followed_ns = now_ns
        return now_ns - self._followed_ns <= FOLLOWING_TIMEOUT_NS

    def _update_measurement(self, inputs: Inputs, now_ns: int) -> Measurement | None:
        """The joint by its estimate, or by the last valid law where the stiffness is invalid."""
        joint, (first, second) = inputs.joint, inputs.springs
        if joint is None or inputs.motors is None:
            return None
        stiffness = joint.stiffness
        if joint.stiffness_valid and first is not None and second is not None:
            self._law, self._law_ns = (first, second), now_ns
        elif self._law is not None:
            forces = 2.0 * joint.tension[0], 2.0 * joint.tension[1]
            stiffness = stiffness_at_forces(forces, self._law, self.control.joint)
        if self._law is None:
            return None
        if joint.damping_valid:
            self._damping = joint.damping  # at speeds beyond the dampers' peak the last valid value applies
        return Measurement(
            inputs.angle, joint.tension, stiffness, self._damping, inputs.motors, self._law, joint.force_valid
        )
