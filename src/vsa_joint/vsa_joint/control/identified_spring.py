# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Law of one transmission at rest from the state of its estimator."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from vsa_common.damper import peak_speed
from vsa_joint.control.springs import ExponentialSpring, Spring
from vsa_joint.tuning import MAX_LN_STIFFNESS, MIN_ELASTIC_SHARE, STRAIGHT


@dataclass(frozen=True)
class KnotSpring(Spring):
    """Elastic law by ln stiffness at n knots; beyond the outer knots it has the slope of the outer segments.

    Within a segment the law is exponential, so that force and deflection have closed forms.
    """

    knots: tuple[float, ...]  # increasing [m], n > 1
    ln_stiffness: tuple[float, ...]  # of N/m
    covariance: tuple[float, ...]  # of ln_stiffness, row by row
    first_force: float  # at rest at the first knot [N]

    @property
    def least_force(self) -> float:
        return self.first_force

    @property
    def slack_force(self) -> float:
        return -math.inf  # the force without stiffness is outside of the law

    def deflection(self, force: float) -> float:
        i = min(max(bisect_right(self._forces, force) - 1, 0), len(self._slopes) - 1)
        slope, relative = self._slopes[i], (force - self._forces[i]) / math.exp(self.ln_stiffness[i])
        if abs(slope * relative) < STRAIGHT:
            return self.knots[i] + relative
        return self.knots[i] + math.log(max(1.0 + slope * relative, MIN_ELASTIC_SHARE)) / slope

    def force(self, deflection: float) -> float:
        i = self._segment(deflection)
        return self._forces[i] + _work(self.ln_stiffness[i], self._slopes[i], deflection - self.knots[i])

    def stiffness(self, force: float) -> float:
        return self.stiffness_at(self.deflection(force))

    def stiffness_at(self, deflection: float) -> float:
        i = self._segment(deflection)
        return math.exp(self.ln_stiffness[i] + self._slopes[i] * (deflection - self.knots[i]))

    def slope_at(self, deflection: float) -> float:
        return self._slopes[self._segment(deflection)]

    def position_variance(self, force: float) -> float:
        x = self.deflection(force)
        i, n = self._segment(x), len(self.knots)
        u = (x - self.knots[i]) / (self.knots[i + 1] - self.knots[i])
        first, mixed, second = (self.covariance[k] for k in (i * n + i, i * n + i + 1, (i + 1) * n + i + 1))
        return max(0.0, (1.0 - u) ** 2 * first + 2.0 * u * (1.0 - u) * mixed + u * u * second)

    def force_variance(self, force: float) -> float:
        """That of `position_variance`: the estimator does not state the covariance of the law with its level."""
        return self.position_variance(force)

    @cached_property
    def _slopes(self) -> tuple[float, ...]:
        """Slope of ln stiffness in each segment [1/m]."""
        x, y = self.knots, self.ln_stiffness
        return tuple((y[i + 1] - y[i]) / (x[i + 1] - x[i]) for i in range(len(x) - 1))

    @cached_property
    def _forces(self) -> tuple[float, ...]:
        """Force at each knot [N]."""
        forces = [self.first_force]
        for i, slope in enumerate(self._slopes):
            forces.append(forces[-1] + _work(self.ln_stiffness[i], slope, self.knots[i + 1] - self.knots[i]))
        return tuple(forces)

    def _segment(self, deflection: float) -> int:
        return min(max(bisect_right(self.knots, deflection) - 1, 0), len(self.knots) - 2)


def _work(ln_stiffness: float, slope: float, travel: float) -> float:
    """Integral of the stiffness over a travel [m] from where its logarithm is `ln_stiffness` [N]."""
    change = slope * travel
    return math.exp(ln_stiffness) * (travel if abs(change) < STRAIGHT else math.expm1(change) / slope)


class CoefficientEstimate(Protocol):
    """Fields that `identified_spring` reads of EstimatorState or of the estimator's own state."""

    deflection_reference: float
    ln_stiffness_reference: float
    k2: float
    d1: float
    d2: float
    force_offset: float
    coefficient_covariance: Sequence[float]
    elastic_force: float
    elastic_deflection: Sequence[float]
    elastic_ln_stiffness: Sequence[float]
    elastic_ln_stiffness_covariance: Sequence[float]


def identified_spring(state: CoefficientEstimate) -> Spring | None:
    """Spring from the state of an estimator; None where the coefficients are not usable.

    More than two knots are a law of a bank, two the exponential law, which the coefficients state with F0.
    """
    if len(state.elastic_deflection) > 2:
        return _knot_spring(state)
    covariance = state.coefficient_covariance
    numbers = (state.ln_stiffness_reference, state.k2, state.force_offset, *covariance)
    usable = state.k2 > 0.0 and abs(state.ln_stiffness_reference) <= MAX_LN_STIFFNESS
    if not (usable and all(math.isfinite(number) for number in numbers)):
        return None
    return ExponentialSpring(
        deflection_reference=state.deflection_reference,
        ln_stiffness=state.ln_stiffness_reference,
        k2=state.k2,
        force_offset=state.force_offset,
        ln_stiffness_variance=covariance[0],
        k2_variance=covariance[8],
        covariance=covariance[1],
        damping=max(state.d1, 0.0),
        peak_speed=peak_speed(state.d1, state.d2),
        force_offset_variance=covariance[40],
        force_offset_covariance=covariance[12],
    )


def _knot_spring(state: CoefficientEstimate) -> Spring | None:
    knots, ln_stiffness = tuple(state.elastic_deflection), tuple(state.elastic_ln_stiffness)
    covariance, count = tuple(state.elastic_ln_stiffness_covariance), len(knots)
    usable = len(ln_stiffness) == count and len(covariance) == count**2 and knots == tuple(sorted(set(knots)))
    finite = all(math.isfinite(number) for number in (*knots, *ln_stiffness, *covariance, state.elastic_force))
    if not (usable and finite and max(map(abs, ln_stiffness)) <= MAX_LN_STIFFNESS):
        return None
    return KnotSpring(
        knots,
        ln_stiffness,
        covariance,
        state.elastic_force,
        damping=max(state.d1, 0.0),
        peak_speed=peak_speed(state.d1, state.d2),
    )
