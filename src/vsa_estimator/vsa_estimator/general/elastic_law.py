# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic law of the mixture over the deflections of the motion, and the exponential law nested in a member."""

import math

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.general.basis import add_integrals, elastic_spline, locate
from vsa_estimator.general.lack_of_fit import interpolation_variance
from vsa_estimator.general.models import NESTED
from vsa_estimator.general.records import INTERVALS, SIZE, SPRING, SPRING_SIZE, L, Record
from vsa_estimator.tuning.general import (
    KNOTS_PER_INTERVAL,
    MAX_LN_VARIANCE,
    MIN_LN_VARIANCE,
    MIN_PROBABILITY,
    MIN_RELATIVE_STIFFNESS,
    SLOPE_STD,
    STIFFNESS_BIAS,
    STIFFNESS_STD,
)

FIT_STEPS = 20
MAX_FIT_STEP, MIN_FIT_STEP = 0.5, 1e-6  # of ln stiffness at the data and of its slope in 1/knot

Prior = tuple[float, float]  # mean of ln stiffness at the data; standard deviation of its slope about 0, in 1/knot


def elastic_law(
    members: Record, geometry: Record, probabilities: Array, span: tuple[float, float]
) -> tuple[Array, Array, Array, float]:
    """Knots [m] (n,), ln stiffness (n,) with covariance (n, n), and the force at the first knot [N].

    The knots enclose the deflections `span` [m] and one interval of the spline on either side, with the variance that
    the prior has there.

    Moments of the mixture of `members` with `probabilities`; the force has the level of the members.
    """
    knots = _knots(geometry, span)
    basis, intervals = np.zeros((len(knots), SPRING_SIZE)), np.zeros(len(knots), np.int64)
    spline_rows(geometry, knots, basis, intervals)
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
        between = interpolation_variances(one.reshape(1), intervals)
        mean += weight * ln_stiffness
        covariance = max(one["stiffness_inflation"], 1.0) * covariance + np.diag(between / relative**2)
        square += weight * (covariance + np.outer(ln_stiffness, ln_stiffness))
        force += weight * float(one["mean"][L] + at_first @ coefficients)
    return knots, mean, square - np.outer(mean, mean) + STIFFNESS_BIAS**2, force


def fitted_growth(knots: Array, ln_stiffness: Array, covariance: Array, prior: tuple[float, float]) -> float:
    """Slope [1/m] of the exponential law that fits an elastic law best (generalized least squares).

    `prior`: mean and standard deviation of the slope [1/m]. Knots at which the stiffness may be zero have no part.
    """
    known, (mean, std) = covariance.diagonal() < MAX_LN_VARIANCE, prior
    if not known.any():
        return mean
    knots, ln_stiffness, covariance = knots[known], ln_stiffness[known], covariance[np.ix_(known, known)]
    weighted = covariance + MIN_LN_VARIANCE * np.eye(len(knots))
    design = np.stack([np.ones(len(knots)), knots - knots.mean()], axis=1)
    normal = design.T @ np.linalg.solve(weighted, np.column_stack([design, ln_stiffness]))
    normal[1, 1:] += np.array([1.0, mean]) / std**2
    return float(np.linalg.solve(normal[:, :2], normal[:, 2])[1])


def nest(members: Record, priors: Record, geometry: Record, deflection: float, nested: int) -> None:
    """Replace the member `nested` of (n,) MEMBER by the one it differs from in the spring, with an exponential spring.

    `priors`: (n,) MEMBER at the start; see `condition_on_exponential`.
    """
    one, general, model = members[nested : nested + 1], NESTED[nested], members["model"][nested].copy()
    one[:] = members[general]
    one["model"] = model
    one["ln_likelihood"] += condition_on_exponential(one, priors[general : general + 1], geometry, deflection)
    one["linear"] = one["mean"]


def condition_on_exponential(member: Record, prior: Record, geometry: Record, deflection: float) -> float:
    """Condition a (1,) MEMBER of any spring, which was the (1,) MEMBER `prior` at its start, on an exponential spring.

    Returns the log likelihood of the exponential spring relative to any spring (Laplace approximation; MacKay, 2003,
    ch. 27). The likelihood of the coefficients is the posterior over the prior, both Gaussian. Over the knots j the law
    is exp(a + b (j - j_x)), j_x at a `deflection` [m] of the data, with the prior of scale and slope for a and b.
    """
    spring, z, p = slice(SPRING, SIZE), member[0]["mean"], member[0]["covariance"]
    if not np.isfinite(p).all():
        return -math.inf
    initial, prior_weight = prior[0]["mean"][spring], np.linalg.inv(prior[0]["covariance"][spring, spring])
    weight = np.linalg.inv(p[spring, spring])
    place = (deflection - float(geometry["origin"][0])) / float(geometry["spacing"][0])
    design = np.stack([np.ones(SPRING_SIZE), np.arange(SPRING_SIZE) - 1.0 - place], axis=1)
    information = weight @ z[spring] - prior_weight @ initial
    law, normal = np.zeros(SPRING_SIZE), np.zeros((2, 2))
    expected = math.log(initial[0]), SLOPE_STD * float(geometry["spacing"][0]) / float(geometry["unit"][0])
    ln_prior = most_probable_exponential(1.0 + place, weight - prior_weight, information, expected, law, normal)
    tangents = law[:, None] * design
    evidence = ln_prior - 0.5 * float(np.linalg.slogdet(normal)[1])
    evidence += _ln_density(law - z[spring], weight) - _ln_density(law - initial, prior_weight)
    regression = p[:, spring] @ weight  # of all states on the coefficients
    regression[spring] = np.eye(SPRING_SIZE)
    removed = p[spring, spring] - tangents @ np.linalg.solve(normal, tangents.T)
    bias = member[0]["bias"]
    bias += regression @ (tangents @ np.linalg.solve(normal, tangents.T @ weight @ bias[spring]) - bias[spring])
    z += regression @ (law - z[spring])
    p -= regression @ removed @ regression.T
    p += p.T
    p *= 0.5
    return evidence


@compiled
def cost_of_exponential(
    a: float, b: float, place: float, weight: Array, information: Array, prior: Prior, law: Array
) -> float:
    """Negative log posterior of exp(a + b (j - place)) over the coefficients j, which are written into `law`."""
    cost = 0.5 * ((a - prior[0]) / STIFFNESS_STD) ** 2 + 0.5 * (b / prior[1]) ** 2
    for j in range(law.size):
        law[j] = math.exp(a + b * (j - place))
    for i in range(law.size):
        product = 0.0
        for j in range(law.size):
            product += weight[i, j] * law[j]
        cost += law[i] * (0.5 * product - information[i])
    return cost


@compiled
def normal_of_exponential(
    a: float, b: float, place: float, weight: Array, information: Array, prior: Prior, law: Array
) -> tuple[float, float, float, float, float]:
    """Gradient of the log posterior by a and b, and its information matrix: entries aa, ab and bb."""
    variance_a, variance_b = STIFFNESS_STD**2, prior[1] ** 2
    by_a, by_b, aa, ab, bb = (prior[0] - a) / variance_a, -b / variance_b, 1.0 / variance_a, 0.0, 1.0 / variance_b
    for i in range(law.size):
        error, k = information[i], i - place
        for j in range(law.size):
            product = law[i] * weight[i, j] * law[j]
            error -= weight[i, j] * law[j]
            aa += product
            ab += product * k
            bb += product * k * (j - place)
        by_a += law[i] * error
        by_b += law[i] * error * k
    return by_a, by_b, aa, ab, bb


@compiled
def most_probable_exponential(
    place: float, weight: Array, information: Array, prior: Prior, law: Array, normal: Array
) -> float:
    """Most probable coefficients exp(a + b (j - place)) into `law`, information matrix of a and b into `normal` (2, 2).

    Returns the log prior density. For a Gaussian likelihood of the coefficients with the matrix `weight` and the vector
    `information`, and a Gaussian `prior` of a and b: Gauss-Newton steps, halved until the probability increases.
    """
    a, b = prior[0], 0.0
    cost = cost_of_exponential(a, b, place, weight, information, prior, law)
    for _ in range(FIT_STEPS):
        by_a, by_b, aa, ab, bb = normal_of_exponential(a, b, place, weight, information, prior, law)
        normal[0, 0], normal[1, 1] = aa, bb
        normal[0, 1] = normal[1, 0] = ab
        determinant = aa * bb - ab * ab
        step_a, step_b = (bb * by_a - ab * by_b) / determinant, (aa * by_b - ab * by_a) / determinant
        size = max(abs(step_a), abs(step_b))
        share = 1.0 / max(1.0, size / MAX_FIT_STEP)
        new = cost_of_exponential(a + share * step_a, b + share * step_b, place, weight, information, prior, law)
        while new > cost and share * size > MIN_FIT_STEP:
            share *= 0.5
            new = cost_of_exponential(a + share * step_a, b + share * step_b, place, weight, information, prior, law)
        if not share * size > MIN_FIT_STEP:
            break
        a, b, cost = a + share * step_a, b + share * step_b, new
    cost_of_exponential(a, b, place, weight, information, prior, law)
    squares = ((a - prior[0]) / STIFFNESS_STD) ** 2 + (b / prior[1]) ** 2
    return -0.5 * squares - math.log(STIFFNESS_STD * prior[1])


def _ln_density(error: Array, weight: Array) -> float:
    """Log of a Gaussian density at an error, up to a constant; `weight` is the inverse covariance."""
    return float(0.5 * np.linalg.slogdet(weight)[1] - 0.5 * error @ weight @ error)


@compiled
def spline_rows(geometry: Record, knots: Array, basis: Array, intervals: NDArray[np.int64]) -> None:
    """B-splines at the knots [m] (n,) into the zeros `basis` (n, j), and the interval of each into `intervals` (n,)."""
    w, slope = np.empty(4), np.empty(4)
    for k in range(knots.size):
        i = elastic_spline(geometry, knots[k], w, slope)
        basis[k, i : i + 4], intervals[k] = w, i


@compiled
def interpolation_variances(member: Record, intervals: NDArray[np.int64]) -> Array:
    """`interpolation_variance` [N^2/m^2] of a (1,) MEMBER in each of the intervals (n,)."""
    variances = np.empty(intervals.size)
    for k in range(intervals.size):
        variances[k] = interpolation_variance(member, intervals[k])
    return variances


def _knots(geometry: Record, span: tuple[float, float]) -> Array:
    origin, step = float(geometry["origin"][0]), float(geometry["spacing"][0]) / KNOTS_PER_INTERVAL
    last = INTERVALS * KNOTS_PER_INTERVAL
    first = min(max(math.floor((span[0] - origin) / step) - KNOTS_PER_INTERVAL, 0), last - 1)
    end = max(min(math.ceil((span[1] - origin) / step) + KNOTS_PER_INTERVAL, last), first + 1)
    return np.asarray(origin + step * np.arange(first, end + 1), np.float64)


def _integrals(geometry: Record, x: float) -> Array:
    origin, spacing = float(geometry["origin"][0]), float(geometry["spacing"][0])
    i, _ = locate(x, origin, spacing)
    integrals: Array = geometry["table"][0, i].copy()
    add_integrals(geometry, i, origin + i * spacing, x, integrals)
    return integrals
