"""Stiffness control that keeps the compliance: the unloaded equilibrium is controlled, never the measured angle.

The tendons bear tau = R2 T2 - R1 T1. With the live stiffness K and damping D of the joint, D z' = tau - K z is the
deflection that this load explains; what remains, angle - z, is where the joint would rest unloaded. A loop on the
measured angle instead would push back and make a joint of 0.5 N m/rad feel like one of 8.

Both motors get q_i = 2 x_i(F) + F / (2 K_t) +- R (equilibrium + correction), F from the commanded stiffness by the
springs that the estimators learned, smoothed, and trimmed by the live stiffness; on the way x_i and F_i are those of
rods that move under one torque balance (`rods`).
"""

import math
from dataclasses import dataclass

from vsa_joint.control.motor_map import MotorMap
from vsa_joint.control.springs import Range, Spring, Springs, force_for, reachable, relative_std
from vsa_joint.control.tendon_motion import Rods
from vsa_joint.impedance.tension import unloaded_force
from vsa_joint.settings import ControlConfig

KNOWN_BY = (Spring.relative_variance, Spring.law_variance)
LEAST_ABOVE_BASE = 0.5  # N
LEAST_STIFFNESS = 1e-3  # N m/rad
ARRIVED = 0.05  # of ln(F - base), from where on the stiffness is trimmed
TRIM_MAX = 0.5  # of ln K
SLACK_SHARE = 0.5  # of slack_margin at which the guard sets in
GUARD_GAIN, GUARD_DECAY = 10.0, 0.5  # 1/s, both
DITHER_SPEED_SHARE = 0.7  # of the speed of the greatest damper force


class Smoothed:
    """A value that follows its goal critically damped."""

    def __init__(self, value: float) -> None:
        self.value = value
        self._slope = 0.0

    def step(self, goal: float, tau: float, dt: float) -> float:
        """Value after `dt`, exactly, for a goal that stands still meanwhile; `tau` in s."""
        gap = self.value - goal
        pace = self._slope + gap / tau
        decay = math.exp(-dt / tau)
        self.value = goal + (gap + pace * dt) * decay
        self._slope = (self._slope - pace * dt / tau) * decay
        return self.value


@dataclass(frozen=True)
class Target:
    """What the joint shall feel like: rest angle [rad] and stiffness [N m/rad]."""

    equilibrium: float
    stiffness: float


@dataclass(frozen=True)
class Live:
    """The joint now, from estimates and measurements that are all valid."""

    angle: float  # rad
    tension: tuple[float, float]  # N
    stiffness: float  # N m/rad
    damping: float  # N m s/rad
    motors: tuple[float, float]  # rad
    springs: Springs


@dataclass(frozen=True)
class Judgement:
    """Whether a target is taken; `text` says why not, or warns; `within` is what could be."""

    accepted: bool
    text: str
    within: Range | None
    predicted_error: float


class StiffnessControl:
    """Feed-forward from the learned springs, slow integral corrections; one `step` each period."""

    def __init__(self, config: ControlConfig) -> None:
        self.config = config
        self.joint = config.joint
        self._dt = 1.0 / config.rate
        self.equilibrium = 0.0  # unloaded, as estimated [rad]
        self.exciting = False
        self._deflection = 0.0  # that the load explains [rad]
        self._load = 0.0  # N m, steady
        self._base = 0.0  # N
        self._wish = 0.0  # ln(F - base)
        self._level, self._rest = Smoothed(0.0), Smoothed(0.0)  # ln(F - base), equilibrium [rad]
        self._tau, self._goal = config.smoothing_time, 0.0
        self._trim = self._guard = self._integral = self._phase = 0.0
        self._motors = MotorMap(config)
        self._rods = Rods(config.joint)

    def engage(self, live: Live) -> None:
        """Begin from where the rig is: the first command is the measured position."""
        self._load = self._torque(live)
        self._deflection = self._load / max(live.stiffness, LEAST_STIFFNESS)
        self.equilibrium = live.angle - self._deflection
        self._base = max(spring.force_offset for spring in live.springs)
        force = unloaded_force(live.tension, self.config.radius)
        self._wish = self._log(force)
        self._level, self._rest = Smoothed(self._wish), Smoothed(self.equilibrium)
        self._trim = self._guard = self._integral = self._phase = self._goal = 0.0
        self._rods.start(self._force)
        self._motors.fit(live.motors, self._force, self.equilibrium, live.springs)

    def judge(self, target: Target, live: Live) -> Judgement:
        """Whether a target can be reached at the present load, and is known well enough."""
        config, within = self.config, self.within(live, target.equilibrium)
        if within is None:
            return Judgement(False, f"no stiffness can be held against {self._load:.3g} N m", None, math.inf)
        span = f"{within.stiffness_min:.3g} to {within.stiffness_max:.3g} N m/rad"
        if not (math.isfinite(target.stiffness) and math.isfinite(target.equilibrium)):
            return Judgement(False, f"the command is not finite; within reach: {span}", within, math.inf)
        if target.stiffness not in within:
            wish = f"{target.stiffness:.3g} N m/rad cannot be reached at {target.equilibrium:.3g} rad"
            return Judgement(False, f"{wish}; within reach: {span}", within, math.inf)
        force = force_for(target.stiffness, self._load, live.springs, self.joint, within)
        error = max(relative_std(force, self._load, live.springs, self.joint, of) for of in KNOWN_BY)
        if error > config.error_max:
            text = f"stiffness would be known to {error:.0%} only; move the joint until k2 and F0 are known"
            return Judgement(False, text, within, error)
        return Judgement(
            True, f"stiffness known to {error:.0%} only" if error > config.error_warn else "", within, error
        )

    def within(self, live: Live, equilibrium: float) -> Range | None:
        """Stiffness within reach at an angle [rad] under the present load: springs, tendons and motors."""
        found = reachable(self._load, live.springs, self.joint, self.config)
        return None if found is None else self._motors.narrowed(found, self._load, equilibrium, live.springs)

    def step(self, target: Target, live: Live) -> tuple[float, float]:
        """Motor positions [rad] for this period."""
        self._observe(live)
        within = reachable(0.0, live.springs, self.joint, self.config)
        if within is None:
            return live.motors
        self._feed_forward(target, live, within)
        rest = self._rest.step(target.equilibrium, self.config.rest_time, self._dt)
        correction = self._correction(rest)
        self._keep_tension(live)
        force = self._force + self._guard + self._dither(target, live, within)
        force = min(max(force, within.force_min), within.force_max)
        moved = self._rods.step(force, live.springs, self._dt)
        return self._motors.clipped(self._motors.following(*moved, rest + correction))

    def _observe(self, live: Live) -> None:
        """The unloaded equilibrium; D z' = tau - K z by an implicit step."""
        torque, k, d = self._torque(live), max(live.stiffness, LEAST_STIFFNESS), max(live.damping, 0.0)
        self._deflection = (d * self._deflection + self._dt * torque) / (d + self._dt * k)
        self._load += self._dt / self.config.load_time * (torque - self._load)
        self.equilibrium = live.angle - self._deflection

    def _feed_forward(self, target: Target, live: Live, within: Range) -> None:
        """Smooth ln(F - base) towards what the springs need, and trim by the live stiffness once there."""
        now = max(live.stiffness, LEAST_STIFFNESS)
        if target.stiffness != self._goal:
            self._goal = target.stiffness
            octaves = abs(math.log2(target.stiffness / now))
            self._tau = self.config.smoothing_time * max(1.0, octaves)
        force = force_for(target.stiffness * math.exp(self._trim), 0.0, live.springs, self.joint, within)
        goal = self._log(force)
        self._wish += (goal - self._wish) * (1.0 - math.exp(-self._dt / self._tau))  # the rods start without a jerk
        if abs(self._level.step(self._wish, self._tau, self._dt) - goal) < ARRIVED:
            trim = self._trim + self.config.stiffness_gain * self._dt * math.log(target.stiffness / now)
            self._trim = min(max(trim, -TRIM_MAX), TRIM_MAX)

    def _correction(self, rest: float) -> float:
        """PI on the unloaded equilibrium [rad]; friction needs the dead band."""
        config, error = self.config, rest - self.equilibrium
        error = math.copysign(max(abs(error) - config.dead_band, 0.0), error)
        integral = self._integral + config.equilibrium_integral * self._dt * error
        self._integral = min(max(integral, -config.correction_max), config.correction_max)
        return config.equilibrium_gain * error + self._integral

    def _keep_tension(self, live: Live) -> None:
        """Push both forces up while one is nearly slack, down while one is beyond the limit."""
        forces = [2.0 * tension for tension in live.tension]
        spare = min(f - spring.force_offset for f, spring in zip(forces, live.springs, strict=True))
        lacking = max(0.0, SLACK_SHARE * self.config.slack_margin - spare)
        excess = max(0.0, max(forces) - self.config.force_max)
        self._guard += self._dt * (GUARD_GAIN * (lacking - excess) - GUARD_DECAY * self._guard)

    def _dither(self, target: Target, live: Live, within: Range) -> float:
        """Rod force [N] that both sides share, so that the joint stays, while the stiffness is too uncertain."""
        config = self.config
        if config.dither_amplitude == 0.0:
            return 0.0
        force = force_for(target.stiffness, self._load, live.springs, self.joint, within)
        error = relative_std(force, self._load, live.springs, self.joint)
        if error > config.dither_error:
            self.exciting = True
        elif self._phase == 0.0 or error < 0.5 * config.dither_error:
            self.exciting = False
        if not self.exciting:
            self._phase = 0.0
            return 0.0
        self._phase += 2.0 * math.pi * config.dither_frequency * self._dt
        speed = min(spring.peak_speed for spring in live.springs)
        largest = DITHER_SPEED_SHARE * speed / (2.0 * math.pi * config.dither_frequency)
        softer = min(spring.stiffness(self._force) for spring in live.springs)
        return softer * min(config.dither_amplitude, largest) * math.sin(self._phase)

    @property
    def _force(self) -> float:
        """Smoothed rod force of transmission_1 without load [N]."""
        return self._base + math.exp(self._level.value)

    def _log(self, force: float) -> float:
        return math.log(max(force - self._base, LEAST_ABOVE_BASE))

    def _torque(self, live: Live) -> float:
        """What the tendons bear [N m], positive as an external torque."""
        first, second = self.joint.routes
        return second.radius * live.tension[1] - first.radius * live.tension[0]
