# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Integral fit in the style of T. Menard, G. Grioli, A. Bicchi, "A real-time robust observer for an agonist-antagonist
variable stiffness actuator", IEEE ICRA 2013, and "A stiffness estimator for agonistic-antagonistic variable-stiffness-
actuator devices", IEEE Trans. Robotics 30(5), 2014.

Their algebraic method integrates the force law over short windows, so that no noisy signal is differentiated: each
window is an equation, linear in the coefficients of a polynomial force law and of the damper, solved by recursive
least squares with forgetting.
"""

import numpy as np
from vsa_bench.peers.signals import ForgettingLeastSquares, basis, evaluation_point, state_variable_filter
from vsa_common.types import Array

# Best values of a grid search over slow, multisine and 0.5 Hz motions.
DEGREE = 4
WINDOW = 0.05  # [s]
CUTOFF = 6.0  # [Hz]; the same on force and deflection: no bias by phase
MEMORY = 10.0  # time constant of forgetting [s]
COULOMB_SPEED = 0.1e-3  # [m/s]
START_SLOPE = 10.0  # coefficient of the linear polynomial [N]: 1 N/mm


def fit(
    force: Array, deflection: Array, rate: float, maximum_speed: float, deflection_noise: float
) -> tuple[Array, Array, Array]:
    """Stiffness [N/m] and damping [N s/m], (recordings, samples), and d2 [N s^3/m^3] at the end.

    maximum_speed: peak speed of the damper from its data sheet [m/s].
    """
    length = max(2, round(WINDOW * rate))
    windows = force.shape[1] // length
    used = windows * length
    smooth = state_variable_filter(deflection, rate, CUTOFF)[0]
    target = _means(state_variable_filter(force, rate, CUTOFF)[0][:, :used], length)
    ends = smooth[:, length - 1 : used : length]
    travel = np.diff(ends, axis=1, prepend=smooth[:, :1])
    speed = np.clip(travel * rate / length / maximum_speed, -1.0, 1.0)
    damper = np.stack([speed, speed**3, np.tanh(speed * maximum_speed / COULOMB_SPEED)], axis=-1)
    polynomials = np.stack([_means(p, length) for p in np.moveaxis(basis(smooth[:, :used], DEGREE)[0], -1, 0)], axis=-1)
    rows = np.concatenate([polynomials, damper], axis=-1)
    slopes = basis(evaluation_point(deflection, rate, deflection_noise), DEGREE)[1]
    start = np.zeros((len(force), rows.shape[-1]))
    start[:, 1] = START_SLOPE
    solver = ForgettingLeastSquares(start, float(np.exp(-length / rate / MEMORY)))
    stiffness, damping = np.empty_like(force), np.empty_like(force)
    for window in range(windows + 1):
        # The equation of a window is complete at its end; its result applies from the next window on.
        part = np.s_[:, window * length : (window + 1) * length]
        c = solver.coefficients
        stiffness[part] = np.einsum("snk,sk->sn", slopes[part], c[:, : DEGREE + 1])
        if window < windows:
            damping[part] = ((c[:, DEGREE + 1] + 3.0 * c[:, DEGREE + 2] * speed[:, window] ** 2) / maximum_speed)[
                :, None
            ]
            solver.add(rows[:, window], target[:, window])
        else:
            damping[part] = damping[:, used - 1 : used]
    return stiffness, damping, solver.coefficients[:, DEGREE + 2] / maximum_speed**3


def _means(signal: Array, length: int) -> Array:
    return np.asarray(signal.reshape(len(signal), -1, length).mean(axis=2))
