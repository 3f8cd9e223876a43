"""What the sensors make of the truth: noise, resolution, range, counters that wrap."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_driver.rig.config import SensorConfig
from vsa_driver.rig.dynamics import TRUTH

Array = NDArray[np.float64]

ENCODER_COUNTS = 1 << 16

FORCES = [TRUTH.index("force_1"), TRUTH.index("force_2")]
DEFLECTIONS = [TRUTH.index("deflection_1"), TRUTH.index("deflection_2")]
MOTORS = [TRUTH.index("motor_1"), TRUTH.index("motor_2")]
ANGLE, TORQUE = TRUTH.index("angle"), TRUTH.index("external_torque")


class Readings(NamedTuple):
    """What the sensors say, a row a sample: forces [N], encoder counts, angle [rad], torque [N m], motors [rad]."""

    forces: Array
    counts: NDArray[np.int64]
    angle: Array
    torque: Array
    motors: Array


class Sensors:
    """Sensors with their own noise; blocks of any size give the same sequence."""

    def __init__(self, config: SensorConfig, seed: int) -> None:
        self._config = config
        self._random = np.random.default_rng(seed)

    def read(self, truth: Array) -> Readings:
        """Readings of rows of truth (columns as in `TRUTH`)."""
        config = self._config
        noise = self._random.standard_normal((len(truth), 6))
        forces = truth[:, FORCES] + config.force_noise_std * noise[:, 0:2]
        forces = np.clip(_rounded(forces, config.force_resolution), -config.force_range, config.force_range)
        deflections = truth[:, DEFLECTIONS] + config.deflection_noise_std * noise[:, 2:4]
        counts = np.rint(deflections / config.deflection_resolution).astype(np.int64) + config.encoder_start
        return Readings(
            forces,
            counts % ENCODER_COUNTS,
            truth[:, ANGLE] + config.angle_noise_std * noise[:, 4],
            truth[:, TORQUE] + config.torque_noise_std * noise[:, 5],
            truth[:, MOTORS],
        )


def _rounded(values: Array, resolution: float) -> Array:
    return np.rint(values / resolution) * resolution if resolution > 0.0 else values
