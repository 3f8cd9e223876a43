# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Smoothed Coulomb friction, the term d0 sgn v of eq. (5), and the standard deviation of its form."""

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.tuning.force_law import COULOMB_SPEED

UNIFORM_RMS = 3.0**-0.5  # root mean square of a uniform distribution over 0 to 1


@compiled
def smoothed_sign(v: float, coulomb_speed: float) -> float:
    """Smoothed sgn v; 76 % at `coulomb_speed` [m/s]."""
    return float(np.tanh(v / coulomb_speed))


@compiled
def friction_slope(coulomb: float, sign: float, coulomb_speed: float) -> float:
    """Derivative of the friction by the speed [N s/m] at the smoothed `sign`."""
    return coulomb * (1.0 - sign * sign) / coulomb_speed


@compiled
def smoothing_speed(acceleration: float, speed_variance: float, dt: float) -> float:
    """Speed [m/s] over which the sign is smoothed: the mean over an uncertain speed is smoother than the friction.

    The variance is that of the estimate and of the speeds that a step of `dt` [s] spans (uniform: 1/12).
    """
    return float(np.sqrt(COULOMB_SPEED**2 + 1.5 * (speed_variance + (acceleration * dt) ** 2 / 12.0)))


@compiled
def friction_model_std(v: float, coulomb: float, coulomb_speed: float) -> float:
    """Standard deviation [N] of the form of the friction at speed v: uniform between the smoothed sign and the sign."""
    return float(UNIFORM_RMS * coulomb * (np.sign(v) - np.tanh(v / coulomb_speed)))
