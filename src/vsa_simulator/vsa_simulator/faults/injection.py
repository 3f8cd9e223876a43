"""What failures do to readings and frames; pure, counted in samples.

A failure is told to `Faults`; from then on every reading and every frame passes through it.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from vsa_simulator.faults.failure import Failure
from vsa_simulator.rig.config import SensorConfig
from vsa_simulator.rig.sensors import ENCODER_COUNTS, Readings

BUS_OFF = 0x40  # identifier of the error frame, CAN_ERR_BUSOFF of <linux/can/error.h>
TRAVEL = 0.020  # deflection at which an encoder is at its end [m]

_SENSORS = (("force", 1), ("force", 2), ("encoder", 1), ("encoder", 2), ("angle", 1), ("torque", 1))


class Outgoing(NamedTuple):
    """A frame to send."""

    arbitration_id: int
    data: bytes
    error: bool = False


class _Active:
    """A failure at work: since which sample, until which, and what it remembers."""

    def __init__(self, failure: Failure, sample: int, rate_hz: int) -> None:
        self.failure = failure
        self.since = sample
        self.until = sample + (1.0 if failure.kind == "spike" else failure.duration * rate_hz)
        self.values: dict[int, float] = {}  # of each instance
        self.past: dict[int, deque[float]] = {}
        self.frames: dict[int, deque[tuple[int, Outgoing]]] = {}
        self.frame: dict[int, Outgoing] = {}


class Faults:
    """The failures at work on one rig."""

    def __init__(self, rate_hz: int, sensors: SensorConfig, seed: int) -> None:
        self._rate_hz = rate_hz
        self._random = np.random.default_rng([seed, 1])
        self._active: list[_Active] = []
        self._released: dict[int, list[Outgoing]] = {}  # frames that a failure held when it ended
        counts = sensors.deflection_resolution
        self._scale = {"force": 1.0, "encoder": 1.0 / counts, "angle": 1.0, "torque": 1.0}  # unit of the reading
        self._noise = {
            "force": sensors.force_noise_std,
            "encoder": sensors.deflection_noise_std / counts,
            "angle": sensors.angle_noise_std,
            "torque": sensors.torque_noise_std,
        }
        self._full = {
            "force": sensors.force_range,
            "encoder": sensors.encoder_start + TRAVEL / counts,
            "angle": math.pi,
            "torque": 80.0,
        }

    @property
    def active(self) -> tuple[Failure, ...]:
        """Failures at work, the oldest first."""
        return tuple(active.failure for active in self._active)

    def inject(self, failure: Failure, sample: int) -> None:
        """Begin `failure` with the next reading or frame of `sample`; `ok` ends those of its component."""
        if failure.kind == "ok":
            for active in [a for a in self._active if _overlap(a.failure, failure)]:
                self._end(active)
        else:
            self._active.append(_Active(failure, sample, self._rate_hz))

    def expire(self, sample: int) -> None:
        """End the failures whose time is over."""
        for active in [a for a in self._active if sample >= a.until]:
            self._end(active)

    def readings(self, readings: Readings, sample: int) -> tuple[float, ...]:
        """What the sensors say of one sample: forces [N], encoder counts, angle [rad], torque [N m]."""
        said = (*readings.forces[0].tolist(), *readings.counts[0].tolist(), readings.angle[0], readings.torque[0])
        if not self._active:
            return said
        return tuple(
            self.reading(component, instance, value, sample)
            for (component, instance), value in zip(_SENSORS, said, strict=True)
        )

    def reading(self, component: str, instance: int, value: float, sample: int) -> float:
        """What the sensor says instead of `value`, in the unit of the reading: N, counts, rad, N m."""
        for active in self._active:
            if active.failure.matches(component, instance):
                value = self._failed(active, component, instance, value, sample)
        return float(round(value) % ENCODER_COUNTS) if component == "encoder" else value

    def frames(self, instance: int, frame: Outgoing, sample: int) -> list[Outgoing]:
        """What goes onto the bus instead of `frame` of transmission `instance`; 0 is a frame of joint or motors."""
        if not self._active and not self._released:
            return [frame]
        going = [] if self.silent and not instance else [frame]
        for active in self._active:
            if instance and active.failure.matches("can_signal", instance):
                going = [out for one in going for out in self._failed_frame(active, instance, one, sample)]
        return self._released.pop(instance, []) + going

    @property
    def silent(self) -> bool:
        """Whether nothing at all may go onto the bus: it is off."""
        return any(active.failure.kind == "bus_off" for active in self._active)

    def _end(self, active: _Active) -> None:
        self._active.remove(active)
        for instance, held in active.frames.items():
            self._released.setdefault(instance, []).extend(frame for _, frame in held)

    def _failed(self, active: _Active, component: str, instance: int, value: float, sample: int) -> float:
        kind, amount = active.failure.kind, active.failure.value
        scale, age = self._scale[component], sample - active.since
        if kind == "off":
            return 0.0
        if kind == "stuck":
            return active.values.setdefault(instance, value)
        if kind == "garbage":
            whole = ENCODER_COUNTS if component == "encoder" else 2.0 * self._full[component]
            return self._random.uniform(0.0, whole) - (0.0 if component == "encoder" else 0.5 * whole)
        if kind == "wrong":
            return value + amount * scale
        if kind == "slow":
            if age % round(amount) == 0:
                active.values[instance] = value
            return active.values.setdefault(instance, value)
        if kind == "delayed":
            past = active.past.setdefault(instance, deque())
            past.append(value)
            return past.popleft() if len(past) > round(amount * self._rate_hz) else past[0]
        if kind == "intermittent":
            return 0.0 if self._random.random() < amount else value
        if kind == "spike":
            return value + amount * scale if age == 0 else value
        if kind == "drift":
            return value + amount * scale * age / self._rate_hz
        if kind == "noise":
            return value + self._random.normal() * self._noise[component] * math.sqrt(max(0.0, amount**2 - 1.0))
        if kind == "saturated":
            return self._full[component]
        return value + active.values.setdefault(instance, ENCODER_COUNTS - 1 - value)  # wrap

    def _failed_frame(self, active: _Active, instance: int, frame: Outgoing, sample: int) -> list[Outgoing]:
        kind, amount, age = active.failure.kind, active.failure.value, sample - active.since
        if kind == "off":
            return []
        if kind == "bus_off":
            return [] if active.frame else [active.frame.setdefault(instance, Outgoing(BUS_OFF, bytes(8), error=True))]
        if kind == "stuck":
            return [active.frame.setdefault(instance, frame)]
        if kind == "garbage":
            return [frame._replace(data=self._random.bytes(int(self._random.integers(0, 9))))]
        if kind == "slow":
            return [frame] if age % round(amount) == 0 else []
        if kind == "intermittent":
            return [] if self._random.random() < amount else [frame]
        if kind == "duplicate":
            return [frame, frame]
        held = active.frames.setdefault(instance, deque())
        if kind == "delayed":
            held.append((sample + round(amount * self._rate_hz), frame))
            return [held.popleft()[1] for _ in range(sum(due <= sample for due, _ in held))]
        if not held:  # reordered
            held.append((sample, frame))
            return []
        return [frame, held.popleft()[1]]


def _overlap(one: Failure, other: Failure) -> bool:
    return one.component == other.component and (other.instance in (0, one.instance) or one.instance == 0)
