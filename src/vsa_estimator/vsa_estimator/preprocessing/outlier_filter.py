"""Singles out samples that leave the line of their two predecessors; for streams much faster than the motion."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array

ODD = 10.0  # standard deviations of a second difference of white noise
FEW = 2  # in a row are spikes; after them the signal itself has jumped

LIMIT, LAST, BEFORE, RUN = range(4)


def no_line(std: float) -> Array:
    """Memory before the first sample; `std` of the white noise."""
    return np.array([ODD * math.sqrt(6.0) * std, math.nan, math.nan, 0.0])


@compiled
def passes(memory: Array, value: float) -> bool:
    """Whether to believe a sample."""
    if memory[RUN] < FEW and abs(value - 2.0 * memory[LAST] + memory[BEFORE]) > memory[LIMIT]:
        memory[RUN] += 1.0
        return False
    memory[BEFORE] = value if memory[RUN] > 0.0 or np.isnan(memory[LAST]) else memory[LAST]
    memory[LAST] = value
    memory[RUN] = 0.0
    return True
