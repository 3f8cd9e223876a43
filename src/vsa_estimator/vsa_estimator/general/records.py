# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Order of a member's state, and the records of the bank.

The force is linear in the coefficients for a given motion:

    f = b + L + sum_j c_j I_j(x) + damper(v) + M a + (d0 + sum_k g_k exp(-(v / v_k)^2)) tanh(v / v_c)
        + sum_k rho_k q_k + sum_k h_k y_k

with I_j the integral of exp(kappa (x - reference)) B_j(x) from the reference (B_j: cubic B-splines), a damper that is
either the paper's cubic (d1, d2) or a sum of integrated quadratic B-splines (e_j), relaxation states q_k of a
generalised Maxwell model, and stop operators y_k of a Prandtl-Ishlinskii hysteresis.
"""

import numpy as np
from numpy.typing import NDArray

Record = NDArray[np.void]

INTERVALS = 16  # of the elastic spline
X, V, A, J = 0, 1, 2, 3  # deflection [m] and its derivatives
B = 4  # disturbance correlated over the travel: of the force [N] or of the encoder [m]
L, LEVEL_RATE = 5, 6  # level of the force at the reference [N], its rate [N/s]
M, D0, DELAY = 7, 8, 9  # mass [kg], Coulomb friction [N], delay of the force behind the encoder [s]
STRIBECK, STRIBECK_SIZE = 10, 3  # amplitudes g [N]
RELAXATION, RELAXATION_SIZE = 13, 6  # shares rho of the stiffness
HYSTERESIS, HYSTERESIS_SIZE = 19, 3  # amplitudes h [N]
D1, D2 = 22, 23  # the paper's damper, eq. (5)
DAMPER, DAMPER_SIZE = 24, 14  # damping coefficients e [N s/m]
SPRING, SPRING_SIZE = 38, INTERVALS + 3  # stiffness coefficients c [N/m]
SIZE = SPRING + SPRING_SIZE
MOTION = 4  # states of the motion

WINDOWS = 4  # block lengths of the lack-of-fit test
LACK = np.dtype([
    ("sum", "f8", (WINDOWS,)), ("variance", "f8", (WINDOWS,)), ("count", "f8", (WINDOWS,)),  # of the present block
    ("squares", "f8", (WINDOWS,)), ("variances", "f8", (WINDOWS,)), ("blocks", "f8", (WINDOWS,)),  # of earlier ones
    ("weight", "f8"), ("influence_square", "f8"),  # leaky mean of the squared influence
], align=True)  # fmt: skip

MODEL = np.dtype([
    ("travel_std", "f8"),  # of the disturbance B [N or m]
    ("travel_length", "f8"),  # its correlation length [m]
    ("encoder", "?"),  # whether B is the encoder's
    ("level_density", "f8"),  # random walk of L [N^2/s]
    ("scale_density", "f8"),  # random walk of ln of the elastic law [1/s]
    ("rate_density", "f8"),  # of the level rate [N^2/s^3]
    ("spline_damper", "?"), ("exponential", "?"),  # forms of damper and spring
    ("relaxation", "?"),  # whether the force relaxes
    ("ln_prior", "f8"),
], align=True)  # fmt: skip

MEMBER = np.dtype([
    ("model", MODEL),
    ("mean", "f8", (SIZE,)), ("covariance", "f8", (SIZE, SIZE)),
    ("bias", "f8", (SIZE,)),  # sensitivity of the mean to the form of the friction law (consider parameter)
    ("gain", "f8", (SIZE,)),  # of the last force
    ("linear", "f8", (SIZE,)),  # state at which the force is linearised
    ("linear_covariance", "f8", (MOTION, MOTION)),  # of the motion in it
    ("active", "i8", (SIZE,)), ("count", "i8"),  # indices of the states that the model has
    ("relaxation", "f8", (RELAXATION_SIZE,)), ("stop", "f8", (HYSTERESIS_SIZE,)),
    ("driving", "f8", (SPRING_SIZE,)),  # coefficients of the elastic law that drives the relaxation [N/m]
    ("deflection", "f8"),  # at the last step [m]
    ("time_since_motion", "f8"),  # [s]
    ("unexplained", "f8"),  # variance of the force that the model does not explain [N^2]
    ("ln_likelihood", "f8"),  # relative to the best member, bounded
    ("innovation", "f8"), ("innovation_variance", "f8"),  # of the last force; 0 without one
    ("stiffness_lack", LACK), ("damping_lack", LACK),
    ("stiffness_inflation", "f8"), ("damping_inflation", "f8"),  # of the variances
], align=True)  # fmt: skip

GEOMETRY = np.dtype([
    ("growth", "f8"),  # kappa [1/m]
    ("reference", "f8"), ("origin", "f8"), ("spacing", "f8"),  # of the elastic spline [m]
    ("unit", "f8"),  # 1 / k2 of the prior [m]
    ("speed_spacing", "f8"),  # of the damper's spline [m/s]
    ("table", "f8", (INTERVALS + 1, SPRING_SIZE)),  # integrals from the reference to each knot [m]
], align=True)  # fmt: skip

ENCODER = np.dtype([  # motion from the encoder alone
    ("mean", "f8", (MOTION,)), ("covariance", "f8", (MOTION, MOTION)), ("density", "f8"),  # of white snap [m^2/s^7]
], align=True)  # fmt: skip

STEP = np.dtype([
    ("dt", "f8"), ("deflection", "f8"), ("deflection_variance", "f8"),
    ("force", "f8"), ("force_variance", "f8"),  # force NaN: none
    ("gap", "?"),  # before this step: the motion is reset to that of the encoder; both variances are those of a shift
    ("relinearizing", "?"),  # whether the force is linearised at the member's coefficients in `linear`
    ("encoder", ENCODER),
    ("smoothed", "f8", (MOTION,)), ("smoothed_covariance", "f8", (MOTION, MOTION)),  # motion by later deflections, too
], align=True)  # fmt: skip

IMPEDANCE = np.dtype([
    ("ln_stiffness", "f8"), ("ln_stiffness_variance", "f8"),
    ("slope", "f8"), ("slope_variance", "f8"),  # of ln sigma over the deflection [1/m]
    ("damping", "f8"), ("damping_variance", "f8"), ("damping_slope", "f8"),  # by the speed [N s^2/m^2]
    ("rest_damping", "f8"),  # at zero velocity [N s/m]
    ("beyond_peak", "f8"),
    ("inertia", "f8"), ("level", "f8"), ("coulomb", "f8"),
    ("motion", "f8", (3,)), ("motion_covariance", "f8", (3, 3)),
], align=True)  # fmt: skip
