"""Force law of one transmission, eqs. (2) to (6), with its first and second derivatives.

State z = [x v a | s k2 d1 d2 M F0 d0], stiffness sigma = exp(s + k2 (x - reference)). The reference
is a place, not a state: with it s and k2 are nearly uncorrelated.
"""

from enum import IntEnum

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array


class Z(IntEnum):
    """Order of the filter state."""

    X = 0  # deflection [m]
    V = 1  # deflection rate [m/s]
    A = 2  # acceleration [m/s^2]
    S = 3  # ln of the stiffness at the reference, in N/m
    K2 = 4  # growth of the spring [1/m]
    D1 = 5  # damper, linear [N s/m]
    D2 = 6  # damper, cubic [N s^3/m^3]
    M = 7  # moving mass [kg]
    F0 = 8  # force offset [N]
    D0 = 9  # Coulomb friction [N]


SIZE = 10
COULOMB_SPEED = 0.07e-3  # speed at which the filter's Coulomb friction has risen to 76 % [m/s]
FORM = 3.0**-0.5  # root mean square of what is spread evenly between none and one
UNBOUNDED_SPEED = 1.0  # maximum speed of a damper that is linear as far as one can tell [m/s]


@compiled
def peak_speed(d1: float, d2: float) -> float:
    """Speed v* [m/s] at which the damper's force, eq. (5), is greatest and D = d1 + 3 d2 v^2 vanishes."""
    if d2 < -1e5 and d1 > 0.0:
        return min(np.sqrt(d1 / (-3.0 * d2)), UNBOUNDED_SPEED)
    return UNBOUNDED_SPEED


@compiled
def ln_stiffness(s: float, k2: float, dx: float) -> float:
    """Natural logarithm of the stiffness, eq. (3), in N/m, `dx` [m] off the reference; a double can raise it."""
    return min(max(s + k2 * dx, -20.0), 25.0)


@compiled
def force(z: Array, reference: float, coulomb_speed: float, gradient: Array, hessian: Array) -> float:
    """Force [N] of eq. (6) at state z; its gradient (10) and hessian (10 x 10) go into the arrays given.

    Beyond v* the damper holds its greatest force: a passive damper cannot push. The sign in eq. (5) is smoothed over
    `coulomb_speed` [m/s]: the mean over an uncertain speed is smoother than the friction itself.
    """
    v, a, k2, d1, d2, mass, offset, coulomb = z[1], z[2], z[4], z[5], z[6], z[7], z[8], z[9]
    dx = z[0] - reference
    sigma = np.exp(ln_stiffness(z[3], k2, dx))
    w = peak_speed(d1, d2)
    c = min(max(v, -w), w)
    friction = np.tanh(v / coulomb_speed)

    gradient[0] = sigma
    gradient[1] = d1 + 3.0 * d2 * c * c if abs(v) < w else 0.0
    gradient[1] += coulomb * (1.0 - friction * friction) / coulomb_speed
    gradient[2] = mass
    gradient[3] = sigma / k2
    gradient[4] = sigma / k2 * (dx - 1.0 / k2)
    gradient[5] = c
    gradient[6] = c * c * c
    gradient[7] = a
    gradient[8] = 1.0
    gradient[9] = friction

    hessian[:, :] = 0.0
    hessian[0, 0] = sigma * k2
    hessian[0, 3] = sigma
    hessian[0, 4] = sigma * dx
    hessian[3, 3] = sigma / k2
    hessian[3, 4] = sigma * (dx / k2 - 1.0 / k2**2)
    hessian[4, 4] = sigma * (dx * dx / k2 - 2.0 * dx / k2**2 + 2.0 / k2**3)
    hessian[2, 7] = 1.0
    if abs(v) < w:
        hessian[1, 1] = 6.0 * d2 * v
        hessian[1, 5] = 1.0
        hessian[1, 6] = 3.0 * v * v
    elif w < UNBOUNDED_SPEED:
        side = 1.0 if v > 0.0 else -1.0
        hessian[5, 5] = side * w / (2.0 * d1)
        hessian[5, 6] = side * w / (-2.0 * d2)
        hessian[6, 6] = side * 1.5 * w**3 / (-d2)
    for i in range(8):
        for j in range(i):
            hessian[i, j] = hessian[j, i]
    return sigma / k2 + d1 * c + d2 * c * c * c + mass * a + offset + coulomb * friction


@compiled
def friction_model_std(z: Array, coulomb_speed: float) -> float:
    """How much more force [N] there may be at state z, one standard deviation, as the friction's form is unknown.

    Any form counts as likely between the smoothed one and none at all, the sign itself.
    """
    v, coulomb = z[1], z[9]
    return FORM * coulomb * (np.sign(v) - np.tanh(v / coulomb_speed))
