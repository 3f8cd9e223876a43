# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Prior and posterior of the coefficients, and how successive posteriors are fused."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_law.state import C
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.initialization import INCONSISTENCY_DECAY, MAX_STEP_STDS

K1_STD = 1e3  # [N]: no prior of the force at no deflection


@dataclass(frozen=True)
class Prior:
    """Gaussian prior of [k1 d1 d2 M F0 d0], SI, and of ln k2."""

    mean: Array
    std: Array
    ln_k2: float
    ln_k2_std: float

    @classmethod
    def of(cls, initial: Initial) -> "Prior":
        """The configured start values with their standard deviations."""
        mean = [0.0, initial.d1, initial.d2, initial.inertia, initial.force_offset, initial.coulomb_friction]
        std = [
            K1_STD, initial.d1_std, initial.d2_std, initial.inertia_std, initial.force_offset_std,
            initial.coulomb_friction_std,
        ]  # fmt: skip
        return cls(np.array(mean), np.array(std), float(np.log(initial.k2)), initial.k2_std / initial.k2)

    @property
    def scaled(self) -> Array:
        """The mean in units of the standard deviations."""
        return self.mean / self.std


@dataclass(frozen=True)
class Fit:
    """Posterior of [s k2 d1 d2 M F0 d0], SI, given all rows."""

    mean: Array  # (7,)
    covariance: Array  # (7, 7)
    ln_k2_std: float
    stroke: float  # [m]
    acceleration: float  # root mean square [m/s^2]
    inconsistency: Array = field(default_factory=lambda: np.zeros(7))  # error that a step of the mean indicates

    def fuse_with_previous(self, previous: "Fit | None") -> "Fit":
        """This fit with the inconsistency between it and the `previous` one added to its covariance.

        Both use the same rows except the most recent ones, so that this mean is within the covariance of the
        previous one. A larger step of s or k2 indicates a bias: at the end of a first sweep of the stroke a regression
        can attribute the force of the damper to the spring for some seconds. The inconsistency decays from fit to fit.
        """
        if previous is None:
            return self
        step = self.mean - previous.mean
        is_inconsistent = np.any(np.abs(step[:2]) > MAX_STEP_STDS * np.sqrt(np.diag(previous.covariance)[:2]))
        inconsistency = step if is_inconsistent else INCONSISTENCY_DECAY * previous.inconsistency
        ln_k2_std = float(np.hypot(self.ln_k2_std, inconsistency[C.K2] / self.mean[C.K2]))
        covariance = self.covariance + np.outer(inconsistency, inconsistency)
        return replace(self, covariance=covariance, ln_k2_std=ln_k2_std, inconsistency=inconsistency)


def match_moments(fits: Sequence[Fit], weights: Array) -> Fit:
    """One fit with the mean and the covariance of the mixture of `fits`, by moment matching."""
    mean = np.einsum("f,fi->i", weights, [fit.mean for fit in fits])
    apart = np.array([fit.mean for fit in fits]) - mean
    covariance = np.einsum("f,fij->ij", weights, [fit.covariance for fit in fits])
    covariance = covariance + np.einsum("f,fi,fj->ij", weights, apart, apart)
    ln_k2_variance = weights @ [fit.ln_k2_std**2 for fit in fits] + weights @ (apart[:, C.K2] / mean[C.K2]) ** 2
    ln_k2_std = float(np.sqrt(ln_k2_variance))
    return Fit(mean, covariance, ln_k2_std, fits[0].stroke, fits[0].acceleration)
