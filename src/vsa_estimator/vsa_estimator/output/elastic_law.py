# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic law of EstimatorState: ln stiffness at knots, with covariance."""

import math
import sys
from typing import Any, NamedTuple

from vsa_common.types import Array
from vsa_estimator.tuning.force_law import MIN_K2

EXPONENTIAL = "exponential"
MAX_LN_STIFFNESS = math.log(sys.float_info.max)  # beyond it the stiffness is infinite


class ElasticLaw(NamedTuple):
    """Elastic law by the logarithm of the stiffness at n knots.

    Between two knots it is linear; beyond the outer ones it has their slope.
    """

    name: str
    deflection: tuple[float, ...]  # knots, increasing [m], (n,)
    ln_stiffness: tuple[float, ...]  # of N/m, (n,)
    covariance: tuple[float, ...]  # of ln_stiffness, row by row, (n * n,)
    force: float  # static force at the first knot, with the level [N]

    def fields(self, valid: bool) -> dict[str, Any]:
        """Fields of State; `valid` is the validity of the stiffness."""
        return {
            "elastic_law": self.name,
            "elastic_law_valid": valid,
            "elastic_force": self.force,
            "elastic_deflection": self.deflection,
            "elastic_ln_stiffness": self.ln_stiffness,
            "elastic_ln_stiffness_covariance": self.covariance,
        }


def exponential_law(reference: float, coefficients: tuple[float, float, float], covariance: Array) -> ElasticLaw:
    """The law of eqs. (2) and (3) with two knots: `reference` [m] and 1/k2 beyond.

    `coefficients` are ln stiffness at the reference, k2 [1/m] and F0 [N]; `covariance` (2, 2) is that of the first two.
    A filter that has diverged may have a force beyond the range of numbers, which is infinite.
    """
    ln_stiffness, k2, force_offset = coefficients
    k2 = max(k2, MIN_K2)
    at_reference, mixed, of_slope = (
        float(covariance[0, 0]),
        float(covariance[0, 1]) / k2,
        float(covariance[1, 1]) / k2**2,
    )
    stiffness = math.inf if ln_stiffness > MAX_LN_STIFFNESS else math.exp(ln_stiffness)
    across, beyond = at_reference + mixed, at_reference + 2.0 * mixed + of_slope
    return ElasticLaw(
        EXPONENTIAL,
        (reference, reference + 1.0 / k2),
        (ln_stiffness, ln_stiffness + 1.0),
        (at_reference, across, across, beyond),
        force_offset + stiffness / k2,
    )
