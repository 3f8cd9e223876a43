# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Order of the filter state.

z = [x v a | s k2 d1 d2 M F0 d0], with the stiffness sigma = exp(s + k2 (x - reference)). The reference is a constant,
not a state: with a reference inside the travel the errors of s and k2 are nearly uncorrelated.
"""

from enum import IntEnum


class Z(IntEnum):
    """Index into the filter state, its covariance, the gradient and the Hessian of the force."""

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


class C(IntEnum):
    """Index into the coefficients [s k2 d1 d2 M F0 d0], the filter state without the motion, and their covariance."""

    S = 0
    K2 = 1
    D1 = 2
    D2 = 3
    M = 4
    F0 = 5
    D0 = 6


SIZE = 10
COEFFICIENTS = len(C)
X, V, A, S, K2, D1, D2, M, F0, D0 = (index.value for index in Z)  # numba does not index with an IntEnum
C_S, C_K2, C_D1, C_D2, C_M, C_F0, C_D0 = (index.value for index in C)
