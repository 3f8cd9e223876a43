"""Start values that are wrong on purpose, so that a demo shows estimation and not memory."""

from collections.abc import Mapping

import numpy as np

K2_OFF = 0.3
STIFFNESS_OFF = 2.0
D1_OFF = (0.6, 1.6)
TWOFOLD = (0.5, 2.0)


def wrong_start(truth: Mapping[str, float], force: float, generator: np.random.Generator) -> dict[str, float]:
    """Values for the estimator's `initial.*` from true coefficients and the force at the start of the run [N]; SI.

    k2 is 30 % too large or too small and stiffness, which the estimator starts from as k2 (force - force_offset),
    eq. (3), twofold too large or too small with it; d1, d2 and inertia are off as well.
    """
    stiff = bool(generator.integers(2))
    k2 = truth["k2"] * (1.0 + K2_OFF if stiff else 1.0 - K2_OFF)
    stiffness = truth["k2"] * (force - truth["force_offset"]) * (STIFFNESS_OFF if stiff else 1.0 / STIFFNESS_OFF)
    return {
        "k2": float(k2),
        "d1": float(truth["d1"] * generator.choice(D1_OFF)),
        "d2": float(truth["d2"] * generator.choice(TWOFOLD)),
        "inertia": float(truth["inertia"] * generator.choice(TWOFOLD)),
        "force_offset": float(force - stiffness / k2),
    }
