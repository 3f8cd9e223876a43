"""From readings to samples in SI: transmissions, joint and motors."""

from typing import NamedTuple

from vsa_driver.acquisition.calibration import Calibration, Tare
from vsa_driver.acquisition.counter import Unwrapped
from vsa_driver.acquisition.mapping import Source, sources
from vsa_driver.acquisition.stream import COUNTER, Reading, Stream
from vsa_driver.can.frames import FrameSet
from vsa_driver.settings import JointSettings, MotorSettings, TransmissionSettings


class Measurement(NamedTuple):
    """One sample of a transmission."""

    transmission: str
    stamp_ns: int
    number: int  # of the sample, by the device's rolling counter
    force: float  # [N]
    deflection: float  # [m]


class JointSample(NamedTuple):
    """What one frame says of the joint's shaft; None is not measured."""

    stamp_ns: int
    angle: float | None  # [rad]
    torque: float | None  # [N m]


class MotorSample(NamedTuple):
    """Where the motors are."""

    stamp_ns: int
    positions: tuple[float, ...]  # [rad]
    holding: bool  # the device's watchdog holds


class TransmissionCapture:
    """Samples of one transmission, calibrated."""

    def __init__(self, name: str, settings: TransmissionSettings, frames: FrameSet, tare_spread: float) -> None:
        roles = {"force": "force_signal", "encoder": "encoder_signal", COUNTER: "counter_signal"}
        wanted = {role: (f"{name}.{field}", getattr(settings, field)) for role, field in roles.items()}
        self.name = name
        self.stream = Stream(sources(frames, wanted, needed=("force", "encoder")))
        self.tare = Tare(tare_spread)
        self.force_saturated = 0
        self.deflection_saturated = 0
        self._settings = settings
        self._force = Calibration.of(settings.force_scale, settings.force_offset, settings.force_reversed)
        self._deflection = Calibration.of(settings.encoder_scale, settings.encoder_offset, settings.encoder_reversed)
        self._force_index, self._encoder_index = (self.stream.roles.index(role) for role in ("force", "encoder"))
        signal = next(part.signal("encoder") for part in self.stream.sources if "encoder" in part.roles)
        middle = (settings.deflection_min + settings.deflection_max) / 2
        ends = [self._deflection.inverse(end) for end in (settings.deflection_min, settings.deflection_max)]
        self._count = Unwrapped(
            period=signal.step * 2.0 ** (settings.encoder_bits or signal.bits),
            centre=self._deflection.inverse(middle),
            reach=abs(ends[1] - ends[0]),
        )

    def add(self, index: int, data: bytes, stamp_ns: int) -> Measurement | None:
        """Take a frame of message `index` of `stream.sources`."""
        reading = self.stream.add(index, data, stamp_ns)
        if reading is None:
            return None
        force = self._force(reading.values[self._force_index])
        deflection = self._deflection(self._count.add(reading.values[self._encoder_index]))
        self.force_saturated += abs(force) >= self._settings.force_limit
        self.deflection_saturated += not self._settings.deflection_min <= deflection <= self._settings.deflection_max
        return Measurement(self.name, reading.stamp_ns, reading.number, self.tare.add(force), deflection)

    def counts(self) -> dict[str, int]:
        """Everything counted, by name."""
        own = {"force_saturated": self.force_saturated, "deflection_saturated": self.deflection_saturated}
        return self.stream.counts() | own


class JointCapture:
    """What one message says of the joint."""

    def __init__(self, source: Source, settings: JointSettings) -> None:
        self.stream = Stream((source,))
        self._scales = {"angle": settings.angle_scale, "torque": settings.torque_scale}

    def add(self, index: int, data: bytes, stamp_ns: int) -> JointSample | None:
        """Take a frame."""
        reading = self.stream.add(index, data, stamp_ns)
        if reading is None:
            return None
        angle, torque = (self._value(role, reading) for role in ("angle", "torque"))
        return JointSample(reading.stamp_ns, angle, torque)

    def counts(self) -> dict[str, int]:
        """Everything counted, by name."""
        return self.stream.counts()

    def _value(self, role: str, reading: Reading) -> float | None:
        if role not in self.stream.roles:
            return None
        return self._scales[role] * reading.values[self.stream.roles.index(role)]


class MotorCapture:
    """Positions of the motors."""

    def __init__(self, parts: tuple[Source, ...], settings: MotorSettings) -> None:
        self.stream = Stream(parts)
        self._scale = settings.scale
        roles = self.stream.roles
        self._positions = [roles.index(role) for role in sorted(roles) if role.startswith("motor_")]
        self._holding = roles.index("holding") if "holding" in roles else -1

    def add(self, index: int, data: bytes, stamp_ns: int) -> MotorSample | None:
        """Take a frame."""
        reading = self.stream.add(index, data, stamp_ns)
        if reading is None:
            return None
        positions = tuple([self._scale * reading.values[i] for i in self._positions])
        return MotorSample(reading.stamp_ns, positions, self._holding >= 0 and bool(reading.values[self._holding]))

    def counts(self) -> dict[str, int]:
        """Everything counted, by name."""
        return self.stream.counts()
