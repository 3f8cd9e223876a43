# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Gate between a controller and the motors: arming, limits, a watchdog."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

from vsa_driver.tuning import MAX_POSITION_AGE_S


class CommandRefused(ValueError):
    """A command or a request to arm is refused; the text states the reason."""


@dataclass(frozen=True)
class MotorLimits:
    """Bounds of what reaches the motors."""

    position_min: float  # [rad]
    position_max: float  # [rad]
    speed_max: float  # [rad/s]
    timeout: float  # without a command for this time nothing is sent [s]


class MotorGate:
    """Passes commands while armed: within the position limits, at most at the speed limit, only while they arrive.

    After arming, the first output is the measured position. When commands stop, the gate sends nothing, and the
    device's own watchdog holds the motors. Times `now_s` are of a monotonic clock [s].
    """

    def __init__(self, limits: MotorLimits, motors: int = 2) -> None:
        self.refused = 0  # commands
        self.rate_limited = 0  # outputs at the speed limit
        self.timeouts = 0  # of the controller
        self.reason = "not armed yet"
        self._limits = limits
        self._motors = motors
        self._measured: tuple[float, ...] | None = None  # [rad]
        self._measured_s = -math.inf
        self._armed = False
        self._output: tuple[float, ...] = ()  # [rad]
        self._target: tuple[float, ...] = ()  # [rad]
        self._commanded_s = -math.inf
        self._stepped_s = -math.inf
        self._timed_out = False

    def set_limits(self, limits: MotorLimits) -> None:
        """Apply other limits, from the next command on."""
        self._limits = limits

    @property
    def armed(self) -> bool:
        """Whether commands are passed."""
        return self._armed

    @property
    def state(self) -> str:
        """`disarmed`, `armed`, or `holding` when armed without commands."""
        return "disarmed" if not self._armed else "holding" if self._timed_out else "armed"

    def update_position(self, positions: Sequence[float], now_s: float) -> None:
        """Take the measured positions [rad]."""
        self._measured, self._measured_s = tuple(positions), now_s

    def arm(self, now_s: float) -> None:
        """Pass commands from now on, starting at the measured position; no effect while armed.

        Raises CommandRefused without a recent measured position within the limits.
        """
        if self._armed:
            return
        if self._measured is None or now_s - self._measured_s > MAX_POSITION_AGE_S:
            raise CommandRefused("motor positions are not being received")
        if outside := self._outside_limits(self._measured):
            raise CommandRefused(f"measured position of {outside}")
        self._target = self._output = self._measured
        self._commanded_s = self._stepped_s = now_s
        self._timed_out = False
        self.reason = ""
        self._armed = True

    def disarm(self, reason: str) -> None:
        """Pass nothing until armed again. Any thread may call this."""
        if self._armed:
            self.reason = reason
        self._armed = False

    def command(self, positions: Sequence[float], now_s: float) -> None:
        """Take a command [rad]. An invalid one raises CommandRefused, and the last one stays."""
        self._check(positions)
        if self._timed_out:
            self._stepped_s = now_s  # the outputs go on from the last one; the hold is no time to move
        self._target, self._commanded_s = tuple(positions), now_s
        self._timed_out = False

    def refuse(self, reason: str) -> NoReturn:
        """Count a refused command. Raises CommandRefused."""
        self.refused += 1
        raise CommandRefused(reason)

    def step(self, now_s: float) -> tuple[float, ...] | None:
        """Advance the output and return the positions to send [rad]; None where nothing is to be sent."""
        if not self._armed or self._timed_out:
            return None
        if now_s - self._commanded_s > self._limits.timeout:
            self._timed_out = True
            self._target = self._output  # a later command starts from here, not from the old target
            self.timeouts += 1
            return None
        max_step = self._limits.speed_max * min(max(now_s - self._stepped_s, 0.0), self._limits.timeout)
        self._stepped_s = now_s
        pairs = zip(self._target, self._output, strict=True)
        steps = [min(max(target - output, -max_step), max_step) for target, output in pairs]
        self._output = tuple(output + step for output, step in zip(self._output, steps, strict=True))
        self.rate_limited += any(abs(step) == max_step for step in steps)
        return self._output

    def _check(self, positions: Sequence[float]) -> None:
        if not self._armed:
            self.refuse(f"not armed ({self.reason}); call the arm service first")
        if len(positions) != self._motors:
            self.refuse(f"{len(positions)} positions, expected {self._motors}")
        if outside := self._outside_limits(positions):
            self.refuse(outside)

    def _outside_limits(self, positions: Sequence[float]) -> str:
        """First position beyond the limits, and the limits; empty where there is none."""
        limits = self._limits
        for number, position in enumerate(positions, 1):
            if not limits.position_min <= position <= limits.position_max:  # also false for NaN
                span = f"{limits.position_min:g} to {limits.position_max:g} rad"
                return f"motor_{number} = {position:g} rad: must be within {span}"
        return ""
