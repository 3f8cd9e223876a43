# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults of the inputs of stiffness control: timeouts, delays, validity, plausible forces."""

import math

from vsa_common.types import Status
from vsa_joint.control.records import Inputs, JointMeasurement
from vsa_joint.control.springs import Spring
from vsa_joint.settings import ControlConfig
from vsa_joint.tuning import (
    MAX_FUTURE_NS,
    MEASUREMENT_TIMEOUT_NS,
    MIN_TRANSMISSION_FORCE,
    OVERLOAD,
    STATE_TIMEOUT_NS,
)

SECOND_NS = 1_000_000_000


class InputMonitor:
    """Checks the inputs once per control period; instants are of a steady clock."""

    def __init__(self, config: ControlConfig) -> None:
        self.reconfigure(config)
        self._changed_ns = [0, 0]  # last change of each tension
        self._tension: tuple[float, float] = (math.nan, math.nan)

    def reconfigure(self, config: ControlConfig) -> None:
        """Apply the tunable parameters of another configuration."""
        self._config = config
        self._timeout_ns = int(config.input_timeout * SECOND_NS)
        self._period_ns = int(SECOND_NS / config.rate)

    def update(self, inputs: Inputs, now_ns: int) -> None:
        """Record the changes of the tensions; a sensor without noise is frozen."""
        if inputs.joint is None:
            return
        for index, (tension, before) in enumerate(zip(inputs.joint.tension, self._tension, strict=True)):
            if tension != before:
                self._changed_ns[index] = now_ns
        self._tension = inputs.joint.tension

    def fault(self, inputs: Inputs, now_ns: int) -> str:
        """Reason why control is not possible; empty without a fault."""
        joint = inputs.joint
        age = self._age_fault("joint_impedance", inputs.joint_ns, self._timeout_ns, inputs, now_ns)
        if joint is None or age:
            return format_fault(age or "joint_impedance silent", self._estimator_faults(inputs, now_ns))
        invalid = _validity_fault(joint)
        if invalid:
            return format_fault(invalid, inputs.estimator_faults)
        age = self._age_fault("joint_states", inputs.angle_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns)
        if not math.isfinite(inputs.angle) or age:
            return age or "joint_states silent"
        age = self._age_fault("motor_states", inputs.motors_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns)
        if inputs.motors is None or age:
            return age or "motor_states silent"
        for number, spring, arrival in zip((1, 2), inputs.springs, inputs.springs_ns, strict=True):
            name = f"transmission_{number}/estimator_state"
            age = self._age_fault(name, arrival, STATE_TIMEOUT_NS, inputs, now_ns)
            if spring is None or age:
                return age or f"{name} silent"
            fault = self._force_fault(number, 2.0 * joint.tension[number - 1], spring, now_ns)
            if fault:
                return fault
        return ""

    def _estimator_faults(self, inputs: Inputs, now_ns: int) -> tuple[str, str]:
        """Fault of each estimator; `silent` after half of the input timeout."""
        silent = ["silent" if 2 * (now_ns - arrival) > self._timeout_ns else "" for arrival in inputs.springs_ns]
        return inputs.estimator_faults[0] or silent[0], inputs.estimator_faults[1] or silent[1]

    def _age_fault(self, name: str, arrival_ns: int, timeout_ns: int, inputs: Inputs, now_ns: int) -> str:
        """Fault of an input that exceeds `timeout_ns` before the next period, by its arrival or by its stamp."""
        limit_ns = max(timeout_ns - self._period_ns, timeout_ns // 2)
        if now_ns - arrival_ns > limit_ns:
            return f"{name} silent"
        age_ns = now_ns - inputs.measured_ns.get(name, arrival_ns)
        if age_ns > limit_ns:
            return f"{name} comes late: more than {limit_ns // 1_000_000} ms old by its stamps"
        return f"{name} is stamped in the future: check the clock synchronization" if age_ns < -MAX_FUTURE_NS else ""

    def _force_fault(self, number: int, force: float, spring: Spring, now_ns: int) -> str:
        config = self._config
        # the damper of a shortening transmission bears a part of the force; no force at all is slack in any case
        if force < max(spring.slack_force - config.slack_margin, MIN_TRANSMISSION_FORCE):
            return f"transmission_{number} slack or its force sensor off: {force:.3g} N"
        if force > OVERLOAD * config.force_max:
            return f"transmission_{number} over its limit: {force:.3g} N"
        if config.frozen_timeout and now_ns - self._changed_ns[number - 1] > config.frozen_timeout * SECOND_NS:
            return f"force of transmission_{number} frozen at {force:.6g} N"
        return ""


def format_fault(fault: str, estimator_faults: tuple[str, str]) -> str:
    """A fault with the faults of the estimators in parentheses."""
    parts = [f"transmission_{number}: {text}" for number, text in enumerate(estimator_faults, 1) if text]
    return f"{fault} ({'; '.join(parts)})" if parts else fault


def _validity_fault(joint: JointMeasurement) -> str:
    if joint.status in (Status.STALE, Status.FAULT, Status.INITIALIZING) or not joint.stiffness_valid:
        return f"joint stiffness invalid: {joint.reason or Status(joint.status).name}"
    return "" if joint.force_valid else f"tension invalid: {joint.reason or 'force sensor fault'}"
