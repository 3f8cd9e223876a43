# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness control that preserves the compliance: feedback of the unloaded equilibrium, not of the measured angle.

The external torque is tau = R2 T2 - R1 T1. With stiffness K and damping D of the joint, D z' = tau - K z is the
deflection z due to the load; the remainder, angle - z, is the unloaded equilibrium. Feedback of the measured angle
would oppose external torque, so that a joint of 0.5 N m/rad would have the stiffness of one of 8.

Both motors receive q_i = 2 x_i(F) + F / (2 K_t) +- R (equilibrium + correction). F follows from the commanded
stiffness by the identified springs, filtered, with an integral trim by the estimated stiffness. In transients x_i and
F_i are those of `CoContractionMotion`.
"""

import math

from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.records import Feasibility, Measurement, Target
from vsa_joint.control.setpoint_filter import RateLimitedFilter
from vsa_joint.control.springs import Springs, force_variance, position_variance
from vsa_joint.control.stiffness_range import (
    StiffnessRange,
    force_for,
    force_rate,
    reachable_range,
    relative_std,
)
from vsa_joint.control.tendon_motion import CoContractionMotion, ReExcitation, SelfExcitation, SlackProtection
from vsa_joint.impedance.tension import unloaded_force
from vsa_joint.settings import ControlConfig
from vsa_joint.tuning import (
    MIN_FORCE_ABOVE_OFFSET,
    MIN_STIFFNESS,
    SETTLE_BAND,
    TRIM_MAX,
)


class StiffnessControl:
    """Feed-forward by the identified springs with slow integral corrections; one `step` per control period."""

    def __init__(self, config: ControlConfig) -> None:
        self.joint = config.joint
        self.equilibrium = 0.0  # estimated, unloaded [rad]
        self._config = config
        self._dt = 1.0 / config.rate  # s
        self._deflection = 0.0  # due to the load [rad]
        self._load = 0.0  # low-pass filtered external torque [N m]
        self._least_force = 0.0  # N, the larger of both springs
        self._log_force, self._rest_angle = RateLimitedFilter(0.0), RateLimitedFilter(0.0)  # ln(F - F0); rad
        self._force_rate = 0.0  # of the filtered set-point [N/s]
        self._integral_trim = 0.0  # ln K
        self._integral = 0.0  # of the equilibrium loop [rad]
        self._correction = 0.0  # of the equilibrium [rad]
        self._sent = (0.0, 0.0)  # motor positions of the last period [rad]
        self._motors = MotorMap(config)
        self._motion = CoContractionMotion(config.joint)
        self._excitation = ReExcitation(config.joint)
        self._slack_protection = SlackProtection(config.joint)
        self._dither = SelfExcitation(config.joint)

    def reconfigure(self, config: ControlConfig) -> None:
        """Apply the tunable parameters of another configuration; the state stays."""
        self._config = config
        self._dt = 1.0 / config.rate
        self._motors.reconfigure(config)

    def engage(self, measurement: Measurement) -> None:
        """Initialize at the present state, so that the first command is the measured position."""
        self._load = self._torque(measurement)
        self._deflection = self._load / max(measurement.stiffness, MIN_STIFFNESS)
        self.equilibrium = measurement.angle - self._deflection
        self._least_force = max(spring.least_force for spring in measurement.springs)
        log_force = self._log_above_offset(unloaded_force(measurement.tension, self._config.radius))
        self._log_force, self._rest_angle = RateLimitedFilter(log_force), RateLimitedFilter(self.equilibrium)
        self._integral_trim = self._integral = self._correction = self._force_rate = 0.0
        self._excitation, self._slack_protection = ReExcitation(self.joint), SlackProtection(self.joint)
        self._dither = SelfExcitation(self.joint)
        self._motion.start(self._force)
        self._sent = measurement.motors
        self._motors.fit_zero(measurement.motors, self._force, self.equilibrium, measurement.springs)

    def check_command(self, target: Target, measurement: Measurement) -> Feasibility:
        """Whether the target is reachable under the present load with an acceptable predicted error."""
        config = self._config
        reachable = self.reachable(measurement, target.equilibrium)
        if reachable is None:
            return Feasibility(False, f"no stiffness is reachable under {self._load:.3g} N m", None, math.inf)
        span = f"reachable: {reachable.stiffness_min:.3g} to {reachable.stiffness_max:.3g} N m/rad"
        if not (math.isfinite(target.stiffness) and math.isfinite(target.equilibrium)):
            return Feasibility(False, f"the command is not finite; {span}", reachable, math.inf)
        if target.stiffness not in reachable:
            text = f"{target.stiffness:.3g} N m/rad cannot be reached at {target.equilibrium:.3g} rad; {span}"
            return Feasibility(False, text, reachable, math.inf)
        error = self._predicted_error(target, measurement.springs, reachable)
        if error > config.error_max:
            text = f"predicted error of the stiffness {error:.0%}: move the joint until k2 and F0 converge"
            return Feasibility(False, text, reachable, error)
        text = f"predicted error of the stiffness {error:.0%}" if error > config.error_warn else ""
        return Feasibility(True, text, reachable, error)

    def reachable(self, measurement: Measurement, equilibrium: float) -> StiffnessRange | None:
        """Reachable stiffness at an angle [rad] under the present load: limits of springs, tendons and motors."""
        springs = measurement.springs
        reachable = reachable_range(self._load, springs, self.joint, self._config)
        if reachable is None:
            return None
        return self._motors.clip_to_motors(reachable, self._load, equilibrium, springs)

    def has_range(self, measurement: Measurement) -> bool:
        """Whether the limits of force and deflection leave a range of the stiffness without load."""
        return self._unloaded_range(measurement) is not None

    def predicted_error(self, target: Target, measurement: Measurement) -> float:
        """Predicted relative standard deviation of the stiffness at the target."""
        reachable = self.reachable(measurement, target.equilibrium)
        return math.inf if reachable is None else self._predicted_error(target, measurement.springs, reachable)

    def step(self, target: Target, measurement: Measurement, feedback: bool = True) -> tuple[float, float]:
        """Motor positions [rad] for this period; without `feedback` the corrections keep their values.

        Without a reachable range they are those of the last period.
        """
        self._update_equilibrium(measurement)
        reachable = self._unloaded_range(measurement)
        if reachable is None:
            return self._sent
        self._update_force(target, measurement, reachable, feedback)
        rest_angle = self._update_rest_angle(target)
        if feedback:
            self._correction = self._update_correction(rest_angle)
        springs, config = measurement.springs, self._config
        self._slack_protection.step(measurement, self._force, self._force_rate, config)
        force = self._force + self._slack_protection.force
        force += self._dither.step(target.stiffness, self._load, self._force, springs, reachable, config)
        return self._positions(force + self._excitation.fade(config), springs, reachable)

    @property
    def exciting(self) -> bool:
        """Whether the self-excitation is active."""
        return self._dither.active

    def start_excitation(self) -> None:
        """Begin `excite`: the present unloaded equilibrium is its reference."""
        self._excitation.start(self.equilibrium)

    def excite(self, measurement: Measurement, last: tuple[float, float]) -> tuple[float, float]:
        """Motor positions [rad] for this period of the re-excitation; `last` are those of the last period.

        The set-points of force and equilibrium stay.
        """
        self._update_equilibrium(measurement)
        springs, config = measurement.springs, self._config
        reachable = self._unloaded_range(measurement)
        if reachable is None:
            return last
        self._log_force.settle(config.smoothing_time, self._dt)
        self._force_rate = 0.0
        self._slack_protection.step(measurement, self._force, self._force_rate, config)
        about = self._force + self._slack_protection.force
        force = self._excitation.step(about, self.equilibrium, springs, reachable, config)
        first, second = self._positions(force, springs, reachable)
        travel = config.recovery_speed * self._dt
        return (
            min(max(first, last[0] - travel), last[0] + travel),
            min(max(second, last[1] - travel), last[1] + travel),
        )

    def _unloaded_range(self, measurement: Measurement) -> StiffnessRange | None:
        return reachable_range(0.0, measurement.springs, self.joint, self._config)

    def _positions(self, force: float, springs: Springs, reachable: StiffnessRange) -> tuple[float, float]:
        """Motor positions [rad] for a force of transmission_1 [N], clipped to the range, at the present equilibrium."""
        force = min(max(force, reachable.force_min), reachable.force_max)
        moved = self._motion.step(force, springs, self._dt)
        self._sent = self._motors.clip(self._motors.positions_at(*moved, self._rest_angle.value + self._correction))
        return self._sent

    def _predicted_error(self, target: Target, springs: Springs, reachable: StiffnessRange) -> float:
        force = force_for(target.stiffness, self._load, springs, self.joint, reachable)
        return max(
            relative_std(force, self._load, springs, self.joint, variance)
            for variance in (position_variance, force_variance)
        )

    def _update_equilibrium(self, measurement: Measurement) -> None:
        """Observer of the unloaded equilibrium: implicit Euler step of D z' = tau - K z.

        Without valid forces the deflection by the load keeps its value.
        """
        if measurement.force_valid:
            torque = self._torque(measurement)
            k, d = max(measurement.stiffness, MIN_STIFFNESS), max(measurement.damping, 0.0)
            self._deflection = (d * self._deflection + self._dt * torque) / (d + self._dt * k)
            self._load += self._dt / self._config.load_time * (torque - self._load)
        self.equilibrium = measurement.angle - self._deflection

    def _update_force(
        self, target: Target, measurement: Measurement, reachable: StiffnessRange, feedback: bool
    ) -> None:
        """Filter ln(F - F0) towards the force of the target stiffness; integral trim within the settle band."""
        config, springs = self._config, measurement.springs
        self._lower_offset(springs)
        trimmed = target.stiffness * math.exp(self._integral_trim)
        setpoint = self._log_above_offset(force_for(trimmed, 0.0, springs, self.joint, reachable))
        rate = force_rate(self._force, config.motor_speed * config.motor_pulley_radius, springs, self.joint)
        rate /= max(self._force - self._least_force, MIN_FORCE_ABOVE_OFFSET)  # of ln(F - F0)
        force = self._force
        log_force = self._log_force.step(setpoint, rate, config.smoothing_time, self._dt)
        self._force_rate = (self._force - force) / self._dt
        if feedback and abs(log_force - setpoint) < SETTLE_BAND:
            error = math.log(target.stiffness / max(measurement.stiffness, MIN_STIFFNESS))
            trim = self._integral_trim + config.stiffness_gain * self._dt * error
            self._integral_trim = min(max(trim, -TRIM_MAX), TRIM_MAX)

    def _lower_offset(self, springs: Springs) -> None:
        """Offset of the logarithmic set-point of another law whose springs bear less; the filter begins anew there."""
        least_force = max(spring.least_force for spring in springs)
        if least_force < self._least_force - MIN_FORCE_ABOVE_OFFSET:
            force, self._least_force = self._force, least_force
            self._log_force = RateLimitedFilter(self._log_above_offset(force))

    def _update_rest_angle(self, target: Target) -> float:
        """Filter the equilibrium [rad], so that no motor exceeds its speed limit by it."""
        config = self._config
        rate = config.motor_speed * config.motor_pulley_radius / max(config.radius)
        return self._rest_angle.step(target.equilibrium, rate, config.rest_time, self._dt)

    def _update_correction(self, rest_angle: float) -> float:
        """PI control of the unloaded equilibrium [rad]; the dead band avoids limit cycles due to friction."""
        config, error = self._config, rest_angle - self.equilibrium
        error = math.copysign(max(abs(error) - config.dead_band, 0.0), error)
        integral = self._integral + config.equilibrium_integral * self._dt * error
        self._integral = min(max(integral, -config.correction_max), config.correction_max)
        return config.equilibrium_gain * error + self._integral

    @property
    def _force(self) -> float:
        """Filtered unloaded force of transmission_1 [N]."""
        return self._least_force + math.exp(self._log_force.value)

    def _log_above_offset(self, force: float) -> float:
        return math.log(max(force - self._least_force, MIN_FORCE_ABOVE_OFFSET))

    def _torque(self, measurement: Measurement) -> float:
        """External torque in static equilibrium with the tendons [N m]."""
        first, second = self.joint.paths
        return second.radius * measurement.tension[1] - first.radius * measurement.tension[0]
