# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Effect of failures on readings and frames; no I/O, time is counted in samples."""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from vsa_simulator.faults.failure import Failure
from vsa_simulator.rig.config import SensorConfig
from vsa_simulator.rig.sensors import ENCODER_COUNTS, Readings

BUS_OFF = 0x40  # identifier of the error frame, CAN_ERR_BUSOFF of <linux/can/error.h>
TRAVEL = 0.020  # deflection at which an encoder saturates [m]
TORQUE_RANGE = 80.0  # torque at which the sensor saturates [N m]

_SENSORS = (("force", 1), ("force", 2), ("encoder", 1), ("encoder", 2), ("angle", 1), ("torque", 1))


class TxFrame(NamedTuple):
    """A frame to send."""

    arbitration_id: int
    data: bytes
    error: bool = False


class _Active:
    """An active failure: its first sample, its end, and the values and frames that it holds, by instance."""

    def __init__(self, failure: Failure, sample: int, rate_hz: int) -> None:
        self.failure = failure
        self.since = sample
        self.until = sample + (1.0 if failure.kind == "spike" else failure.duration * rate_hz)
        self.values: dict[int, float] = {}
        self.delayed_values: dict[int, deque[float]] = {}
        self.frame: dict[int, TxFrame] = {}
        self.held_frames: dict[int, deque[tuple[int, TxFrame]]] = {}


class Faults:
    """The active failures of one rig; every reading and every frame passes through them."""

    def __init__(self, rate_hz: int, sensors: SensorConfig, seed: int) -> None:
        self._rate_hz = rate_hz
        self._random = np.random.default_rng([seed, 1])
        self._active: list[_Active] = []
        self._released: dict[int, list[TxFrame]] = {}  # frames held by a failure that has ended
        counts = sensors.deflection_resolution
        self._scale = {"force": 1.0, "encoder": 1.0 / counts, "angle": 1.0, "torque": 1.0}  # readings per SI unit
        self._noise = {
            "force": sensors.force_noise_std,
            "encoder": sensors.deflection_noise_std / counts,
            "angle": sensors.angle_noise_std,
            "torque": sensors.torque_noise_std,
        }
        self._full_scale = {
            "force": sensors.force_range,
            "encoder": sensors.encoder_start + TRAVEL / counts,
            "angle": math.pi,
            "torque": TORQUE_RANGE,
        }

    @property
    def active(self) -> tuple[Failure, ...]:
        """Active failures, the oldest first."""
        return tuple(active.failure for active in self._active)

    @property
    def bus_off(self) -> bool:
        """Whether no frame may be sent or received."""
        return any(active.failure.kind == "bus_off" for active in self._active)

    def inject(self, failure: Failure, sample: int) -> None:
        """Start `failure` with the next reading or frame of `sample`; `ok` ends those of its component."""
        if failure.kind == "ok":
            for active in [a for a in self._active if _overlap(a.failure, failure)]:
                self._end(active)
        else:
            self._active.append(_Active(failure, sample, self._rate_hz))

    def expire(self, sample: int) -> None:
        """End the failures whose duration is over."""
        for active in [a for a in self._active if sample >= a.until]:
            self._end(active)

    def readings(self, readings: Readings, sample: int) -> tuple[float, ...]:
        """Faulty readings of one sample: forces [N], encoder counts, angle [rad], torque [N m]."""
        values = (*readings.forces[0].tolist(), *readings.counts[0].tolist(), readings.angle[0], readings.torque[0])
        if not self._active:
            return values
        return tuple(
            self.reading(component, instance, value, sample)
            for (component, instance), value in zip(_SENSORS, values, strict=True)
        )

    def reading(self, component: str, instance: int, value: float, sample: int) -> float:
        """The faulty reading in place of `value`, in the unit of the reading: N, counts, rad, N m."""
        for active in self._active:
            if active.failure.matches(component, instance):
                value = self._faulty_value(active, component, instance, value, sample)
        return float(round(value) % ENCODER_COUNTS) if component == "encoder" else value

    def frames(self, instance: int, frame: TxFrame, sample: int) -> list[TxFrame]:
        """The frames to send in place of `frame` of transmission `instance`; 0 is a frame of joint or motors."""
        if not self._active and not self._released:
            return [frame]
        to_send = [] if self.bus_off and not instance else [frame]
        for active in self._active:
            if instance and active.failure.matches("can_signal", instance):
                to_send = [out for one in to_send for out in self._faulty_frames(active, instance, one, sample)]
        return self._released.pop(instance, []) + to_send

    def _end(self, active: _Active) -> None:
        self._active.remove(active)
        for instance, held in active.held_frames.items():
            self._released.setdefault(instance, []).extend(frame for _, frame in held)

    def _faulty_value(self, active: _Active, component: str, instance: int, value: float, sample: int) -> float:
        kind, amount = active.failure.kind, active.failure.value
        scale, age = self._scale[component], sample - active.since
        if kind == "off":
            return 0.0
        if kind == "stuck":
            return active.values.setdefault(instance, value)
        if kind == "garbage":
            span = ENCODER_COUNTS if component == "encoder" else 2.0 * self._full_scale[component]
            return self._random.uniform(0.0, span) - (0.0 if component == "encoder" else 0.5 * span)
        if kind == "wrong":
            return value + amount * scale
        if kind == "slow":
            if age % round(amount) == 0:
                active.values[instance] = value
            return active.values.setdefault(instance, value)
        if kind == "delayed":
            queue = active.delayed_values.setdefault(instance, deque())
            queue.append(value)
            return queue.popleft() if len(queue) > round(amount * self._rate_hz) else queue[0]
        if kind == "intermittent":
            return 0.0 if self._random.random() < amount else value
        if kind == "spike":
            return value + amount * scale if age == 0 else value
        if kind == "drift":
            return value + amount * scale * age / self._rate_hz
        if kind == "noise":
            return value + self._random.normal() * self._noise[component] * math.sqrt(max(0.0, amount**2 - 1.0))
        if kind == "saturated":
            return self._full_scale[component]
        return value + active.values.setdefault(instance, ENCODER_COUNTS - 1 - value)  # wrap

    def _faulty_frames(self, active: _Active, instance: int, frame: TxFrame, sample: int) -> list[TxFrame]:
        kind, amount, age = active.failure.kind, active.failure.value, sample - active.since
        if kind == "off":
            return []
        if kind == "bus_off":
            return [] if active.frame else [active.frame.setdefault(instance, TxFrame(BUS_OFF, bytes(8), error=True))]
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
        held = active.held_frames.setdefault(instance, deque())
        if kind == "delayed":
            held.append((sample + round(amount * self._rate_hz), frame))
            return [held.popleft()[1] for _ in range(sum(due <= sample for due, _ in held))]
        if not held:  # reordered
            held.append((sample, frame))
            return []
        return [frame, held.popleft()[1]]


def _overlap(one: Failure, other: Failure) -> bool:
    return one.component == other.component and (other.instance in (0, one.instance) or one.instance == 0)
