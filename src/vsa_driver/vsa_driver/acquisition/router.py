"""Every frame of the bus to what it is for."""

from collections.abc import Iterator

from vsa_common.config.configuration import ConfigurationError
from vsa_driver.acquisition.channel import (
    JointCapture,
    JointSample,
    Measurement,
    MotorCapture,
    MotorSample,
    TransmissionCapture,
)
from vsa_driver.acquisition.mapping import Source, sources
from vsa_driver.acquisition.stream import COUNTER
from vsa_driver.can.bus import Frame
from vsa_driver.can.frames import FrameError, FrameSet
from vsa_driver.settings import DriverSettings, MotorSettings

Captured = Measurement | JointSample | MotorSample
Part = TransmissionCapture | JointCapture | MotorCapture

_EXTENDED = 1 << 31  # sets 29-bit identifiers apart from 11-bit ones


class Router:
    """Frames in, samples out, by the mapping of the parameters. Raises ConfigurationError for a mapping that fails."""

    def __init__(self, frames: FrameSet, settings: DriverSettings) -> None:
        self.foreign = 0  # frames of identifiers that nothing is mapped to
        self.error_frames = 0  # that the adapter reported
        self.transmissions = {
            name: TransmissionCapture(name, settings.transmission(name), frames, settings.tare_spread)
            for name in settings.transmissions
        }
        self.joint = [JointCapture(source, settings.joint) for source in _joint_sources(frames, settings)]
        motors = _motor_sources(frames, settings.motors)
        self.motors = MotorCapture(motors, settings.motors) if motors else None
        self.commands = CommandFrames(frames, settings.motors) if any(settings.motors.command_signals) else None
        self._routes: dict[int, list[tuple[Part, int]]] = {}
        for part in self._parts():
            for index, source in enumerate(part.stream.sources):
                self._routes.setdefault(_key(source.message.id, source.message.extended), []).append((part, index))
        if self.commands is not None:  # a multicast socket hears what it sends itself
            message = self.commands.source.message
            self._routes.setdefault(_key(message.id, message.extended), [])

    def add(self, frame: Frame, stamp_ns: int) -> list[Captured]:
        """The samples that `frame`, captured at `stamp_ns`, completes."""
        if frame.is_error_frame:
            self.error_frames += 1
            return []
        routes = self._routes.get(_key(frame.arbitration_id, frame.is_extended_id))
        if routes is None:
            self.foreign += 1
            return []
        data = bytes(frame.data)
        samples = [part.add(index, data, stamp_ns) for part, index in routes]
        return [sample for sample in samples if sample is not None]

    def counts(self) -> dict[str, int]:
        """Everything counted, by "part.name"."""
        counted = {"foreign": self.foreign, "error_frames": self.error_frames}
        for part in self._parts():
            counted |= {f"{_name(part)}.{name}": count for name, count in part.counts().items()}
        return counted

    def _parts(self) -> Iterator[Part]:
        yield from self.transmissions.values()
        yield from self.joint
        if self.motors is not None:
            yield self.motors


class CommandFrames:
    """Motor positions to the bytes of the command message, numbered."""

    def __init__(self, frames: FrameSet, settings: MotorSettings) -> None:
        signals = zip(settings.names, settings.command_signals, strict=True)
        roles = {name: ("motors.command_signals", signal) for name, signal in signals}
        found = sources(frames, roles | {COUNTER: ("motors.command_counter_signal", settings.command_counter_signal)})
        if len(found) != 1:
            given = list(settings.command_signals)
            raise ConfigurationError(f"motors.command_signals = {given!r}: must be signals of one message")
        self.source = found[0]
        self._scale = settings.scale
        self._number = 0
        self._modulus = 1 << self.source.signal(COUNTER).bits if COUNTER in self.source.roles else 1
        try:
            self.encode([0.0] * len(settings.names))
        except FrameError as error:
            raise ConfigurationError(f"motors.command_signals: {error}") from error

    def encode(self, positions: list[float] | tuple[float, ...]) -> bytes:
        """The next command frame for `positions` [rad]. Raises FrameError for what the signals cannot carry."""
        values = [*(position / self._scale for position in positions), self._number % self._modulus]
        named = zip((signal.name for signal in self.source.signals), values, strict=False)
        data = self.source.message.encode(dict(named))
        self._number += 1
        return data


def _key(identifier: int, extended: bool) -> int:
    return identifier | _EXTENDED if extended else identifier


def _joint_sources(frames: FrameSet, settings: DriverSettings) -> tuple[Source, ...]:
    joint = settings.joint
    fields = {"angle": "angle_signal", "torque": "torque_signal", COUNTER: "counter_signal"}
    found = sources(frames, {role: (f"joint.{field}", getattr(joint, field)) for role, field in fields.items()})
    return tuple(source for source in found if source.roles != (COUNTER,))


def _motor_sources(frames: FrameSet, settings: MotorSettings) -> tuple[Source, ...]:
    if not any(settings.position_signals):
        return ()
    signals = zip(settings.names, settings.position_signals, strict=True)
    roles = {name: ("motors.position_signals", signal) for name, signal in signals}
    roles["holding"] = ("motors.holding_signal", settings.holding_signal)
    return sources(frames, roles | {COUNTER: ("motors.counter_signal", settings.counter_signal)})


def _name(part: Part) -> str:
    if isinstance(part, TransmissionCapture):
        return part.name
    return part.stream.sources[0].message.name
