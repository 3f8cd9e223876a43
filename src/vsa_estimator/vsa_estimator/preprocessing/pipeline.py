"""Raw samples on their way to the filter: judged, placed in time, examined, and averaged to its rate.

All in one compiled call for each sample; what is remembered lies in two arrays.
"""

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.preprocessing import decimator as blocks
from vsa_estimator.preprocessing import outlier_filter as spikes
from vsa_estimator.preprocessing import sensor_checks as signs
from vsa_estimator.preprocessing import timestamp_filter as sample_clock
from vsa_estimator.preprocessing import validation
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.preprocessing.validation import ACCEPT, IMPLAUSIBLE_RATIO
from vsa_estimator.settings import EstimatorConfig

BRISK = (10.0, 3.0)  # slopes of force and deflection after which they ring, in standard deviations a sample
NO_LESSON = (  # at rest there is nothing to learn, and a stuck encoder must not teach
    signs.FORCE_REPEATED | signs.ENCODER_QUIET | signs.FORCE_SATURATED | signs.DEFLECTION_SATURATED
)

# Signs beyond those of `signs`: a force, a deflection that is a spike.
FORCE_SPIKE, DEFLECTION_SPIKE = 4096, 8192

# Where in the memory: bounds of force and deflection, whether the rod moves beyond v*, and what each step remembers.
BEYOND_PEAK_SPEED, _LIMITS = 2, 3
_FORCE_LINE = _LIMITS + signs.LIMITS
_DEFLECTION_LINE = _FORCE_LINE + 4
_BLOCKS = _DEFLECTION_LINE + 4
_SIGNS = _BLOCKS + blocks.MEMORY
_CLOCK = _SIGNS + signs.nothing_seen().size
_JUDGED, _PLACED = validation.STAMPS, validation.STAMPS + sample_clock.STAMPS  # ends of their parts of the stamps


@compiled
def preprocess(
    memory: Array, stamps: NDArray[np.int64], stamp_ns: int, force: float, deflection: float
) -> tuple[int, int, int, int]:
    """Verdict on a sample (stamp_ns, force [N], deflection [m]); its signs, its instant [ns], and blocks finished."""
    verdict = validation.validate(memory[:2], stamps[:_JUDGED], stamp_ns, force, deflection)
    if verdict != ACCEPT:
        return verdict, 0, 0, 0
    averaged = memory[_BLOCKS:_SIGNS]
    instant_ns = sample_clock.instant(memory[_CLOCK:], stamps[_JUDGED:_PLACED], stamp_ns, deflection)
    undamped = memory[BEYOND_PEAK_SPEED] > 0.0
    limits, period_ns = memory[_LIMITS:_FORCE_LINE], averaged[blocks.PERIOD]
    found = signs.examine(memory[_SIGNS:_CLOCK], limits, stamp_ns, force, deflection, undamped, period_ns)
    fresh, placed = found & NO_LESSON == 0, True
    if blocks.averages(averaged):
        if fresh and not spikes.passes(memory[_FORCE_LINE:_DEFLECTION_LINE], force):
            found |= FORCE_SPIKE
            fresh = False
        if not spikes.passes(memory[_DEFLECTION_LINE:_BLOCKS], deflection):
            found |= DEFLECTION_SPIKE
            placed = False
    finished = blocks.collect(averaged, stamps[_PLACED:], instant_ns, deflection, force, placed, fresh)
    return verdict, found, instant_ns, finished


class Pipeline:
    """What `take` remembers of one transmission's samples."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Limits and noise from the configuration."""
        self._config = config
        self.memory = _nothing(config)
        self.stamps = np.zeros(_PLACED + blocks.STAMPS, dtype=np.int64)

    def reset(self) -> None:
        """Begin anew; which stamp was the last is still known."""
        self.memory[:] = _nothing(self._config)
        self.stamps[_JUDGED:] = 0

    @property
    def period_ns(self) -> float:
        """Running mean of the sample period [ns]; 0 before the second sample."""
        return float(self.memory[_BLOCKS + blocks.PERIOD])

    @property
    def averaged(self) -> bool:
        """Whether blocks hold several samples."""
        return bool(blocks.averages(self.memory[_BLOCKS:_SIGNS]))

    @property
    def force_noise(self) -> float:
        """Noise of the force, times what it should be."""
        return float(self.memory[_CLOCK - 2])

    @property
    def deflection_noise(self) -> float:
        """Noise of the encoder, times what it should be."""
        return float(self.memory[_CLOCK - 1])

    def finished(self, count: int) -> list[Decimated]:
        """The blocks that the last sample has finished."""
        return blocks.finished_blocks(self.memory[_BLOCKS:_SIGNS], self.stamps[_PLACED:], count)


def _nothing(config: EstimatorConfig) -> Array:
    """Memory before the first sample."""
    force_std, deflection_std = config.force_noise_std, config.deflection_std
    friction = config.initial.coulomb_friction + 2.0 * config.initial.coulomb_friction_std
    limits = np.zeros(signs.LIMITS)
    limits[signs.FORCE_STD], limits[signs.DEFLECTION_STD] = force_std, deflection_std
    limits[signs.BRISK_FORCE], limits[signs.BRISK_DEFLECTION] = BRISK[0] * force_std, BRISK[1] * deflection_std
    limits[signs.FORCE_TRAVEL] = 40.0 * config.force_noise_std + 2.0 * friction
    limits[signs.DEFLECTION_TRAVEL] = 20.0 * config.deflection_noise_std + 5.0 * config.deflection_resolution
    limits[signs.FORCE_LIMIT], limits[signs.DEFLECTION_LIMIT] = config.force_limit, config.deflection_limit
    bounds = [IMPLAUSIBLE_RATIO * config.force_limit, IMPLAUSIBLE_RATIO * config.deflection_limit, 0.0]
    lines = spikes.no_line(force_std), spikes.no_line(deflection_std)
    return np.concatenate([
        bounds, limits, *lines, blocks.no_samples(config.filter_rate), signs.nothing_seen(),
        sample_clock.no_instant(),
    ])  # fmt: skip
