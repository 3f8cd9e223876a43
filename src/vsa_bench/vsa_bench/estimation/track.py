"""What a method said along the recordings, ready to be scored."""

from dataclasses import dataclass, field

import numpy as np
from vsa_common.types import Array


def unknown() -> Array:
    """A quantity that a method does not estimate."""
    return np.full((1, 1), np.nan)


@dataclass
class Track:
    """Estimates of one method, (seeds, samples) or (1, 1) NaN where it gives none; SI."""

    stiffness: Array
    stiffness_variance: Array = field(default_factory=unknown)
    stiffness_valid: Array = field(default_factory=unknown)
    damping: Array = field(default_factory=unknown)
    damping_variance: Array = field(default_factory=unknown)
    damping_valid: Array = field(default_factory=unknown)
    inertia: Array = field(default_factory=unknown)
    inertia_variance: Array = field(default_factory=unknown)
    inertia_valid: Array = field(default_factory=unknown)
    k2: Array = field(default_factory=unknown)
    k2_variance: Array = field(default_factory=unknown)
    d2: Array = field(default_factory=unknown)
    nees: Array = field(default_factory=unknown)  # of [ln_stiffness_reference k2 d1], once a second
    jerk_density: float = float("nan")  # process noise in use [m^2/s^5]
    seconds: float = float("nan")  # computing time, all seeds together
