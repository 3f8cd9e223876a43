# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion of both transmissions while the co-contraction changes: one torque balance, two unequal dampers.

At rest the force determines each deflection. In motion the dampers bear a part of the force; with unequal dampers one
transmission leads the other. Motors that follow this motion exert no torque on the joint. The lead is distributed over
both transmissions so that the stiffness of the joint does not change.
"""

import math

from vsa_joint.control.records import Measurement
from vsa_joint.control.springs import Spring, Springs
from vsa_joint.control.stiffness_range import StiffnessRange, force_for, partner_force, relative_std
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.settings import ControlConfig
from vsa_joint.tuning import (
    DITHER_SPEED_SHARE,
    LEAD_BISECTIONS,
    MAX_LEAD,
    MIN_STIFFNESS_SLOPE,
    PROTECTION_DECAY,
    PROTECTION_GAIN,
    SLACK_SHARE,
)

Pair = tuple[float, float]  # transmission_1, transmission_2


class CoContractionMotion:
    """Deflections and forces of both transmissions; one `step` per control period."""

    def __init__(self, joint: Joint) -> None:
        self._joint = joint
        self._force = 0.0  # N
        self._lead = 0.0  # m, of transmission_1

    def start(self, force: float) -> None:
        """Reset to rest at `force` of transmission_1 [N]."""
        self._force, self._lead = force, 0.0

    def step(self, force: float, springs: Springs, dt: float) -> tuple[Pair, Pair]:
        """Deflections [m] and forces [N] after `dt` [s] for an elastic force of transmission_1 that is then `force`."""
        before, self._force = self._at_rest(self._force, springs), force
        at_rest = self._at_rest(force, springs)
        speeds = [(position - last) / dt for position, last in zip(at_rest, before, strict=True)]
        (first, second), (path_1, path_2) = springs, self._joint.paths
        slope_1 = _stiffness_slope(first, at_rest[0], path_1)
        slope_2 = _stiffness_slope(second, at_rest[1], path_2)
        share_1, share_2 = slope_2 / (slope_1 + slope_2), slope_1 / (slope_1 + slope_2)
        last_lead = self._lead

        def moved(lead: float) -> tuple[Pair, Pair]:
            rate = (lead - last_lead) / dt
            deflections = at_rest[0] + share_1 * lead, at_rest[1] - share_2 * lead
            force_1 = first.force(deflections[0]) + first.damper(speeds[0] + share_1 * rate)
            force_2 = second.force(deflections[1]) + second.damper(speeds[1] - share_2 * rate)
            return deflections, (force_1, force_2)

        low, high = -MAX_LEAD, MAX_LEAD
        for _ in range(LEAD_BISECTIONS):
            self._lead = 0.5 * (low + high)
            force_1, force_2 = moved(self._lead)[1]
            if path_1.radius * force_1 < path_2.radius * force_2:
                low = self._lead
            else:
                high = self._lead
        return moved(self._lead)

    def _at_rest(self, force: float, springs: Springs) -> Pair:
        """Deflections at rest [m]."""
        first, second = springs
        return first.deflection(force), second.deflection(partner_force(force, 0.0, self._joint))


def _stiffness_slope(spring: Spring, deflection: float, path: TendonPath) -> float:
    """Derivative of the joint stiffness by the deflection of one transmission [N/rad]."""
    stiffness, series = spring.stiffness_at(deflection), 4.0 * path.tendon_stiffness
    return (
        max(spring.slope_at(deflection), MIN_STIFFNESS_SLOPE)
        * stiffness
        * (path.radius * series / (stiffness + series)) ** 2
    )


class ReExcitation:
    """Force [N] of a sinusoidal co-contraction that makes an invalid stiffness observable again.

    Its share of the amplitude grows over one period. It shrinks while the unloaded equilibrium is further from where it
    was than half of `recovery_angle`: the law is then wrong, and both forces do not balance.
    """

    def __init__(self, joint: Joint) -> None:
        self._joint = joint
        self._offset = self._share = self._phase = self._angle = 0.0  # N; 1; rad; rad

    def start(self, angle: float) -> None:
        """Begin with the unloaded equilibrium at `angle` [rad]."""
        self._share, self._phase, self._angle = 0.0, 0.0, angle

    def step(
        self, force: float, angle: float, springs: Springs, reachable: StiffnessRange, config: ControlConfig
    ) -> float:
        """Force [N] of transmission_1 after a control period, about `force` [N] as far as the range permits."""
        growth = config.recovery_frequency / config.rate
        if abs(angle - self._angle) > 0.5 * config.recovery_angle:
            growth *= -2.0
        self._share = min(max(self._share + growth, 0.0), 1.0)
        if self._share == 0.0:
            self._angle = angle  # displaced by a load, not by the excitation
        self._phase += 2.0 * math.pi * config.recovery_frequency / config.rate
        amplitude = min(self._amplitude(force, springs, config), 0.5 * (reachable.force_max - reachable.force_min))
        centre = min(max(force, reachable.force_min + amplitude), reachable.force_max - amplitude)
        self._offset = self._share * (centre - force + amplitude * math.sin(self._phase))
        return force + self._offset

    def fade(self, config: ControlConfig) -> float:
        """Remaining force [N] a control period after the end, without a step and no faster than the sine."""
        self._offset *= math.exp(-2.0 * math.pi * config.recovery_frequency / config.rate)
        return self._offset

    def _amplitude(self, force: float, springs: Springs, config: ControlConfig) -> float:
        """Amplitude of the force [N]: limits of deflection, of the dampers' speed and of the motors' speed."""
        forces = force, partner_force(force, 0.0, self._joint)
        softer = min(spring.stiffness(f) for spring, f in zip(springs, forces, strict=True))
        speed = DITHER_SPEED_SHARE * min(spring.peak_speed for spring in springs)
        tendon_stiffness = min(path.tendon_stiffness for path in self._joint.paths)
        travel = 2.0 + softer / (2.0 * tendon_stiffness)  # of the tendon, per deflection
        speed = min(speed, config.recovery_speed * config.motor_pulley_radius / travel)
        return softer * min(config.recovery_amplitude, speed / (2.0 * math.pi * config.recovery_frequency))


class SlackProtection:
    """Force [N] on both transmissions while one spring is close to slack, or one force exceeds the limit.

    The springs bear the measured forces without those of the dampers in the commanded change of stiffness. Without
    valid forces it keeps its value.
    """

    def __init__(self, joint: Joint) -> None:
        self.force = 0.0  # N
        self._share = partner_force(1.0, 0.0, joint)

    def step(self, measurement: Measurement, force: float, rate: float, config: ControlConfig) -> None:
        """Update after a control period with a commanded force of transmission_1 [N] and its rate [N/s]."""
        if not measurement.force_valid:
            return
        forces, elastic = [2.0 * tension for tension in measurement.tension], []
        for measured, ratio, spring in zip(forces, (1.0, self._share), measurement.springs, strict=True):
            velocity = ratio * rate / spring.stiffness(ratio * force)
            elastic.append(measured - spring.damper(velocity) - spring.least_force)
        lacking = max(0.0, SLACK_SHARE * config.slack_margin - min(elastic))
        excess = max(0.0, max(forces) - config.force_max)
        decay = PROTECTION_DECAY * self.force
        self.force += 1.0 / config.rate * (PROTECTION_GAIN * (lacking - excess) - decay)


class SelfExcitation:
    """Sinusoidal common force [N] without torque while the predicted error of the stiffness is large."""

    def __init__(self, joint: Joint) -> None:
        self.active = False
        self._joint = joint
        self._phase = 0.0  # rad

    def step(
        self,
        stiffness: float,
        torque: float,
        about: float,
        springs: Springs,
        reachable: StiffnessRange,
        config: ControlConfig,
    ) -> float:
        """Force [N] after a control period with a target `stiffness` [N m/rad], a load [N m], and `about` [N]."""
        if config.dither_amplitude == 0.0:
            return 0.0
        force = force_for(stiffness, torque, springs, self._joint, reachable)
        error = relative_std(force, torque, springs, self._joint)
        if error > config.dither_error:
            self.active = True
        elif self._phase == 0.0 or error < 0.5 * config.dither_error:
            self.active = False
        if not self.active:
            self._phase = 0.0
            return 0.0
        self._phase += 2.0 * math.pi * config.dither_frequency * (1.0 / config.rate)
        speed = min(spring.peak_speed for spring in springs)
        amplitude_max = DITHER_SPEED_SHARE * speed / (2.0 * math.pi * config.dither_frequency)
        softer = min(spring.stiffness(about) for spring in springs)
        return softer * min(config.dither_amplitude, amplitude_max) * math.sin(self._phase)
