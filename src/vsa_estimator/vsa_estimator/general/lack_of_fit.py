# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Lack of fit: variances inflated by innovations that are correlated, as a model that is wrong leaves them.

The error that an innovation leaves in an output is its influence times the innovation. For white innovations the
variance of a sum over a block is the sum of the variances. The greatest ratio over several block lengths, with a prior
of SHRINKAGE blocks without excess, inflates the variance (autocorrelation consistent covariance; Newey and West, 1987).
"""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.general.records import WINDOWS, Record
from vsa_estimator.tuning.general import BLOCK_LENGTHS, INFLUENCE_GAIN, LACK_MEMORY, SHRINKAGE

LENGTHS = np.array(BLOCK_LENGTHS)


@compiled
def inflation(lack: Record, influence: float, innovation: float, variance: float) -> float:
    """Inflation of a variance after an innovation [N] of this variance [N^2]; `lack` is a LACK record."""
    square = influence * influence * variance
    lack["weight"] += INFLUENCE_GAIN * (1.0 - lack["weight"])
    lack["influence_square"] += INFLUENCE_GAIN * (square - lack["influence_square"])
    scale = 1.0 / math.sqrt(lack["influence_square"] / lack["weight"] + 1e-300)
    worst = 1.0
    for b in range(WINDOWS):
        lack["sum"][b] += scale * influence * innovation
        lack["variance"][b] += scale * scale * square
        lack["count"][b] += 1.0
        if lack["count"][b] >= LENGTHS[b]:
            fade = math.exp(-LENGTHS[b] / LACK_MEMORY)
            lack["squares"][b] = fade * lack["squares"][b] + lack["sum"][b] ** 2
            lack["variances"][b] = fade * lack["variances"][b] + lack["variance"][b]
            lack["blocks"][b] = fade * lack["blocks"][b] + 1.0
            lack["sum"][b] = lack["variance"][b] = lack["count"][b] = 0.0
        if lack["variances"][b] > 0.0:
            ratio = lack["squares"][b] / lack["variances"][b]
            worst = max(worst, (ratio * lack["blocks"][b] + SHRINKAGE) / (lack["blocks"][b] + SHRINKAGE))
    return float(worst)
