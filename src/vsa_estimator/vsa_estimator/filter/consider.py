# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Schmidt's consider parameters: the form of the friction, and coefficients that the motion does not excite.

A consider parameter is not estimated. Its uncertainty counts, and its gain is zero.
"""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.elastic import ln_stiffness_ratio
from vsa_estimator.force_law.state import D1, D2, K2, A, M, V
from vsa_estimator.tuning.filter import (
    MAX_INFORMATION_GAIN,
    MIN_ACCELERATION_RATIO,
    MIN_INERTIAL_FORCE_RATIO,
    MIN_STROKE,
    PEAK_SPEED_GATE,
)


@compiled
def propagate_bias(bias: Array, dt: float) -> None:
    """Predict the systematic error of the state by dt [s]."""
    bias[0] += dt * bias[1] + 0.5 * dt * dt * bias[2]
    bias[1] += dt * bias[2]


@compiled
def partial_update_mask(z: Array, p: Array, stroke: float, gain: Array) -> None:
    """Set gains to zero: of k2 on a `stroke` [m] without curvature, of M without a significant acceleration."""
    if ln_stiffness_ratio(z[K2], stroke) < MIN_STROKE:
        gain[K2] = 0.0
    if z[A] ** 2 < MIN_ACCELERATION_RATIO**2 * p[A, A]:
        gain[M] = 0.0


@compiled
def force_update_mask(
    z: Array, p: Array, noise_variance: float, ph: Array, innovation_variance: float, gain: Array
) -> None:
    """Set gains of a force to zero: of M where its force is below the noise, of d1 and d2 where v* is ambiguous.

    Within PEAK_SPEED_GATE the speed may be on either side of v*: no single force then takes more than
    MAX_INFORMATION_GAIN of the variance of d2. `ph` (10) is P h.
    """
    if abs(z[A]) * np.sqrt(p[M, M]) < MIN_INERTIAL_FORCE_RATIO * np.sqrt(noise_variance):
        gain[M] = 0.0
    ambiguous = abs(abs(z[V]) - peak_speed(z[D1], z[D2])) < PEAK_SPEED_GATE * np.sqrt(p[V, V])
    if ambiguous and ph[D2] * ph[D2] > MAX_INFORMATION_GAIN * innovation_variance * p[D2, D2]:
        gain[D1] = gain[D2] = 0.0
