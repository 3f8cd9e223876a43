# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings of one transmission with any laws and sensors, beside their truth."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from vsa_common.config.configuration import group
from vsa_common.types import Array
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.rig import single_transmission as single
from vsa_simulator.rig.config import SensorConfig, SensorErrorConfig, TransmissionConfig
from vsa_simulator.rig.motion import Motion
from vsa_simulator.rig.sensor_errors import ForceErrors, encoder_error, oversampling

START_NS = 1_000_000_000  # stamp of the first sample


@dataclass(frozen=True)
class TransmissionVariant:
    """A transmission with its force laws, the sensors' noise and their systematic errors; the paper's by default.

    For example TransmissionVariant(laws=ForceLaws(spring=SpringConfig("quadratic"))).
    """

    transmission: TransmissionConfig = group(TransmissionConfig)
    laws: ForceLaws = group(ForceLaws)
    sensors: SensorConfig = group(SensorConfig)
    sensor_errors: SensorErrorConfig = group(SensorErrorConfig)
    stamp_jitter: float = 0.0  # standard deviation of the capture stamps [s]
    other_force: tuple[float, float, float] = (30.0, 10.0, 0.11)  # for crosstalk: mean [N], amplitude [N], [Hz]


@dataclass(frozen=True)
class Recording:
    """What the estimator gets: capture stamps [ns], measured force [N] and deflection [m], a row a sample."""

    stamp_ns: NDArray[np.int64]
    force: Array
    deflection: Array


class Simulation:
    """Truth of `duration` [s] of `motion` at `rate_hz`; `recording` measures it, with other noise for each seed.

    Stiffness is the slope of the static elastic law at the time, without viscoelastic branch and hysteresis; damping is
    the slope of the viscous force, without friction. Force and deflection are those before the sensors.
    """

    def __init__(self, variant: TransmissionVariant, motion: Motion, duration: float, rate_hz: int) -> None:
        self.variant, self.rate_hz = variant, rate_hz
        self._rows = oversampling(variant.sensor_errors, rate_hz)
        count = round(duration * rate_hz) / rate_hz
        self._fine = single.simulate(variant.transmission, motion, count, rate_hz * self._rows, variant.laws)
        truth = self._fine[:: self._rows]
        self.time: Array = truth[:, single.TIME]
        self.deflection: Array = truth[:, single.DEFLECTION]
        self.velocity: Array = truth[:, single.VELOCITY]
        self.acceleration: Array = truth[:, single.ACCELERATION]
        self.force: Array = truth[:, single.FORCE]
        self.stiffness: Array = truth[:, single.STIFFNESS]
        self.damping: Array = truth[:, single.DAMPING]
        self.inertia: float = variant.transmission.inertia

    @cached_property
    def sensed_force(self) -> Array:
        """Force at the sensor's output without noise [N]: with its systematic errors."""
        mean, amplitude, frequency = self.variant.other_force
        fine = self._fine[:, [single.FORCE]]
        other = mean + amplitude * np.sin(2.0 * np.pi * frequency * self._fine[:, [single.TIME]])
        errors = ForceErrors(self.variant.sensor_errors, float(self.rate_hz * self._rows), channels=1)
        return errors.apply(fine, other)[:: self._rows, 0]

    @cached_property
    def sensed_deflection(self) -> Array:
        """Deflection at the encoder's output without noise [m]: with its systematic error."""
        return self.deflection + encoder_error(self.deflection, self.variant.sensor_errors)

    def recording(self, seed: int) -> Recording:
        """The measurement with the noise of `seed`."""
        sensors, count = self.variant.sensors, len(self.time)
        random = np.random.default_rng(seed)
        force = self.sensed_force + sensors.force_noise_std * random.standard_normal(count)
        force = np.clip(_rounded(force, sensors.force_resolution), -sensors.force_range, sensors.force_range)
        deflection = self.sensed_deflection + sensors.deflection_noise_std * random.standard_normal(count)
        late = self.variant.stamp_jitter * random.standard_normal(count)
        late += self.variant.sensor_errors.frame_jitter * random.random(count)
        stamps = START_NS + np.round((self.time + late) * 1e9).astype(np.int64)
        return Recording(np.maximum.accumulate(stamps), force, _rounded(deflection, sensors.deflection_resolution))


def _rounded(value: Array, step: float) -> Array:
    return np.round(value / step) * step if step > 0.0 else value
