# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force of one transmission, eq. (6): spring, damper, mass, offset and friction, with first and second derivatives."""

from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.damper import add_damper_derivatives, clip_speed, damper_terms, peak_speed
from vsa_estimator.force_law.elastic import add_elastic_hessian, elastic_force, elastic_gradient, stiffness
from vsa_estimator.force_law.friction import friction_slope, smoothed_sign
from vsa_estimator.force_law.state import D0, D1, D2, F0, K2, A, M, S, V, X


@compiled
def force(z: Array, reference: float, coulomb_speed: float, gradient: Array, hessian: Array) -> float:
    """Force [N] of eq. (6) at state z (10); `gradient` (10) and `hessian` (10 x 10) are overwritten.

    `reference` [m] is that of s; the sign of eq. (5) is smoothed over `coulomb_speed` [m/s]. The Hessian has no term
    of the friction: the reversal noise of the filter covers it.
    """
    v, a, k2, d1, d2, mass, offset, coulomb = z[V], z[A], z[K2], z[D1], z[D2], z[M], z[F0], z[D0]
    dx = z[X] - reference
    sigma = stiffness(z[S], k2, dx)
    sign = smoothed_sign(v, coulomb_speed)
    hessian[:, :] = 0.0

    gradient[X], gradient[S], gradient[K2] = elastic_gradient(sigma, k2, dx)
    add_elastic_hessian(sigma, k2, dx, hessian)
    add_damper_derivatives(v, d1, d2, gradient, hessian)
    gradient[V] += friction_slope(coulomb, sign, coulomb_speed)
    gradient[D0] = sign
    gradient[A] = mass
    gradient[M] = a
    hessian[A, M] = 1.0
    gradient[F0] = 1.0
    for i in range(M + 1):
        for j in range(i):
            hessian[i, j] = hessian[j, i]

    linear, cubic = damper_terms(d1, d2, clip_speed(v, peak_speed(d1, d2)))
    return float(elastic_force(sigma, k2) + linear + cubic + mass * a + offset + coulomb * sign)
