"""What stands between a controller and the motors: arming, limits, a watchdog."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

FRESH_S = 0.5  # age of a measured position at which arming is refused


class CommandRefused(ValueError):
    """A command or the wish to arm was refused; the text says why."""


@dataclass(frozen=True)
class MotorLimits:
    """Bounds on what reaches the motors."""

    position_min: float  # [rad]
    position_max: float  # [rad]
    speed_max: float  # [rad/s]
    timeout: float  # silence of the controller after which nothing is sent any more [s]


class MotorGate:
    """Lets commands through once armed: within position limits, no faster than the speed limit, only while they come.

    Armed, the motors are first told to stay where they are. When the controller falls silent nothing is sent, and
    the device's own watchdog holds. Times are of a steady clock.
    """

    def __init__(self, limits: MotorLimits, motors: int = 2) -> None:
        self.refused = 0  # commands
        self.slowed = 0  # frames that the speed limit held back
        self.timeouts = 0  # silences of the controller
        self.reason = "not armed yet"
        self._limits = limits
        self._motors = motors
        self._measured: tuple[float, ...] | None = None
        self._measured_s = -math.inf
        self._armed = False
        self._output: tuple[float, ...] = ()
        self._target: tuple[float, ...] = ()
        self._commanded_s = -math.inf
        self._stepped_s = -math.inf
        self._silent = False

    @property
    def armed(self) -> bool:
        """Whether commands are let through."""
        return self._armed

    @property
    def state(self) -> str:
        """`disarmed`, `armed`, or `holding` when armed and the controller is silent."""
        return "disarmed" if not self._armed else "holding" if self._silent else "armed"

    def measured(self, positions: Sequence[float], now_s: float) -> None:
        """Where the motors are [rad]."""
        self._measured, self._measured_s = tuple(positions), now_s

    def arm(self, now_s: float) -> None:
        """Let commands through from now on, beginning at the measured position. Raises CommandRefused."""
        if self._measured is None or now_s - self._measured_s > FRESH_S:
            raise CommandRefused("motor positions are not being received")
        self._target = self._output = self._measured
        self._commanded_s = self._stepped_s = now_s
        self._silent = False
        self.reason = ""
        self._armed = True

    def disarm(self, reason: str) -> None:
        """Let nothing through until armed again. Any thread may call this."""
        if self._armed:
            self.reason = reason
        self._armed = False

    def command(self, positions: Sequence[float], now_s: float) -> None:
        """Take a command [rad]. Raises CommandRefused, and holds the last one, for what must not reach a motor."""
        try:
            self._check(positions)
        except CommandRefused:
            self.refused += 1
            raise
        self._target, self._commanded_s = tuple(positions), now_s
        self._silent = False

    def step(self, now_s: float) -> tuple[float, ...] | None:
        """Positions [rad] to send now; None when nothing is to be sent."""
        if not self._armed or self._silent:
            return None
        if now_s - self._commanded_s > self._limits.timeout:
            self._silent = True
            self._target = self._output  # a later command starts from here, not from a wish that grew old
            self.timeouts += 1
            return None
        reach = self._limits.speed_max * min(max(now_s - self._stepped_s, 0.0), self._limits.timeout)
        self._stepped_s = now_s
        steps = [min(max(goal - here, -reach), reach) for goal, here in zip(self._target, self._output, strict=True)]
        self._output = tuple(here + step for here, step in zip(self._output, steps, strict=True))
        self.slowed += any(abs(step) == reach for step in steps)
        return self._output

    def _check(self, positions: Sequence[float]) -> None:
        if not self._armed:
            raise CommandRefused(f"not armed ({self.reason}); call the arm service first")
        if len(positions) != self._motors:
            raise CommandRefused(f"{len(positions)} positions, expected {self._motors}")
        for number, position in enumerate(positions, 1):
            if not self._limits.position_min <= position <= self._limits.position_max:  # also false for NaN
                limits = f"{self._limits.position_min:g} to {self._limits.position_max:g} rad"
                raise CommandRefused(f"motor_{number} = {position:g} rad: must be within {limits}")
