# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness of a recording without a model of spring or damper: local regression of the force on the deflection.

At an instant t with deflection x, all samples within SPAN of t and within a share of the stroke of x are weighted by
tricubes of both distances (W. S. Cleveland, J. American Statistical Association 74, 1979). The force is regressed on

    1, u, u^2, u^3    u: deflection minus x; the coefficient of u is the stiffness
    v, v^3, sgn v     rate effects: viscous force, friction, and a constant delay of the force, sigma v tau

Force and deflection are two-sided, so the result is not causal. Strokes in both directions separate u from v; where the
window does not contain them, the standard deviation is large and the reference is undefined. The result is the slope at
the frequency of the motion: M omega^2 of a single tone and a branch that relaxes slower than SPAN remain part of it.
Standard deviations are those of clusters of CLUSTER seconds (K.-Y. Liang, S. L. Zeger, Biometrika 73, 1986), because
the residuals are correlated, combined with the difference to the slope in a wider window, because the cubic has a bias.
"""

from dataclasses import dataclass

import numpy as np
from vsa_common.types import Array, Integers
from vsa_estimator.offline.local_polynomials import best_half, local_polynomials

SPAN = 4.0  # [s], half the window in time
STROKE_SHARE = 0.25  # half the window in deflection, of the 5 to 95 % range
WIDER = 1.4  # times that, for the bias
SIGN_SHARE = 0.05  # speed at which sgn v is smoothed, of the rms speed
CLUSTER = 0.1  # [s]
RATE_HZ = 10.0  # instants a second
MAX_RELATIVE_STD = 0.03  # of a defined reference
LEAST_CLUSTERS = 20  # for seven coefficients


@dataclass(frozen=True)
class Reference:
    """Stiffness [N/m] at the samples `index`, with its standard deviation."""

    index: Integers
    stiffness: Array
    std: Array


def local_slopes(time: Array, force: Array, deflection: Array) -> Reference:
    """The reference where it is defined, at RATE_HZ or at every sample of a slower recording."""
    signals = _signals(time, force, deflection)
    step = max(1, round(1.0 / (RATE_HZ * (signals.time[1] - signals.time[0]))))
    found = []
    for k in range(0, len(signals.time), step):
        slope, std = _slope_at(signals, k, signals.width)
        wide, _ = _slope_at(signals, k, WIDER * signals.width)
        std = float(np.hypot(std, wide - slope))
        if 0.0 < std < MAX_RELATIVE_STD * slope:
            found.append((np.searchsorted(time, signals.time[k]), slope, std))
    index, stiffness, stds = np.array(found, float).reshape(-1, 3).T
    return Reference(index.astype(np.int64), stiffness, stds)


@dataclass(frozen=True)
class _Signals:
    """Signals at even stamps; scales of deflection and velocity."""

    time: Array
    force: Array
    deflection: Array
    velocity: Array
    width: float
    speed: float


def _signals(time: Array, force: Array, deflection: Array) -> _Signals:
    """Force as measured, smooth deflection and its rate, at even stamps with the median period."""
    even = np.arange(time[0], time[-1], float(np.median(np.diff(time))))
    measured = np.interp(even, time, deflection)
    polynomials = local_polynomials(even, best_half(even, measured))
    x, v = (polynomials.apply(weights, measured) for weights in (polynomials.value, polynomials.slope))
    low, high = np.quantile(x, (0.05, 0.95))
    width = max(STROKE_SHARE * float(high - low), 1e-9)
    return _Signals(even, np.interp(even, time, force), x, v, width, max(float(np.sqrt(np.mean(v**2))), 1e-12))


def _slope_at(signals: _Signals, k: int, width: float) -> tuple[float, float]:
    """Stiffness [N/m] and its standard deviation at row `k`, from deflections within `width` [m]."""
    time, x = signals.time, signals.deflection
    near = slice(*np.searchsorted(time, (time[k] - SPAN, time[k] + SPAN)))
    weights = _tricube((time[near] - time[k]) / SPAN) * _tricube((x[near] - x[k]) / width)
    used = weights > 0.0
    rows = _regressors((x[near][used] - x[k]) / width, signals.velocity[near][used] / signals.speed)
    clusters = ((time[near][used] - time[near][0]) / CLUSTER).astype(int)
    slope, std = _slope(rows, signals.force[near][used], weights[used], clusters)
    return slope / width, std / width


def _regressors(u: Array, v: Array) -> Array:
    """Rows for scaled deflections and velocities, (samples, 7)."""
    return np.stack([np.ones_like(u), u, u**2, u**3, v, v**3, np.tanh(v / SIGN_SHARE)], axis=1)


def _slope(rows: Array, force: Array, weights: Array, clusters: Integers) -> tuple[float, float]:
    """Weighted least squares: coefficient of u and its standard deviation, infinite where it is not determined."""
    names, cluster = np.unique(clusters, return_inverse=True)
    if len(names) < LEAST_CLUSTERS:
        return 0.0, np.inf
    normal = (rows * weights[:, None]).T @ rows
    if np.linalg.cond(normal) > 1.0 / np.finfo(float).eps:
        return 0.0, np.inf
    inverse = np.linalg.inv(normal)
    coefficients = inverse @ (rows.T @ (weights * force))
    scores = rows * (weights * (force - rows @ coefficients))[:, None]
    sums = np.zeros((len(names), rows.shape[1]))
    np.add.at(sums, cluster, scores)
    scale = len(names) / (len(names) - rows.shape[1])
    covariance = scale * inverse @ (sums.T @ sums) @ inverse
    return float(coefficients[1]), float(np.sqrt(covariance[1, 1]))


def _tricube(distance: Array) -> Array:
    return np.asarray(np.maximum(1.0 - np.abs(distance) ** 3, 0.0) ** 3)
