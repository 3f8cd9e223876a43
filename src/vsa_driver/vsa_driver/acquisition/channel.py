# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Readings to samples in SI: one channel for each transmission, the joint and the motors."""

from typing import NamedTuple

from vsa_driver.acquisition.calibration import Calibration, Tare
from vsa_driver.acquisition.counter import Unwrapped
from vsa_driver.acquisition.mapping import Source, sources
from vsa_driver.acquisition.stream import COUNTER, Reading, Stream
from vsa_driver.can.frames import FrameSet
from vsa_driver.settings import DriverSettings, JointSettings, MotorSettings


class Measurement(NamedTuple):
    """One sample of a transmission."""

    transmission: str
    stamp_ns: int
    sequence: int | None  # by the device's rolling counter; None without one
    force: float  # [N]
    deflection: float  # [m]


class JointSample(NamedTuple):
    """One sample of the joint's shaft; None is not measured."""

    stamp_ns: int
    angle: float | None  # [rad]
    torque: float | None  # [N m]


class MotorSample(NamedTuple):
    """One sample of the motors."""

    stamp_ns: int
    positions: tuple[float, ...]  # [rad]
    holding: bool  # the device's watchdog holds the motors


class TransmissionChannel:
    """Calibrated samples of one transmission."""

    def __init__(self, name: str, settings: DriverSettings, frames: FrameSet) -> None:
        own = settings.transmission(name)
        roles = {"force": "force_signal", "encoder": "encoder_signal", COUNTER: "counter_signal"}
        requested = {role: (f"{name}.{field}", getattr(own, field)) for role, field in roles.items()}
        self.name = name
        self.stream = Stream(sources(frames, requested, required=("force", "encoder")))
        self.tare = Tare(settings.tare_spread, int(settings.silence * 1e9))
        self.force_saturated = 0
        self.deflection_saturated = 0
        self._is_counted = COUNTER in self.stream.roles
        self._settings = own
        self._force = Calibration.of(own.force_scale, own.force_offset, own.force_reversed)
        self._deflection = Calibration.of(own.encoder_scale, own.encoder_offset, own.encoder_reversed)
        self._force_index, self._encoder_index = (self.stream.roles.index(role) for role in ("force", "encoder"))
        signal = next(source.signal("encoder") for source in self.stream.sources if "encoder" in source.roles)
        middle = (own.deflection_min + own.deflection_max) / 2
        ends = [self._deflection.inverse(end) for end in (own.deflection_min, own.deflection_max)]
        self._count = Unwrapped(
            period=signal.step * 2.0 ** (own.encoder_bits or signal.bits),
            centre=self._deflection.inverse(middle),
            max_travel=abs(ends[1] - ends[0]),
        )

    def set_limits(self, settings: DriverSettings) -> None:
        """Apply the tunable parameters of other settings."""
        self._settings = settings.transmission(self.name)
        self.tare.set_limits(settings.tare_spread, int(settings.silence * 1e9))

    def keep_tare(self, former: "TransmissionChannel") -> bool:
        """Take over the tare of another channel; whether its parameters, and with them its forces, are the same."""
        same = self._settings == former._settings
        if same:
            self.tare.offset = former.tare.offset
        return same

    def add(self, index: int, data: bytes, stamp_ns: int) -> Measurement | None:
        """Take a frame of message `index` of `stream.sources`; the sample that it completes."""
        reading = self.stream.add(index, data, stamp_ns)
        if reading is None:
            return None
        force = self._force(reading.values[self._force_index])
        deflection = self._deflection(self._count.add(reading.values[self._encoder_index]))
        self.force_saturated += abs(force) >= self._settings.force_limit
        self.deflection_saturated += not self._settings.deflection_min <= deflection <= self._settings.deflection_max
        stamp_ns, sequence = reading.stamp_ns, reading.sequence if self._is_counted else None
        return Measurement(self.name, stamp_ns, sequence, self.tare.add(stamp_ns, force), deflection)

    def counts(self) -> dict[str, int]:
        """All counters, by name."""
        own = {"force_saturated": self.force_saturated, "deflection_saturated": self.deflection_saturated}
        return self.stream.counts() | own


class JointChannel:
    """Samples of the joint's shaft from one message."""

    def __init__(self, source: Source, settings: JointSettings) -> None:
        self.name = source.message.name
        self.stream = Stream((source,))
        self._scales = {"angle": settings.angle_scale, "torque": settings.torque_scale}

    def add(self, index: int, data: bytes, stamp_ns: int) -> JointSample | None:
        """Take a frame; its sample."""
        reading = self.stream.add(index, data, stamp_ns)
        if reading is None:
            return None
        angle, torque = (self._value(role, reading) for role in ("angle", "torque"))
        return JointSample(reading.stamp_ns, angle, torque)

    def counts(self) -> dict[str, int]:
        """All counters, by name."""
        return self.stream.counts()

    def _value(self, role: str, reading: Reading) -> float | None:
        if role not in self.stream.roles:
            return None
        return self._scales[role] * reading.values[self.stream.roles.index(role)]


class MotorChannel:
    """Positions of the motors."""

    def __init__(self, motor_sources: tuple[Source, ...], settings: MotorSettings) -> None:
        self.name = motor_sources[0].message.name
        self.stream = Stream(motor_sources)
        self._scale = settings.scale
        roles = self.stream.roles
        self._positions = [roles.index(role) for role in sorted(roles) if role.startswith("motor_")]
        self._holding = roles.index("holding") if "holding" in roles else -1

    def add(self, index: int, data: bytes, stamp_ns: int) -> MotorSample | None:
        """Take a frame; the sample that it completes."""
        reading = self.stream.add(index, data, stamp_ns)
        if reading is None:
            return None
        positions = tuple([self._scale * reading.values[i] for i in self._positions])
        return MotorSample(reading.stamp_ns, positions, self._holding >= 0 and bool(reading.values[self._holding]))

    def counts(self) -> dict[str, int]:
        """All counters, by name."""
        return self.stream.counts()


Sample = Measurement | JointSample | MotorSample
Channel = TransmissionChannel | JointChannel | MotorChannel
