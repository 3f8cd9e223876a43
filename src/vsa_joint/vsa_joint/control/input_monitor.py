# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults of the inputs of stiffness control: timeouts, delays, validity, plausible forces."""

import math

from vsa_common.stamps import NANOSECONDS
from vsa_common.types import Status
from vsa_joint.control.records import Fault, Inputs, JointMeasurement
from vsa_joint.control.springs import Spring, Springs
from vsa_joint.settings import ControlConfig
from vsa_joint.tuning import (
    LAW_TIMEOUT_NS,
    MAX_FUTURE_NS,
    MEASUREMENT_TIMEOUT_NS,
    MIN_TRANSMISSION_FORCE,
    OVERLOAD,
    STATE_TIMEOUT_NS,
)

MOTION = "a valid stiffness: move the joint by hand against both springs, over a millimetre of deflection or more"


class InputMonitor:
    """Checks the inputs once per control period; instants are of a steady clock."""

    def __init__(self, config: ControlConfig) -> None:
        self.reconfigure(config)
        self._changed_ns = [0, 0]  # last change of each tension
        self._tension: tuple[float, float] = (math.nan, math.nan)

    def reconfigure(self, config: ControlConfig) -> None:
        """Apply the tunable parameters of another configuration."""
        self._config = config
        self._timeout_ns = int(config.input_timeout * NANOSECONDS)
        self._period_ns = int(NANOSECONDS / config.rate)

    def update(self, inputs: Inputs, now_ns: int) -> None:
        """Record the changes of the tensions; a sensor without noise is frozen."""
        if inputs.joint is None:
            return
        for index, (tension, before) in enumerate(zip(inputs.joint.tension, self._tension, strict=True)):
            if tension != before:
                self._changed_ns[index] = now_ns
        self._tension = inputs.joint.tension

    def fault(self, inputs: Inputs, law: Springs | None, now_ns: int) -> Fault | None:
        """Why control is not possible; None without a fault.

        `law` is the last valid one. With it a stiffness that is invalid without a sensor fault is none (`invalidity`),
        nor is an input that is too old for feedback (`lateness`) up to STATE_TIMEOUT_NS.
        """
        joint, by_stamp_ns = inputs.joint, 0 if law is None else STATE_TIMEOUT_NS
        age = self._age_fault("joint_impedance", inputs.joint_ns, self._timeout_ns, inputs, now_ns, by_stamp_ns)
        if joint is None or age:
            faults = self._estimator_faults(inputs, now_ns)
            age = age or Fault("joint_impedance silent", "joint_impedance")
            return Fault(format_fault(age.text, faults), age.waits_for)
        invalid = _validity_fault(joint, any(inputs.sensor_faults), law is not None)
        if invalid is not None:
            return Fault(format_fault(invalid.text, inputs.estimator_faults), invalid.waits_for)
        age = self._age_fault("joint_states", inputs.angle_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns, by_stamp_ns)
        if not math.isfinite(inputs.angle) or age:
            return age or Fault("joint_states silent", "joint_states")
        age = self._age_fault("motor_states", inputs.motors_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns, by_stamp_ns)
        if inputs.motors is None or age:
            return age or Fault("motor_states silent", "motor_states")
        springs, state_timeout_ns = inputs.springs, LAW_TIMEOUT_NS
        if not joint.stiffness_valid:  # the states contain the faults of the sensors
            springs, state_timeout_ns = law or springs, STATE_TIMEOUT_NS
        for number, spring, arrival in zip((1, 2), springs, inputs.springs_ns, strict=True):
            name = f"transmission_{number}/estimator_state"
            age = self._age_fault(name, arrival, state_timeout_ns, inputs, now_ns)
            if spring is None or age:
                return age or Fault(f"{name} silent", name)
            force = self._force_fault(number, 2.0 * joint.tension[number - 1], spring, now_ns)
            if force:
                return Fault(force, f"a plausible force of transmission_{number}")
        return None

    def has_motors(self, inputs: Inputs, now_ns: int) -> bool:
        """Whether the measured motor positions are present and within their timeout."""
        late = self._age_fault("motor_states", inputs.motors_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns)
        return inputs.motors is not None and late is None

    def lateness(self, inputs: Inputs, now_ns: int) -> Fault | None:
        """The first input that is too old for feedback, by its stamp; None without one."""
        age = self._age_fault("joint_impedance", inputs.joint_ns, self._timeout_ns, inputs, now_ns)
        if age is not None:
            return Fault(format_fault(age.text, self._estimator_faults(inputs, now_ns)), age.waits_for)
        age = self._age_fault("joint_states", inputs.angle_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns)
        return age or self._age_fault("motor_states", inputs.motors_ns, MEASUREMENT_TIMEOUT_NS, inputs, now_ns)

    def _estimator_faults(self, inputs: Inputs, now_ns: int) -> tuple[str, str]:
        """Fault of each estimator; `silent` after half of the input timeout."""
        silent = ["silent" if 2 * (now_ns - arrival) > self._timeout_ns else "" for arrival in inputs.springs_ns]
        return inputs.estimator_faults[0] or silent[0], inputs.estimator_faults[1] or silent[1]

    def _age_fault(
        self, name: str, arrival_ns: int, timeout_ns: int, inputs: Inputs, now_ns: int, by_stamp_ns: int = 0
    ) -> Fault | None:
        """Fault of an input that exceeds `timeout_ns` before the next period, by its arrival or by its stamp.

        `by_stamp_ns`: a longer timeout by the stamp.
        """
        if now_ns - arrival_ns > self._limit(timeout_ns):
            return Fault(f"{name} silent", name)
        age_ns, limit_ns = now_ns - inputs.measured_ns.get(name, arrival_ns), self._limit(max(by_stamp_ns, timeout_ns))
        if age_ns > limit_ns:
            text = f"{name} comes late: more than {limit_ns // 1_000_000} ms old by its stamps"
            return Fault(text, f"a newer {name}")
        if age_ns < -MAX_FUTURE_NS:
            return Fault(f"{name} is stamped in the future: check the clock synchronization", "synchronized clocks")
        return None

    def _limit(self, timeout_ns: int) -> int:
        """Age [ns] at which a timeout would pass before the next period."""
        return max(timeout_ns - self._period_ns, timeout_ns // 2)

    def _force_fault(self, number: int, force: float, spring: Spring, now_ns: int) -> str:
        config = self._config
        # the damper of a shortening transmission bears a part of the force; no force at all is slack in any case
        if force < max(spring.slack_force - config.slack_margin, MIN_TRANSMISSION_FORCE):
            return f"transmission_{number} slack or its force sensor off: {force:.3g} N"
        if force > OVERLOAD * config.force_max:
            return f"transmission_{number} over its limit: {force:.3g} N"
        if config.frozen_timeout and now_ns - self._changed_ns[number - 1] > config.frozen_timeout * NANOSECONDS:
            return f"force of transmission_{number} frozen at {force:.6g} N"
        return ""


def format_fault(fault: str, estimator_faults: tuple[str, str]) -> str:
    """A fault with the faults of the estimators in parentheses."""
    parts = [f"transmission_{number}: {text}" for number, text in enumerate(estimator_faults, 1) if text]
    return f"{fault} ({'; '.join(parts)})" if parts else fault


def invalidity(inputs: Inputs) -> str:
    """Why the stiffness of the joint is invalid, with the reasons of the estimators; empty where it is valid."""
    joint = inputs.joint
    if joint is None or joint.stiffness_valid:
        return ""
    text = f"joint stiffness invalid: {joint.reason or Status(joint.status).name}"
    return format_fault(text, inputs.estimator_faults)


def _validity_fault(joint: JointMeasurement, sensor_fault: bool, has_law: bool) -> Fault | None:
    reason = joint.reason or Status(joint.status).name
    if joint.status in (Status.STALE, Status.FAULT, Status.INITIALIZING):
        return Fault(f"joint stiffness invalid: {reason}", "samples of both transmissions")
    if not joint.stiffness_valid and not (has_law and not sensor_fault):
        return Fault(f"joint stiffness invalid: {reason}", "the end of the sensor fault" if sensor_fault else MOTION)
    if joint.stiffness_valid and not joint.force_valid:
        text = f"tension invalid: {joint.reason or 'force sensor fault'}"
        return Fault(text, "valid forces of both transmissions")
    return None
