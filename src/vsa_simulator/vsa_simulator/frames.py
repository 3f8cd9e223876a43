"""The frames that the simulated rig sends and takes, as config/vsa_rig.dbc has them."""

from vsa_driver.can.frames import FrameSet, Message
from vsa_simulator.faults.injection import Outgoing


class RigFrames:
    """Readings to bytes, and the command's bytes to positions. Raises FrameError for a DBC without these messages."""

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
                (self._joint, ("Angle", "ExternalTorque")),
                (self._motors, ("Position1", "Position2")),
            )
            for name in names
        }

    @property
    def sent_ids(self) -> tuple[int, ...]:
        """Identifiers of the frames that the rig sends."""
        return tuple(self._counters)

    def transmission(self, side: int, sample: int, force: float, count: int) -> Outgoing:
        """Frame of transmission `side`, 0 or 1: force [N], encoder count, number of the sample."""
        message = self._transmissions[side]
        counter = sample % self._counters[message.id]
        return Outgoing(message.id, message.encode({"Force": force, "EncoderCount": count, "RollingCounter": counter}))

    def joint(self, number: int, angle: float, torque: float) -> Outgoing:
        """Frame of the shaft: angle [rad], external torque [N m], number of this frame."""
        message = self._joint
        values = {"Angle": self._within(message, "Angle", angle)}
        values["ExternalTorque"] = self._within(message, "ExternalTorque", torque)
        return Outgoing(message.id, message.encode(values | {"RollingCounter": number % self._counters[message.id]}))

    def motors(self, number: int, positions: tuple[float, float], holding: bool) -> Outgoing:
        """Frame of the motors: positions [rad], whether the watchdog holds them, number of this frame."""
        message = self._motors
        values = {f"Position{i}": self._within(message, f"Position{i}", p) for i, p in enumerate(positions, 1)}
        values |= {"WatchdogHolding": int(holding), "RollingCounter": number % self._counters[message.id]}
        return Outgoing(message.id, message.encode(values))

    def _within(self, message: Message, name: str, value: float) -> float:
        low, high = self._ranges[message.id, name]
        return min(max(value, low), high)


def _range(message: Message, name: str) -> tuple[float, float]:
    signal = message.signal(name)
    low, high = signal.minimum, signal.maximum
    return (float("-inf") if low is None else low, float("inf") if high is None else high)
