# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sensors of the rig: truth to readings, with noise, resolution, range, and counters that wrap."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.config import SensorConfig, SensorErrorConfig
from vsa_simulator.rig.dynamics import DEFLECTION, FORCE, JOINT_ANGLE, MOTOR_1, MOTOR_2, SIDE_COLUMNS, TORQUE
from vsa_simulator.rig.sensor_errors import NO_ERRORS, ForceErrors, encoder_error, oversampling

ENCODER_COUNTS = 1 << 16

# Columns of noise and readings; those of transmission 2 are one later.
_FORCE, _COUNT, _ANGLE, _TORQUE = 0, 2, 4, 5
_CHANNELS = 6
_DRAW = 4096  # samples whose noise is drawn in one call

_FORCES = [FORCE, FORCE + SIDE_COLUMNS]  # columns of truth
_DEFLECTIONS = [DEFLECTION, DEFLECTION + SIDE_COLUMNS]

RECORD = np.dtype([(name, float) for name in SensorConfig.__annotations__])


class Readings(NamedTuple):
    """Readings, a row a sample: forces [N], encoder counts, angle [rad], torque [N m], motor positions [rad]."""

    forces: Array
    counts: Array
    angle: Array
    torque: Array
    motors: Array


class Sensors:
    """Sensors with their own noise; blocks of any size give the same sequence.

    `read` expects `oversampling` rows of truth a sample, the first of them at the sample.
    """

    def __init__(self, config: SensorConfig, errors: SensorErrorConfig, rate_hz: float, seed: int) -> None:
        self.oversampling = oversampling(errors, rate_hz)
        self._errors = errors
        self._force_errors = ForceErrors(errors, rate_hz * self.oversampling)
        self._record = np.array([tuple(getattr(config, name) for name in RECORD.names or ())], RECORD)
        self._random = np.random.default_rng(seed)
        self._noise: Array = np.empty((0, _CHANNELS))
        self._used = 0

    def read(self, truth: Array) -> Readings:
        """Readings of rows of truth (columns as in `TRUTH`)."""
        sensed = truth if self._errors == NO_ERRORS else self._with_errors(truth)
        noise = self._draw(len(sensed))
        values = np.empty((len(sensed), _CHANNELS))
        _measure(sensed, noise, self._record, values)
        motors = sensed[:, MOTOR_1 : MOTOR_2 + 1]
        return Readings(values[:, 0:2], values[:, 2:4], values[:, _ANGLE], values[:, _TORQUE], motors)

    def _with_errors(self, truth: Array) -> Array:
        """The samples of `truth`, with systematic errors of forces and deflections."""
        sensed, forces = truth[:: self.oversampling].copy(), truth[:, _FORCES]
        sensed[:, _FORCES] = self._force_errors.apply(forces, forces[:, ::-1])[:: self.oversampling]
        sensed[:, _DEFLECTIONS] += encoder_error(sensed[:, _DEFLECTIONS], self._errors)
        return sensed

    def _draw(self, rows: int) -> Array:
        if self._used + rows > len(self._noise):
            fresh = self._random.standard_normal((max(rows, _DRAW), _CHANNELS))
            self._noise, self._used = np.concatenate([self._noise[self._used :], fresh]), 0
        self._used += rows
        return self._noise[self._used - rows : self._used]


@compiled
def _measure(truth: Array, noise: Array, record: NDArray[np.void], values: Array) -> None:
    sensors = record[0]
    resolution, full_scale = sensors["force_resolution"], sensors["force_range"]
    for i in range(truth.shape[0]):
        for side in range(2):
            offset = side * SIDE_COLUMNS
            force = truth[i, offset + FORCE] + sensors["force_noise_std"] * noise[i, _FORCE + side]
            if resolution > 0.0:
                force = round(force / resolution) * resolution
            values[i, _FORCE + side] = min(max(force, -full_scale), full_scale)
            deflection = truth[i, offset + DEFLECTION]
            deflection += sensors["deflection_noise_std"] * noise[i, _COUNT + side]
            count = math.floor(deflection / sensors["deflection_resolution"] + 0.5) + sensors["encoder_start"]
            values[i, _COUNT + side] = count % ENCODER_COUNTS
        values[i, _ANGLE] = truth[i, JOINT_ANGLE] + sensors["angle_noise_std"] * noise[i, _ANGLE]
        values[i, _TORQUE] = truth[i, TORQUE] + sensors["torque_noise_std"] * noise[i, _TORQUE]
