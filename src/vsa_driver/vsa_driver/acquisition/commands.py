# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motor commands to frames."""

from vsa_common.config.configuration import ConfigurationError
from vsa_driver.acquisition.mapping import sources
from vsa_driver.acquisition.stream import COUNTER
from vsa_driver.can.frames import FrameError, FrameSet
from vsa_driver.settings import MotorSettings


class CommandFrames:
    """Encodes motor positions as numbered frames of the command message. Raises ConfigurationError."""

    def __init__(self, frames: FrameSet, settings: MotorSettings) -> None:
        signals = enumerate(settings.command_signals, 1)
        roles = {f"motor_{i}": ("motors.command_signals", signal) for i, signal in signals}
        found = sources(frames, roles | {COUNTER: ("motors.command_counter_signal", settings.command_counter_signal)})
        if len(found) != 1:
            given = list(settings.command_signals)
            raise ConfigurationError(f"motors.command_signals = {given!r}: must be signals of one message")
        self.source = found[0]
        self._scale = settings.scale
        self._sequence = 0
        self._modulus = 1 << self.source.signal(COUNTER).bits if COUNTER in self.source.roles else 1
        try:
            self.encode([0.0] * len(settings.names))
        except FrameError as error:
            raise ConfigurationError(f"motors.command_signals: {error}") from error

    def encode(self, positions: list[float] | tuple[float, ...]) -> bytes:
        """The next command frame for `positions` [rad]. Raises FrameError for values beyond the signals' range."""
        values = [*(position / self._scale for position in positions), self._sequence % self._modulus]
        named = zip((signal.name for signal in self.source.signals), values, strict=False)
        data = self.source.message.encode(dict(named))
        self._sequence += 1
        return data
