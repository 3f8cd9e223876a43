"""From the force that the springs shall bear to motor positions, by the learned springs and the tendons.

Motor i winds up q_i = 2 x_i + F_i / (2 K_t) +- R theta of tendon: the rod's travel twice, what the tendon stretches,
and the joint's angle.
"""

from collections.abc import Callable

from vsa_joint.control.springs import Range, Springs, partner_force, stiffness_at, tendon_travel
from vsa_joint.settings import ControlConfig, JointConfig

BISECTIONS = 30

Pair = tuple[float, float]


class MotorMap:
    """Motor positions [rad] for rod forces; `fit` finds the motors' zero."""

    def __init__(self, config: ControlConfig | JointConfig) -> None:
        self._config = config
        self._joint = config.joint
        self._zero = (0.0, 0.0)  # tendon travel at motor zero [m]

    def fit(self, motors: Pair, force: float, angle: float, springs: Springs) -> None:
        """Take `motors` [rad] for those that hold an unloaded joint at `angle` [rad] by `force` [N]."""
        radius, self._zero = self._config.motor_pulley_radius, (0.0, 0.0)
        first, second = self.positions(force, angle, springs)
        self._zero = radius * (motors[0] - first), radius * (motors[1] - second)

    def positions(self, force: float, angle: float, springs: Springs) -> Pair:
        """Positions that hold an unloaded joint at `angle` [rad] by `force` [N] of transmission_1's spring."""
        forces = force, partner_force(force, 0.0, self._joint)
        return self.following((springs[0].deflection(forces[0]), springs[1].deflection(forces[1])), forces, angle)

    def following(self, deflections: Pair, forces: Pair, angle: float) -> Pair:
        """Positions for both rods at `deflections` [m] under `forces` [N] and the joint at `angle` [rad]."""
        radius = self._config.motor_pulley_radius
        travels = self._travels(deflections, forces, angle)
        return (travels[0] + self._zero[0]) / radius, (travels[1] + self._zero[1]) / radius

    def clipped(self, motors: Pair) -> Pair:
        """The nearest positions within the motors' limits."""
        low, high = self._config.motor_min, self._config.motor_max
        return min(max(motors[0], low), high), min(max(motors[1], low), high)

    def narrowed(self, found: Range, torque: float, angle: float, springs: Springs) -> Range | None:
        """What of a range under an external torque [N m] the motors can hold at `angle` [rad]."""
        config, low, high = self._config, found.force_min, found.force_max

        def wound(force: float) -> bool:
            return min(self.positions(force, angle, springs)) >= config.motor_min

        def too_far(force: float) -> bool:
            return max(self.positions(force, angle, springs)) > config.motor_max

        low = low if wound(low) else _first(wound, low, high)
        if not wound(low) or too_far(low):
            return None
        high = _first(too_far, low, high) if too_far(high) else high
        if (low, high) == (found.force_min, found.force_max):
            return found
        least, most = (stiffness_at(force, torque, springs, self._joint) for force in (low, high))
        return Range(least, most, low, high)

    def _travels(self, deflections: Pair, forces: Pair, angle: float) -> Pair:
        first, second = self._joint.routes
        return (
            tendon_travel(forces[0], deflections[0], first.tendon_stiffness) + first.radius * angle,
            tendon_travel(forces[1], deflections[1], second.tendon_stiffness) - second.radius * angle,
        )


def _first(holds: Callable[[float], bool], low: float, high: float) -> float:
    """The least force from which on `holds`, which does not at `low`; `high` where it never does."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
