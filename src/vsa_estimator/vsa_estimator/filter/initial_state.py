# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Coefficients before any regression: configured values with standard deviations, stiffness from the first force."""

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_law.elastic import s_covariance, s_from_force
from vsa_estimator.force_law.state import C
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import MIN_ELASTIC_FORCE


def initial_coefficients(initial: Initial, force: float, dx: float) -> tuple[Array, Array]:
    """[s k2 d1 d2 M F0 d0] (7) and covariance (7 x 7) from a force [N] measured dx [m] from the reference."""
    elastic = max(force - initial.force_offset, MIN_ELASTIC_FORCE)
    mean = np.array([
        s_from_force(elastic, initial.k2, dx), initial.k2, initial.d1, initial.d2, initial.inertia,
        initial.force_offset, initial.coulomb_friction,
    ])  # fmt: skip
    s_variance, k2_variance, s_k2_covariance = s_covariance(
        elastic, initial.force_offset_std, initial.k2, initial.k2_std, dx
    )
    covariance = np.diag([
        s_variance, k2_variance, initial.d1_std**2, initial.d2_std**2, initial.inertia_std**2,
        initial.force_offset_std**2, initial.coulomb_friction_std**2,
    ])  # fmt: skip
    covariance[C.S, C.K2] = covariance[C.K2, C.S] = s_k2_covariance
    return mean, covariance
