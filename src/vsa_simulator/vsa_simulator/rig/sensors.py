"""What the sensors make of the truth: noise, resolution, range, counters that wrap."""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.config import SensorConfig
from vsa_simulator.rig.dynamics import TRUTH

ENCODER_COUNTS = 1 << 16

FORCE_1, FORCE_2 = TRUTH.index("force_1"), TRUTH.index("force_2")
DEFLECTION_1, DEFLECTION_2 = TRUTH.index("deflection_1"), TRUTH.index("deflection_2")
ANGLE, TORQUE = TRUTH.index("angle"), TRUTH.index("external_torque")
MOTOR_1 = TRUTH.index("motor_1")

# Places of the sensors' numbers in one row
FORCE_NOISE, FORCE_RESOLUTION, FORCE_RANGE = range(3)
DEFLECTION_NOISE, DEFLECTION_RESOLUTION, ENCODER_START, ANGLE_NOISE, TORQUE_NOISE = range(3, 8)

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
        force = (config.force_noise_std, config.force_resolution, config.force_range)
        deflection = (config.deflection_noise_std, config.deflection_resolution, config.encoder_start)
        self._numbers = np.array([*force, *deflection, config.angle_noise_std, config.torque_noise_std], float)
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


@compiled
def _measure(truth: Array, noise: Array, numbers: Array, said: Array) -> None:
    for i in range(truth.shape[0]):
        for side in range(2):
            force = truth[i, FORCE_1 if side == 0 else FORCE_2] + numbers[FORCE_NOISE] * noise[i, side]
            if numbers[FORCE_RESOLUTION] > 0.0:
                force = round(force / numbers[FORCE_RESOLUTION]) * numbers[FORCE_RESOLUTION]
            said[i, side] = min(max(force, -numbers[FORCE_RANGE]), numbers[FORCE_RANGE])
            deflection = truth[i, DEFLECTION_1 if side == 0 else DEFLECTION_2]
            deflection += numbers[DEFLECTION_NOISE] * noise[i, 2 + side]
            count = math.floor(deflection / numbers[DEFLECTION_RESOLUTION] + 0.5) + numbers[ENCODER_START]
            said[i, 2 + side] = count % ENCODER_COUNTS
        said[i, 4] = truth[i, ANGLE] + numbers[ANGLE_NOISE] * noise[i, 4]
        said[i, 5] = truth[i, TORQUE] + numbers[TORQUE_NOISE] * noise[i, 5]
