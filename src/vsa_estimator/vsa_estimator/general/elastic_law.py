# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic law of the mixture over the deflections of the recorded motion."""

import math

import numpy as np
from vsa_common.types import Array
from vsa_estimator.general.basis import add_integrals, elastic_spline, locate
from vsa_estimator.general.records import INTERVALS, SPRING, SPRING_SIZE, L, Record
from vsa_estimator.tuning.general import (
    KNOTS_PER_INTERVAL,
    MIN_LN_VARIANCE,
    MIN_PROBABILITY,
    MIN_RELATIVE_STIFFNESS,
    STIFFNESS_BIAS,
)


def elastic_law(
    members: Record, geometry: Record, probabilities: Array, span: tuple[float, float]
) -> tuple[Array, Array, Array, float]:
    """Knots [m] (n,), ln stiffness (n,) with covariance (n, n), and the force at the first knot [N].

    The knots enclose the deflections `span` [m] and one interval of the spline on either side, with the variance that
    the prior has there.

    Moments of the mixture of `members` with `probabilities`; the force has the level of the members.
    """
    knots = _knots(geometry, span)
    basis = np.array([_basis(geometry, x) for x in knots])  # (n, SPRING_SIZE)
    grown = geometry["growth"][0] * (knots - geometry["reference"][0])
    at_first = _integrals(geometry, knots[0])
    kept = probabilities >= MIN_PROBABILITY
    weights = probabilities[kept] / probabilities[kept].sum()
    mean, square, force = np.zeros(len(knots)), np.zeros((len(knots), len(knots))), 0.0
    for weight, one in zip(weights, members[kept], strict=True):
        coefficients = one["mean"][SPRING:]
        relative = basis @ coefficients
        relative = np.maximum(relative, MIN_RELATIVE_STIFFNESS * np.abs(coefficients).max() + 1e-6)
        ln_stiffness, gradient = grown + np.log(relative), basis / relative[:, None]
        bias = gradient @ one["bias"][SPRING:]
        covariance = gradient @ one["covariance"][SPRING:, SPRING:] @ gradient.T + np.outer(bias, bias)
        mean += weight * ln_stiffness
        square += weight * (max(one["stiffness_inflation"], 1.0) * covariance + np.outer(ln_stiffness, ln_stiffness))
        force += weight * float(one["mean"][L] + at_first @ coefficients)
    return knots, mean, square - np.outer(mean, mean) + STIFFNESS_BIAS**2, force


def fitted_growth(knots: Array, ln_stiffness: Array, covariance: Array, prior: tuple[float, float]) -> float:
    """Slope [1/m] of the exponential law that fits an elastic law best (generalized least squares).

    `prior`: mean and standard deviation of the slope [1/m].
    """
    weighted = covariance + MIN_LN_VARIANCE * np.eye(len(knots))
    design = np.stack([np.ones(len(knots)), knots - knots.mean()], axis=1)
    normal = design.T @ np.linalg.solve(weighted, np.column_stack([design, ln_stiffness]))
    mean, std = prior
    normal[1, 1:] += np.array([1.0, mean]) / std**2
    return float(np.linalg.solve(normal[:, :2], normal[:, 2])[1])


def _knots(geometry: Record, span: tuple[float, float]) -> Array:
    origin, step = float(geometry["origin"][0]), float(geometry["spacing"][0]) / KNOTS_PER_INTERVAL
    last = INTERVALS * KNOTS_PER_INTERVAL
    first = min(max(math.floor((span[0] - origin) / step) - KNOTS_PER_INTERVAL, 0), last - 1)
    end = max(min(math.ceil((span[1] - origin) / step) + KNOTS_PER_INTERVAL, last), first + 1)
    return np.asarray(origin + step * np.arange(first, end + 1), np.float64)


def _basis(geometry: Record, x: float) -> Array:
    row, w = np.zeros(SPRING_SIZE), np.empty(4)
    i = elastic_spline(geometry, x, w, np.empty(4))
    row[i : i + 4] = w
    return row


def _integrals(geometry: Record, x: float) -> Array:
    origin, spacing = float(geometry["origin"][0]), float(geometry["spacing"][0])
    i, _ = locate(x, origin, spacing)
    integrals: Array = geometry["table"][0, i].copy()
    add_integrals(geometry, i, origin + i * spacing, x, integrals)
    return integrals
