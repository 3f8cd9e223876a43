"""What the sensors make of the truth: noise, resolution, range, counters that wrap."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_driver.rig.config import SensorConfig
from vsa_driver.rig.dynamics import TRUTH

Array = NDArray[np.float64]

ENCODER_COUNTS = 1 << 16

FORCE_1, FORCE_2 = TRUTH.index("force_1"), TRUTH.index("force_2")
DEFLECTION_1, DEFLECTION_2 = TRUTH.index("deflection_1"), TRUTH.index("deflection_2")
ANGLE, TORQUE = TRUTH.index("angle"), TRUTH.index("external_torque")
MOTOR_1 = TRUTH.index("motor_1")

_NOISES = 6  # force, deflection of each side, angle, torque
_DRAW = 4096  # samples whose noise is drawn at once


class Readings(NamedTuple):
    """What the sensors say, a row a sample: forces [N], encoder counts, angle [rad], torque [N m], motors [rad]."""

    forces: Array
    counts: Array
    angle: Array
    torque: Array
    motors: Array


class Sensors:
    """Sensors with their own noise; blocks of any size give the same sequence."""

    def __init__(self, config: SensorConfig, seed: int) -> None:
        self._numbers = _Numbers(
            config.force_noise_std,
            config.force_resolution,
            config.force_range,
            config.deflection_noise_std,
            config.deflection_resolution,
            config.encoder_start,
            config.angle_noise_std,
            config.torque_noise_std,
        )
        self._random = np.random.default_rng(seed)
        self._noise: Array = np.empty((0, _NOISES))
        self._used = 0

    def read(self, truth: Array) -> Readings:
        """Readings of rows of truth (columns as in `TRUTH`)."""
        noise = self._draw(len(truth))
        said = np.empty((len(truth), _NOISES))
        _measure(truth, noise, self._numbers, said)
        return Readings(said[:, 0:2], said[:, 2:4], said[:, 4], said[:, 5], truth[:, MOTOR_1 : MOTOR_1 + 2])

    def _draw(self, rows: int) -> Array:
        if self._used + rows > len(self._noise):
            fresh = self._random.standard_normal((max(rows, _DRAW), _NOISES))
            self._noise, self._used = np.concatenate([self._noise[self._used :], fresh]), 0
        self._used += rows
        return self._noise[self._used - rows : self._used]


class _Numbers(NamedTuple):
    force_noise: float
    force_resolution: float
    force_range: float
    deflection_noise: float
    deflection_resolution: float
    encoder_start: int
    angle_noise: float
    torque_noise: float


@compiled
def _measure(truth: Array, noise: Array, numbers: _Numbers, said: Array) -> None:
    for i in range(truth.shape[0]):
        for side in range(2):
            force = truth[i, FORCE_1 if side == 0 else FORCE_2] + numbers.force_noise * noise[i, side]
            if numbers.force_resolution > 0.0:
                force = round(force / numbers.force_resolution) * numbers.force_resolution
            said[i, side] = min(max(force, -numbers.force_range), numbers.force_range)
            deflection = truth[i, DEFLECTION_1 if side == 0 else DEFLECTION_2]
            deflection += numbers.deflection_noise * noise[i, 2 + side]
            count = math.floor(deflection / numbers.deflection_resolution + 0.5) + numbers.encoder_start
            said[i, 2 + side] = count % ENCODER_COUNTS
        said[i, 4] = truth[i, ANGLE] + numbers.angle_noise * noise[i, 4]
        said[i, 5] = truth[i, TORQUE] + numbers.torque_noise * noise[i, 5]
