# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness observer of G. Grioli and A. Bicchi, "A non-invasive, real-time method for measuring variable
stiffness", Robotics: Science and Systems VI, 2010.

Model-free: the force rate is sigma v plus the rate of the damper force; sigma follows its error,
d sigma/dt = alpha (force_rate - damper_rate - sigma v) sgn(v). The law of the damper is an input.
"""

import numpy as np
from vsa_bench.peers.signals import second_derivative, state_variable_filter
from vsa_common.types import Array

CUTOFF = 3.0  # of force rate, velocity and acceleration [Hz]
GAIN = 1000.0  # alpha [1/m]; cutoff and gain: best of a grid search over slow, multisine and 0.5 Hz motions
START = 1000.0  # initial stiffness [N/m]


def stiffness(force: Array, deflection: Array, rate: float, d1: float, d2: float) -> Array:
    """Stiffness [N/m], (recordings, samples), with the exact damper d1 v + d2 v^3 (SI)."""
    velocity = state_variable_filter(deflection, rate, CUTOFF)[1]
    acceleration = second_derivative(deflection, rate, CUTOFF)
    force_rate = state_variable_filter(force, rate, CUTOFF)[1]
    elastic_rate = force_rate - np.maximum(d1 + 3.0 * d2 * velocity**2, 0.0) * acceleration
    sigma = np.full(len(force), START)
    result = np.empty_like(force)
    step = GAIN / rate
    for k in range(force.shape[1]):
        v = velocity[:, k]
        # The implicit step of the law is stable at any gain.
        sigma = np.maximum((sigma + step * elastic_rate[:, k] * np.sign(v)) / (1.0 + step * np.abs(v)), 0.0)
        result[:, k] = sigma
    return result
