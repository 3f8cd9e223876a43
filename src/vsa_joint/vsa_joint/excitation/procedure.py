# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One run: motor positions for each period, until the wanted quantities are known or the run ends otherwise.

Instants are of a steady clock and are arguments. Designs are solved by the caller, in another thread: `task` is the one
that is due, `begin_segment` takes its result. Until the first one the motors keep their positions.
"""

from dataclasses import dataclass, replace

import numpy as np
from vsa_common.stamps import NANOSECONDS
from vsa_joint.excitation.balance import Start
from vsa_joint.excitation.design import Task
from vsa_joint.excitation.inputs import Inputs, Pair
from vsa_joint.excitation.limits import excess, motor_range, predicted_range, shortfall
from vsa_joint.excitation.model import model_of
from vsa_joint.excitation.multisine import Multisine, Range, fade
from vsa_joint.excitation.quantities import KnownQuantities
from vsa_joint.excitation.settings import ExcitationConfig, Goal
from vsa_joint.excitation.tuning import ANGLE_GAIN, FOLLOWING_ERROR, FOLLOWING_TIMEOUT_NS, OVERLOAD, SEGMENT


class ExcitationRefused(ValueError):
    """A run cannot start or continue; the text states the reason."""


@dataclass(frozen=True)
class Outcome:
    """The end of a run: whether all wanted quantities are known, and one sentence."""

    success: bool
    message: str


class Procedure:
    """State of a run; `outcome` is set at its end."""

    def __init__(self, config: ExcitationConfig, goal: Goal, inputs: Inputs, now_ns: int) -> None:
        """Raises ExcitationRefused where the inputs or the limits do not permit a motion."""
        if fault := inputs.fault(now_ns, int(config.input_timeout * NANOSECONDS)):
            raise ExcitationRefused(fault)
        self._config, self.goal = config, goal
        self._start = Start(inputs.deflections, (config.radius[0], config.radius[1]))
        if text := excess(inputs.forces, inputs.deflections, config, goal) or shortfall(inputs.deflections, config):
            raise ExcitationRefused(f"no room at the start: {text}")
        assert inputs.motors is not None
        self._motors = self._sent = inputs.motors
        self._range = Range(*motor_range(config, inputs.motors), goal.speed)
        if not self._range.low <= 0.0 <= self._range.high:
            limits = f"{config.motor_min:g} to {config.motor_max:g} rad"
            raise ExcitationRefused(f"motors at {inputs.motors[0]:.3g} and {inputs.motors[1]:.3g} rad, limits {limits}")
        self._forces, self._angle = inputs.forces, inputs.angle
        self._begin_ns = self._followed_ns = self._stepped_ns = now_ns
        self._segments = [(Multisine(0.0), now_ns)] * 2  # the motion before and the present one, with their begin
        self._mean = self._trim = 0.0  # mean deflection [m] and turn of the joint by both motors [rad], from the start
        self.outcome: Outcome | None = None
        self.known = KnownQuantities(goal.quantities, goal.relative_interval)

    def elapsed(self, now_ns: int) -> float:
        """Time since the begin [s]."""
        return (now_ns - self._begin_ns) / NANOSECONDS

    def task(self, inputs: Inputs, now_ns: int) -> Task | None:
        """The design that is due; None while a segment lasts. Raises ExcitationRefused without usable coefficients."""
        motion, begin_ns = self._segments[1]
        if motion.amplitudes and now_ns - begin_ns < SEGMENT * NANOSECONDS:
            return None
        first, second = (None if state is None else model_of(state) for state in inputs.states)
        if first is None or second is None:
            raise ExcitationRefused("coefficients of the estimators not usable")
        models = (first, second)
        predicted = predicted_range(models, self._start, self._forces, self._config, self.goal)
        low, high = max(self._range.low, predicted.low), min(self._range.high, predicted.high)
        rate = min(inputs.sample_rates)
        limits = Range(low, max(high, low), self.goal.speed)
        return Task(models, self._start, self._mean, limits, self.goal.quantities, rate)

    def begin_segment(self, motion: Multisine, now_ns: int) -> None:
        """Continue with the motion of a solved design."""
        self._segments = [self._segments[1], (motion, now_ns)]

    @property
    def motion(self) -> Multisine:
        """The present motion."""
        return self._segments[1][0]

    def step(self, inputs: Inputs, now_ns: int) -> Pair:
        """Motor positions [rad] for this period; sets `outcome` at the end of the run."""
        step, self._stepped_ns = (now_ns - self._stepped_ns) / NANOSECONDS, now_ns
        fault = inputs.fault(now_ns, int(self._config.input_timeout * NANOSECONDS))
        if not fault:
            self.known.update([state for state in inputs.states if state is not None], self.elapsed(now_ns))
            self._restrict(inputs)
            self._advance(step, now_ns, inputs)
        self.outcome = self._outcome(fault or self._hazard(inputs, now_ns), now_ns)
        return self._sent

    def end(self, text: str, now_ns: int) -> None:
        """End the run early, as at a cancellation."""
        self.outcome = Outcome(False, f"{text} after {self.elapsed(now_ns):.1f} s")

    def _restrict(self, inputs: Inputs) -> None:
        """Exclude the mean deflections beyond the present one where a limit is exceeded."""
        if excess(inputs.forces, inputs.deflections, self._config, self.goal):
            self._range = replace(self._range, high=min(self._range.high, self._mean))
        if shortfall(inputs.deflections, self._config):
            self._range = replace(self._range, low=max(self._range.low, self._mean))

    def _advance(self, step: float, now_ns: int, inputs: Inputs) -> None:
        """Advance the motion by `step` [s], and turn the joint back to its angle at the start."""
        (before, before_ns), (motion, begin_ns) = self._segments
        since = np.array([now_ns - before_ns, now_ns - begin_ns]) / NANOSECONDS
        share, targets = float(fade(since[1])), (float(before(since[0])), float(motion(since[1])))
        target = targets[0] + share * (targets[1] - targets[0])
        period = min(step, 2.0 / self._config.rate)  # after a delay the motion continues at its speed
        most = self.goal.speed * period
        mean = self._mean + min(max(target - self._mean, -most), most)
        self._mean = min(max(mean, self._range.low), self._range.high)
        if inputs.angle is not None and self._angle is not None:
            self._trim -= ANGLE_GAIN * period * (inputs.angle - self._angle)
        config = self._config
        travels = (2.0 * self._mean + config.radius[0] * self._trim, 2.0 * self._mean - config.radius[1] * self._trim)
        first, second = (
            min(max(motor + travel / config.motor_pulley_radius, config.motor_min), config.motor_max)
            for motor, travel in zip(self._motors, travels, strict=True)
        )
        self._sent = (first, second)

    def _hazard(self, inputs: Inputs, now_ns: int) -> str:
        """Reason for an immediate end, of measurements that are valid; empty for none."""
        for number, force in enumerate(inputs.forces, 1):
            if force > OVERLOAD * self.goal.force_max:
                return f"force of transmission_{number} {force:.3g} N, limit {self.goal.force_max:.3g} N"
        if inputs.angle is not None and self._angle is not None:
            turn = inputs.angle - self._angle
            if abs(turn) > self._config.angle_max:
                return f"joint turned by {turn:.2g} rad, limit {self._config.angle_max:.2g} rad"
        near = min(FOLLOWING_ERROR, self.goal.travel / self._config.motor_pulley_radius)
        if inputs.motors is None or _distance(inputs.motors, self._sent) < near:
            self._followed_ns = now_ns
        late = now_ns - self._followed_ns > FOLLOWING_TIMEOUT_NS
        return "motors do not follow: is the driver armed?" if late else ""

    def _outcome(self, fault: str, now_ns: int) -> Outcome | None:
        elapsed = self.elapsed(now_ns)
        if fault:
            return Outcome(False, f"stopped after {elapsed:.1f} s: {fault}")
        if self.known.all_known:
            return Outcome(True, f"all wanted quantities are known after {elapsed:.1f} s")
        if elapsed >= self.goal.duration:
            missing = "; ".join(
                f"{one.quantity} of transmission_{one.transmission}" + (f" ({one.reason})" if one.reason else "")
                for one in self.known.unknown
            )
            return Outcome(False, f"not known after {elapsed:.1f} s: {missing}")
        return None


def _distance(first: Pair, second: Pair) -> float:
    return max(abs(a - b) for a, b in zip(first, second, strict=True))
