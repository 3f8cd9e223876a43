# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The exponential spring from a specification, section II-B of the paper; SI units."""

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.optimize import brentq
from vsa_common.config.configuration import ConfigurationError, quantity

Number = TypeVar("Number", float, np.ndarray)


@dataclass(frozen=True)
class Specification:
    """Specification of the spring; the defaults are the paper's."""

    max_deflection: float = quantity(0.020, "m", 1e-4, 1.0, "largest elongation, Xmax")
    max_force: float = quantity(200.0, "N", 1e-2, 1e5, "force at the largest elongation, FSmax")
    min_force: float = quantity(5.0, "N", 1e-3, 1e5, "force at the preloaded length, FSmin")
    rest_length: float = quantity(0.005, "m", 1e-5, 1.0, "preloaded length L0, where the smallest force is meant")
    smallest_deflection: float = quantity(0.001, "m", 1e-6, 1.0, "deflection delta0 that the force error is meant for")
    force_error: float = quantity(0.2, "1", 1e-3, 10.0, "relative force error C0 after the smallest deflection")
    alpha: float = quantity(0.0, "1", 0.0, 100.0, "alpha = k2 L0 of (1); 0 derives it from min_force at rest_length")


@dataclass(frozen=True)
class ExponentialSpring:
    """F_S = F0 + k1 exp(k2 x), eq. (2)."""

    force_offset: float  # F0 [N]
    k1: float  # [N]
    k2: float  # [1/m]

    def force(self, deflection: Number) -> Number:
        """Elastic force [N] at a deflection [m], eq. (2)."""
        return self.force_offset + self.k1 * np.exp(self.k2 * deflection)

    def stiffness(self, deflection: Number) -> Number:
        """Stiffness [N/m] at a deflection [m], eq. (3): proportional to the force above the offset."""
        return self.k2 * (self.force(deflection) - self.force_offset)

    def work(self, deflection: Number) -> Number:
        """Energy [J] stored between zero deflection and `deflection` [m]."""
        return self.force_offset * deflection + self.k1 / self.k2 * np.expm1(self.k2 * deflection)


def spring_from(wanted: Specification) -> ExponentialSpring:
    """The spring that meets a specification.

    Three conditions give F0, k1 and k2: force max_force at max_deflection; relative force error at min_force,
    k2 (Fmin - F0) delta0 = C0 Fmin; force min_force at rest_length. A given `alpha` replaces the third, as in the
    paper: eq. (4) is alpha = 1.3288.

    Raises ConfigurationError where no exponential spring meets them.
    """
    _check_order(wanted)
    k2 = wanted.alpha / wanted.rest_length if wanted.alpha else _k2(wanted)
    offset = wanted.min_force * (1.0 - wanted.force_error / (k2 * wanted.smallest_deflection))
    k1 = (wanted.max_force - offset) * math.exp(-k2 * wanted.max_deflection)
    spring = ExponentialSpring(offset, k1, k2)
    if not spring.force(0.0) > 0.0:
        raise ConfigurationError(
            f"force_error = {wanted.force_error:g} 1: the force at rest would be {spring.force(0.0):.3g} N, "
            "and a tendon only pulls; use a smaller force_error"
        )
    return spring


def _k2(wanted: Specification) -> float:
    """k2 [1/m] from (exp(k2 s) - 1)/k2 = (Fmax - Fmin) delta0/(C0 Fmin), s the stroke beyond the rest length."""
    stroke = wanted.max_deflection - wanted.rest_length
    rise = (wanted.max_force - wanted.min_force) * wanted.smallest_deflection
    target = rise / (wanted.force_error * wanted.min_force)
    if target <= stroke * (1.0 + 1e-6):
        straight = rise / (stroke * wanted.min_force)
        raise ConfigurationError(
            f"force_error = {wanted.force_error:g} 1: must be below {straight:.4g} for these forces and deflections; "
            "at that value the spring is linear, above it no stiffening spring exists"
        )
    return brentq(lambda k2: math.expm1(k2 * stroke) / k2 - target, 1e-6 / stroke, 500.0 / stroke, xtol=1e-12)


def _check_order(wanted: Specification) -> None:
    if wanted.min_force >= wanted.max_force:
        raise ConfigurationError(
            f"min_force = {wanted.min_force:g} N: must be below max_force = {wanted.max_force:g} N"
        )
    if wanted.rest_length >= wanted.max_deflection:
        raise ConfigurationError(
            f"rest_length = {wanted.rest_length:g} m: must be below max_deflection = {wanted.max_deflection:g} m"
        )
