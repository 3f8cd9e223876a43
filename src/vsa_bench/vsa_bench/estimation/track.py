# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimates of a method along the recordings."""

from dataclasses import dataclass, field

import numpy as np
from vsa_common.types import Array


def not_estimated() -> Array:
    """Placeholder of a quantity that a method does not estimate."""
    return np.full((1, 1), np.nan)


@dataclass
class Track:
    """Estimates of one method, (seeds, samples) or (1, 1) NaN where it gives none; SI."""

    stiffness: Array
    stiffness_variance: Array = field(default_factory=not_estimated)
    stiffness_valid: Array = field(default_factory=not_estimated)
    damping: Array = field(default_factory=not_estimated)
    damping_variance: Array = field(default_factory=not_estimated)
    damping_valid: Array = field(default_factory=not_estimated)
    inertia: Array = field(default_factory=not_estimated)
    inertia_variance: Array = field(default_factory=not_estimated)
    inertia_valid: Array = field(default_factory=not_estimated)
    k2: Array = field(default_factory=not_estimated)
    k2_variance: Array = field(default_factory=not_estimated)
    d2: Array = field(default_factory=not_estimated)
    nees: Array = field(default_factory=not_estimated)  # of [ln_stiffness_reference k2 d1], once a second
    jerk_density: float = float("nan")  # process noise in use [m^2/s^5]
    seconds: float = float("nan")  # computing time, all seeds together
