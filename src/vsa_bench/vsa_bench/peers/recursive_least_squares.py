# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Polynomial fit in the style of F. Flacco and A. De Luca, "Stiffness estimation and nonlinear control of robots with
variable stiffness actuation", IFAC World Congress 2011, and F. Flacco, A. De Luca, I. Sardellitti, N. Tsagarakis,
"On-line estimation of variable stiffness in flexible robot joints", Int. J. Robotics Research 31(13), 2012.

The flexibility force is linear in a polynomial basis of the deflection and fitted by recursive least squares with
forgetting; stiffness is the slope of the fit. Their first stage, the residual that yields the flexibility torque, is
the force sensor here. The damper is fitted jointly.
"""

import numpy as np
from vsa_bench.peers.signals import ForgettingLeastSquares, basis, evaluation_point, state_variable_filter
from vsa_common.types import Array

# Best values of a grid search over slow, multisine and 0.5 Hz motions.
DEGREE = 4
CUTOFF = 6.0  # [Hz]
MEMORY = 10.0  # time constant of forgetting [s]
UPDATE_RATE = 100.0  # [Hz]
COULOMB_SPEED = 0.05e-3  # [m/s]
START_SLOPE = 10.0  # coefficient of the linear polynomial [N]: 1 N/mm


def fit(
    force: Array, deflection: Array, rate: float, maximum_speed: float, deflection_noise: float
) -> tuple[Array, Array, Array]:
    """Stiffness [N/m] and damping [N s/m], (recordings, samples), and d2 [N s^3/m^3] at the end.

    maximum_speed: peak speed of the damper from its data sheet [m/s].
    """
    smooth, velocity = state_variable_filter(deflection, rate, CUTOFF)
    target = state_variable_filter(force, rate, CUTOFF)[0]
    speed = np.clip(velocity / maximum_speed, -1.0, 1.0)
    damper = np.stack([speed, speed**3, np.tanh(velocity / COULOMB_SPEED)], axis=-1)
    rows = np.concatenate([basis(smooth, DEGREE)[0], damper], axis=-1)
    slopes = basis(evaluation_point(deflection, rate, deflection_noise), DEGREE)[1]
    start = np.zeros((len(force), rows.shape[-1]))
    start[:, 1] = START_SLOPE
    every = max(1, round(rate / UPDATE_RATE))
    solver = ForgettingLeastSquares(start, float(np.exp(-every / (rate * MEMORY))))
    stiffness, damping = np.empty_like(force), np.empty_like(force)
    for k in range(force.shape[1]):
        if k % every == 0:
            solver.add(rows[:, k], target[:, k])
        c = solver.coefficients
        stiffness[:, k] = np.einsum("si,si->s", slopes[:, k], c[:, : DEGREE + 1])
        damping[:, k] = (c[:, DEGREE + 1] + 3.0 * c[:, DEGREE + 2] * speed[:, k] ** 2) / maximum_speed
    return stiffness, damping, solver.coefficients[:, DEGREE + 2] / maximum_speed**3
