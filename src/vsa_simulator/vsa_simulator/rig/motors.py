# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Commands of the motors and their watchdog; time is an argument, seconds since the start."""

Positions = tuple[float, float]  # [rad]


class CommandWatchdog:
    """The command that the motors follow; without a command for `timeout` [s] they hold their position."""

    def __init__(self, timeout: float) -> None:
        self.holding = False
        self._timeout = timeout
        self._command: Positions | None = None
        self._commanded_at = 0.0

    def command(self, time: float, positions: Positions) -> None:
        """Take a command [rad] and release a hold."""
        self._command, self._commanded_at, self.holding = positions, time, False

    def update(self, time: float, positions: Positions) -> Positions | None:
        """Hold motors at `positions` if commands have timed out; the target [rad], None before the first command."""
        timed_out = time - self._commanded_at > self._timeout
        if self._command is not None and timed_out and not self.holding:
            self._command, self.holding = positions, True
        return self._command
