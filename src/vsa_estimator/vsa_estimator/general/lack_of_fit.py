# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Errors that a member's covariance does not have: lack of fit, and interpolation by the elastic spline.

A model that is wrong leaves correlated innovations. The error that an innovation leaves in an output is its influence
times the innovation. For white innovations the variance of a sum over a block is the sum of the variances. The greatest
ratio over several block lengths, with a prior of SHRINKAGE blocks without excess, inflates the variance
(autocorrelation consistent covariance; Newey and West, 1987).
"""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.general.records import SPRING, SPRING_SIZE, WINDOWS, Record
from vsa_estimator.tuning.general import BLOCK_LENGTHS, INFLUENCE_GAIN, INTERPOLATION_ERROR, LACK_MEMORY, SHRINKAGE

LENGTHS = np.array(BLOCK_LENGTHS)
FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])


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


@compiled
def interpolation_variance(member: Record, interval: int) -> float:
    """Variance [N^2/m^2] of the relative stiffness within an interval of the spline, by features between its knots.

    From the mean square of the fourth differences of the coefficients about it, without their variance.
    """
    c, p, d = member[0]["mean"][SPRING:], member[0]["covariance"][SPRING:, SPRING:], FOURTH_DIFFERENCE
    first, last, total = max(interval - 2, 0), min(interval + 1, SPRING_SIZE - d.size), 0.0
    for k in range(first, last + 1):
        difference, variance = 0.0, 0.0
        for i in range(d.size):
            difference += d[i] * c[k + i]
            for j in range(d.size):
                variance += d[i] * d[j] * p[k + i, k + j]
        total += max(difference * difference - variance, 0.0)
    return INTERPOLATION_ERROR**2 * total / (last - first + 1)
