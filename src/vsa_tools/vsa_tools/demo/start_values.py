# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Perturbed initial coefficients: a demo shows convergence and not its initial values."""

from collections.abc import Mapping

import numpy as np

# Perturbations [1]; k2 and F0 stay within two of the initial standard deviations of paper_rig.yaml.
K2_ERROR = 0.3  # relative
STIFFNESS_FACTOR = 2.0
D1_FACTORS = (0.6, 1.6)
D2_INERTIA_FACTORS = (0.5, 2.0)


def perturbed(truth: Mapping[str, float], force: float, generator: np.random.Generator) -> dict[str, float]:
    """Values of the estimator's `initial.*` from true coefficients and the force at the start of the run [N]; SI.

    k2 is 30 % too large or too small. The initial stiffness k2 (force - force_offset), eq. (3), is too large or too
    small by a factor of two, with the same sign. d1, d2 and inertia have errors of at least 39 %.
    """
    stiff = bool(generator.integers(2))
    k2 = truth["k2"] * (1.0 + K2_ERROR if stiff else 1.0 - K2_ERROR)
    stiffness = truth["k2"] * (force - truth["force_offset"]) * (STIFFNESS_FACTOR if stiff else 1.0 / STIFFNESS_FACTOR)
    return {
        "k2": float(k2),
        "d1": float(truth["d1"] * generator.choice(D1_FACTORS)),
        "d2": float(truth["d2"] * generator.choice(D2_INERTIA_FACTORS)),
        "inertia": float(truth["inertia"] * generator.choice(D2_INERTIA_FACTORS)),
        "force_offset": float(force - stiffness / k2),
    }
