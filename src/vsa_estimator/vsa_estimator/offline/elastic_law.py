# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic law by ln stiffness at knots, as in EstimatorState, and its comparison with the exponential law."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc
from vsa_common.types import Array, Booleans
from vsa_estimator.tuning.offline import LAW_SIGNIFICANCE, MIN_LAW_DEVIATION

Z95 = 1.96  # half width of the 95 % interval in standard deviations


@dataclass(frozen=True)
class KnotLaw:
    """Elastic law by the logarithm of the stiffness at n knots, n > 1.

    Between two knots it is linear; beyond the outer ones it has their slope.
    """

    deflection: Array  # knots, increasing [m], (n,)
    ln_stiffness: Array  # of N/m, (n,)
    covariance: Array  # of ln_stiffness, (n, n)
    first_force: float  # static force at the first knot [N]

    def stiffness(self, deflection: Array) -> Array:
        """Stiffness at deflections (m,) [N/m]."""
        i, u = self._segments(deflection)
        return np.exp((1.0 - u) * self.ln_stiffness[i] + u * self.ln_stiffness[i + 1])

    def ln_std(self, deflection: Array) -> Array:
        """Standard deviation of ln stiffness at deflections (m,)."""
        i, u = self._segments(deflection)
        p, w = self.covariance, 1.0 - u
        variance = w * w * p[i, i] + 2.0 * u * w * p[i, i + 1] + u * u * p[i + 1, i + 1]
        return np.sqrt(np.maximum(variance, 0.0))

    def band(self, deflection: Array) -> tuple[Array, Array]:
        """Lower and upper end of the 95 % interval of the stiffness at deflections (m,) [N/m]."""
        stiffness, spread = self.stiffness(deflection), np.exp(Z95 * self.ln_std(deflection))
        return stiffness / spread, stiffness * spread

    def force(self, deflection: Array) -> Array:
        """Static elastic force at deflections (m,) [N]."""
        i, _ = self._segments(deflection)
        travel = deflection - self.deflection[i]
        return self._forces[i] + _work(self.ln_stiffness[i], self._slopes[i], travel)

    @cached_property
    def _slopes(self) -> Array:
        """Slope of ln stiffness in each segment (n - 1,) [1/m]."""
        return np.diff(self.ln_stiffness) / np.diff(self.deflection)

    @cached_property
    def _forces(self) -> Array:
        """Force at each knot (n,) [N]."""
        steps = _work(self.ln_stiffness[:-1], self._slopes, np.diff(self.deflection))
        return self.first_force + np.r_[0.0, np.cumsum(steps)]

    def _segments(self, deflection: Array) -> tuple[NDArray[np.intp], Array]:
        """Segment of each deflection (m,), and the position within it: 0 to 1 between its knots."""
        last = len(self.deflection) - 2
        i = np.clip(np.searchsorted(self.deflection, deflection, side="right").astype(np.intp) - 1, 0, last)
        return i, (deflection - self.deflection[i]) / (self.deflection[i + 1] - self.deflection[i])


@dataclass(frozen=True)
class Deviation:
    """Deviation of an elastic law from the exponential law that fits it best."""

    deflection: Array  # knots [m], (n,)
    ln_stiffness: Array  # of the law minus that of the exponential law at the knots (n,)
    std: Array  # of that difference (n,)
    line: tuple[float, float]  # of the exponential law: ln stiffness at the mean of the knots, and k2 [1/m]
    probability: float  # of a statistic as great if the law is exponential

    @property
    def is_significant(self) -> bool:
        """Whether the exponential law is refuted."""
        return self.probability < LAW_SIGNIFICANCE

    @property
    def where(self) -> Booleans:
        """Knots (n,) at which the deviation alone is outside of its 95 % interval."""
        return np.asarray(np.abs(self.ln_stiffness) > Z95 * np.hypot(self.std, MIN_LAW_DEVIATION))

    def exponential(self, deflection: Array) -> Array:
        """Stiffness of the exponential law at deflections (m,) [N/m]."""
        return np.asarray(np.exp(self.line[0] + self.line[1] * (deflection - self.deflection.mean())))


def deviation(law: KnotLaw, min_k2: float = -np.inf) -> Deviation:
    """Wald test of the exponential law: generalized least squares of a line through ln stiffness over the knots.

    Exponential laws have a k2 of at least `min_k2` [1/m]. Deviations of MIN_LAW_DEVIATION are within the variance: the
    friction and the delay that a regression does not have cause as much.
    """
    x, y, count = law.deflection, law.ln_stiffness, len(law.deflection)
    covariance = law.covariance + MIN_LAW_DEVIATION**2 * np.eye(count)
    design = np.stack([np.ones(count), x - x.mean()], axis=1)
    level, k2 = _fit(design, covariance) @ y
    if k2 < min_k2:
        k2, design = min_k2, design[:, :1]
        level = (_fit(design, covariance) @ (y - k2 * (x - x.mean())))[0]
    left = y - level - k2 * (x - x.mean())
    rest = np.eye(count) - design @ _fit(design, covariance)
    std = np.sqrt(np.maximum(np.diag(rest @ law.covariance @ rest.T), 0.0))
    statistic = float(left @ np.linalg.solve(covariance, left))
    return Deviation(x, left, std, (float(level), float(k2)), float(chdtrc(count - design.shape[1], statistic)))


def _fit(design: Array, covariance: Array) -> Array:
    """Operator of generalized least squares (coefficients, n)."""
    weighted = np.linalg.solve(covariance, design)
    return np.linalg.solve(design.T @ weighted, weighted.T)


def _work(ln_stiffness: Array, slope: Array, travel: Array) -> Array:
    """Integral of the stiffness over travels [m] from where its logarithm is `ln_stiffness` [N]."""
    change = slope * travel
    straight = np.abs(change) < 1e-9
    growth = np.where(straight, 1.0, np.expm1(change) / np.where(straight, 1.0, change))
    return np.exp(ln_stiffness) * travel * growth
