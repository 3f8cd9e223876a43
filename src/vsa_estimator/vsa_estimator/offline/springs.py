# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic laws of an identification: force, its derivatives by the coefficients, and stiffness, over deflections."""

from typing import Protocol

import numpy as np
from scipy.interpolate import BSpline
from vsa_common.types import Array

DEGREE = 3  # of the splines


class Spring(Protocol):
    """An elastic law with m coefficients; deflections (n,) in m, coefficients (m,) in SI."""

    prior: Array  # mean of the coefficients (m,)
    precision: Array  # inverse of their covariance before the data (m, m); zero without a prior

    def force(self, deflection: Array, coefficients: Array) -> Array:
        """Elastic force (n,) [N]."""
        ...

    def columns(self, deflection: Array, coefficients: Array) -> Array:
        """Derivatives of the force by the coefficients (n, m)."""
        ...

    def column_slopes(self, deflection: Array, coefficients: Array) -> Array:
        """Derivatives of the columns by the deflection (n, m)."""
        ...

    def stiffness(self, deflection: Array, coefficients: Array) -> tuple[Array, Array]:
        """Stiffness (n,) [N/m] and its derivative by the deflection (n,) [N/m^2]."""
        ...


class ExponentialSpring:
    """Eq. (2) without F0: force q exp(k2 (x - reference)), coefficients [k2 q]."""

    def __init__(self, reference: float) -> None:
        """`reference`: deflection at which q = k1 exp(k2 reference) is the force [m]."""
        self.reference = reference
        self.prior: Array = np.zeros(2)
        self.precision: Array = np.zeros((2, 2))

    def force(self, deflection: Array, coefficients: Array) -> Array:
        return np.asarray(coefficients[1] * np.exp(coefficients[0] * (deflection - self.reference)))

    def columns(self, deflection: Array, coefficients: Array) -> Array:
        dx = deflection - self.reference
        growth = np.exp(coefficients[0] * dx)
        return np.stack([coefficients[1] * dx * growth, growth], axis=1)

    def column_slopes(self, deflection: Array, coefficients: Array) -> Array:
        k2, q = coefficients
        dx = deflection - self.reference
        growth = np.exp(k2 * dx)
        return np.stack([q * growth * (1.0 + k2 * dx), k2 * growth], axis=1)

    def stiffness(self, deflection: Array, coefficients: Array) -> tuple[Array, Array]:
        stiffness = coefficients[0] * self.force(deflection, coefficients)
        return stiffness, coefficients[0] * stiffness


class SplineSpring:
    """Stiffness as a sum of cubic B-splines c_j B_j(x), the force its integral from the first knot.

    The coefficients have a Gaussian prior, so that those without data have the mean of the prior and its variance.
    """

    def __init__(self, knots: Array, prior: Array, prior_covariance: Array) -> None:
        """`knots` (n + 1,) of n intervals, increasing [m]; prior mean (n + 3,) [N/m] and covariance."""
        self._basis = BSpline(_extended(knots), np.eye(len(prior)), DEGREE)
        self._slopes, self._integrals = self._basis.derivative(), self._basis.antiderivative()
        self.prior: Array = prior
        self.precision: Array = np.asarray(np.linalg.inv(prior_covariance), np.float64)

    def force(self, deflection: Array, coefficients: Array) -> Array:
        return np.asarray(self.columns(deflection, coefficients) @ coefficients)

    def columns(self, deflection: Array, coefficients: Array) -> Array:
        return np.asarray(self._integrals(deflection))

    def column_slopes(self, deflection: Array, coefficients: Array) -> Array:
        return self.basis(deflection)

    def stiffness(self, deflection: Array, coefficients: Array) -> tuple[Array, Array]:
        return self.basis(deflection) @ coefficients, self._slopes(deflection) @ coefficients

    def basis(self, deflection: Array) -> Array:
        """Derivatives of the stiffness by the coefficients (n, m)."""
        return np.asarray(self._basis(deflection))


def abscissas(knots: Array) -> Array:
    """Deflections (n + 3,) that the coefficients of a spline with n intervals belong to [m] (Greville)."""
    extended = _extended(knots)
    return np.array([extended[i + 1 : i + 1 + DEGREE].mean() for i in range(len(knots) + DEGREE - 1)])


def _extended(knots: Array) -> Array:
    return np.r_[[knots[0]] * DEGREE, knots, [knots[-1]] * DEGREE]
