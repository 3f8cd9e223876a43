# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Every frame of the bus to its channel."""

from collections.abc import Iterator

from vsa_driver.acquisition.calibration import take_tares
from vsa_driver.acquisition.channel import Channel, JointChannel, MotorChannel, Sample, TransmissionChannel
from vsa_driver.acquisition.commands import CommandFrames
from vsa_driver.acquisition.mapping import Source, sources
from vsa_driver.acquisition.stream import COUNTER
from vsa_driver.can.bus import Frame
from vsa_driver.can.frames import FrameSet
from vsa_driver.settings import DriverSettings, MotorSettings

_EXTENDED = 1 << 31  # separates 29-bit identifiers from 11-bit ones


class Router:
    """Frames in, samples out, by the mapping of the parameters. Raises ConfigurationError for an invalid mapping."""

    def __init__(self, frames: FrameSet, settings: DriverSettings) -> None:
        self.unmapped_frames = 0  # frames whose identifier has no channel
        self.error_frames = 0  # reported by the adapter
        self.transmissions = {name: TransmissionChannel(name, settings, frames) for name in settings.transmissions}
        self.joint = [JointChannel(source, settings.joint) for source in _joint_sources(frames, settings)]
        motors = _motor_sources(frames, settings.motors)
        self.motors = MotorChannel(motors, settings.motors) if motors else None
        self.commands = CommandFrames(frames, settings.motors) if any(settings.motors.command_signals) else None
        self._routes: dict[int, list[tuple[Channel, int]]] = {}
        for channel in self._channels():
            for index, source in enumerate(channel.stream.sources):
                key = _key(source.message.id, source.message.extended)
                self._routes.setdefault(key, []).append((channel, index))
        if self.commands is not None:  # a multicast socket receives what it sends
            message = self.commands.source.message
            self._routes.setdefault(_key(message.id, message.extended), [])

    def set_limits(self, settings: DriverSettings) -> None:
        """Apply the tunable parameters of other settings."""
        for channel in self.transmissions.values():
            channel.set_limits(settings)

    def take_tares(self) -> dict[str, float]:
        """Tare the force sensors of all transmissions, or none; offset of each [N]. Raises TareError."""
        offsets = take_tares([channel.tare for channel in self.transmissions.values()])
        return dict(zip(self.transmissions, offsets, strict=True))

    def keep_tares(self, former: "Router") -> list[str]:
        """Take over the tares of another router; transmissions whose tare has to be discarded."""
        pairs = {name: (self.transmissions.get(name), channel) for name, channel in former.transmissions.items()}
        lost = [name for name, (own, channel) in pairs.items() if own is None or not own.keep_tare(channel)]
        return [name for name in lost if former.transmissions[name].tare.offset != 0.0]

    def add(self, frame: Frame, stamp_ns: int) -> list[Sample]:
        """The samples that `frame`, captured at `stamp_ns`, completes."""
        if frame.is_error_frame:
            self.error_frames += 1
            return []
        routes = self._routes.get(_key(frame.arbitration_id, frame.is_extended_id))
        if routes is None:
            self.unmapped_frames += 1
            return []
        data = bytes(frame.data)
        samples = [channel.add(index, data, stamp_ns) for channel, index in routes]
        return [sample for sample in samples if sample is not None]

    def counts(self) -> dict[str, int]:
        """Counters of the frames that no channel has; each channel has its own."""
        return {"unmapped_frames": self.unmapped_frames, "error_frames": self.error_frames}

    def _channels(self) -> Iterator[Channel]:
        yield from self.transmissions.values()
        yield from self.joint
        if self.motors is not None:
            yield self.motors


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
    signals = enumerate(settings.position_signals, 1)
    roles = {f"motor_{i}": ("motors.position_signals", signal) for i, signal in signals}
    roles["holding"] = ("motors.holding_signal", settings.holding_signal)
    return sources(frames, roles | {COUNTER: ("motors.counter_signal", settings.counter_signal)})
