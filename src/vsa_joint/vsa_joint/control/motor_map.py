# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motor positions from the forces of both transmissions, the identified springs and the tendons.

The tendon travel of motor i is q_i = 2 x_i + F_i / (2 K_t) +- R theta: twice the deflection, the elongation of the
tendon, and the joint angle.
"""

from collections.abc import Callable

from vsa_joint.control.springs import Springs
from vsa_joint.control.stiffness_range import StiffnessRange, partner_force, stiffness_at, tendon_travel
from vsa_joint.settings import ControlConfig, JointConfig
from vsa_joint.tuning import RANGE_BISECTIONS

Pair = tuple[float, float]  # transmission_1, transmission_2


class MotorMap:
    """Motor positions [rad] for forces [N]; `fit_zero` identifies the zero of the motors."""

    def __init__(self, config: ControlConfig | JointConfig) -> None:
        self._config = config
        self._joint = config.joint
        self._zero = (0.0, 0.0)  # tendon travel at motor zero [m]

    def reconfigure(self, config: ControlConfig | JointConfig) -> None:
        """Apply the tunable parameters of another configuration; the zero stays."""
        self._config = config

    def fit_zero(self, motors: Pair, force: float, angle: float, springs: Springs) -> None:
        """Set the zero so that `motors` [rad] hold an unloaded joint at `angle` [rad] with `force` [N]."""
        radius, self._zero = self._config.motor_pulley_radius, (0.0, 0.0)
        first, second = self.positions(force, angle, springs)
        self._zero = radius * (motors[0] - first), radius * (motors[1] - second)

    def positions(self, force: float, angle: float, springs: Springs) -> Pair:
        """Positions that hold an unloaded joint at `angle` [rad] with `force` [N] of transmission_1."""
        forces = force, partner_force(force, 0.0, self._joint)
        return self.positions_at((springs[0].deflection(forces[0]), springs[1].deflection(forces[1])), forces, angle)

    def positions_at(self, deflections: Pair, forces: Pair, angle: float) -> Pair:
        """Positions for `deflections` [m] under `forces` [N] with the joint at `angle` [rad]."""
        radius = self._config.motor_pulley_radius
        travels = self._travels(deflections, forces, angle)
        return (travels[0] + self._zero[0]) / radius, (travels[1] + self._zero[1]) / radius

    def clip(self, motors: Pair) -> Pair:
        """Positions clipped to the motors' limits."""
        low, high = self._config.motor_min, self._config.motor_max
        return min(max(motors[0], low), high), min(max(motors[1], low), high)

    def clip_to_motors(
        self, reachable: StiffnessRange, torque: float, angle: float, springs: Springs
    ) -> StiffnessRange | None:
        """Part of a range under an external torque [N m] that the motors reach at `angle` [rad]; None for none."""
        config, low, high = self._config, reachable.force_min, reachable.force_max

        def tendon_taut(force: float) -> bool:
            return min(self.positions(force, angle, springs)) >= config.motor_min

        def above_limit(force: float) -> bool:
            return max(self.positions(force, angle, springs)) > config.motor_max

        low = low if tendon_taut(low) else _first_true(tendon_taut, low, high)
        if not tendon_taut(low) or above_limit(low):
            return None
        high = _first_true(above_limit, low, high) if above_limit(high) else high
        if (low, high) == (reachable.force_min, reachable.force_max):
            return reachable
        return StiffnessRange(
            stiffness_min=stiffness_at(low, torque, springs, self._joint),
            stiffness_max=stiffness_at(high, torque, springs, self._joint),
            force_min=low,
            force_max=high,
        )

    def _travels(self, deflections: Pair, forces: Pair, angle: float) -> Pair:
        first, second = self._joint.paths
        return (
            tendon_travel(forces[0], deflections[0], first.tendon_stiffness) + first.radius * angle,
            tendon_travel(forces[1], deflections[1], second.tendon_stiffness) - second.radius * angle,
        )


def _first_true(condition: Callable[[float], bool], low: float, high: float) -> float:
    """Least force at which a monotonic `condition`, false at `low`, is true; `high` where it is false throughout."""
    for _ in range(RANGE_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if condition(middle) else (middle, high)
    return high
