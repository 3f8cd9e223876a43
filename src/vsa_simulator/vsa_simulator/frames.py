# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Frames that the simulated rig sends and receives, by config/vsa_rig.dbc."""

from vsa_driver.can.frames import FrameSet, Message
from vsa_simulator.faults.injection import TxFrame


class RigFrames:
    """Encodes readings and decodes commands. Raises FrameError for a DBC without these messages."""

    def __init__(self, frames: FrameSet) -> None:
        self._transmissions = (frames.message("Transmission1"), frames.message("Transmission2"))
        self._joint = frames.message("Joint")
        self._motors = frames.message("MotorState")
        command = frames.message("MotorCommand")
        self.command_id = command.id
        self.read_command = command.reader("Position1", "Position2")  # [rad]
        self._counters = {
            message.id: 1 << message.signal("RollingCounter").bits
            for message in (*self._transmissions, self._joint, self._motors)
        }
        self._ranges = {
            (message.id, name): _range(message, name)
            for message, names in (
                *((one, ("Force",)) for one in self._transmissions),
                (self._joint, ("Angle", "ExternalTorque")),
                (self._motors, ("Position1", "Position2")),
            )
            for name in names
        }

    @property
    def sent_ids(self) -> tuple[int, ...]:
        """Identifiers of the frames that the rig sends."""
        return tuple(self._counters)

    def transmission(self, side: int, sequence: int, force: float, count: int) -> TxFrame:
        """Frame of transmission `side`, 0 or 1: force [N], encoder count, sequence number."""
        message = self._transmissions[side]
        values = {"Force": self._clip(message, "Force", force), "EncoderCount": count}
        return TxFrame(message.id, message.encode(values | {"RollingCounter": sequence % self._counters[message.id]}))

    def joint(self, sequence: int, angle: float, torque: float) -> TxFrame:
        """Frame of the shaft: angle [rad], external torque [N m], sequence number of this frame."""
        message = self._joint
        values = {"Angle": self._clip(message, "Angle", angle)}
        values["ExternalTorque"] = self._clip(message, "ExternalTorque", torque)
        return TxFrame(message.id, message.encode(values | {"RollingCounter": sequence % self._counters[message.id]}))

    def motors(self, sequence: int, positions: tuple[float, float], holding: bool) -> TxFrame:
        """Frame of the motors: positions [rad], whether the watchdog holds them, sequence number of this frame."""
        message = self._motors
        values = {f"Position{i}": self._clip(message, f"Position{i}", p) for i, p in enumerate(positions, 1)}
        values |= {"WatchdogHolding": int(holding), "RollingCounter": sequence % self._counters[message.id]}
        return TxFrame(message.id, message.encode(values))

    def _clip(self, message: Message, name: str, value: float) -> float:
        low, high = self._ranges[message.id, name]
        return min(max(value, low), high)


def _range(message: Message, name: str) -> tuple[float, float]:
    signal = message.signal(name)
    low, high = signal.minimum, signal.maximum
    return (float("-inf") if low is None else low, float("inf") if high is None else high)
