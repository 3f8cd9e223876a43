# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of a member at its present motion, and the moment-matched mixture of all members."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.damper import damping as paper_damping
from vsa_estimator.force_law.damper import damping_slope, peak_speed
from vsa_estimator.general.basis import damping_spline, elastic_spline, extrapolation, locate
from vsa_estimator.general.lack_of_fit import inflation, interpolation_variance
from vsa_estimator.general.records import (
    D0,
    D1,
    D2,
    DAMPER,
    IMPEDANCE,
    SIZE,
    SPRING,
    L,
    M,
    Record,
    V,
    X,
)  # fmt: skip
from vsa_estimator.tuning.filter import PEAK_FRACTION
from vsa_estimator.tuning.general import (
    DAMPING_BIAS,
    LIKELIHOOD_POWER,
    MIN_PROBABILITY,
    MIN_RELATIVE_STIFFNESS,
    SLOPE_STD,
    STIFFNESS_BIAS,
)  # fmt: skip


@compiled
def ln_stiffness(member: Record, geometry: Record, gradient: Array, slope_gradient: Array) -> tuple[float, float]:
    """Natural logarithm of the stiffness in N/m, its slope over the deflection [1/m], and both gradients (SIZE,)."""
    z, now = member[0]["mean"], geometry[0]
    x, w, slope = z[X], np.empty(4), np.empty(4)
    i = elastic_spline(geometry, x, w, slope)
    relative, relative_slope = 0.0, 0.0
    for j in range(4):
        relative += w[j] * z[SPRING + i + j]
        relative_slope += slope[j] * z[SPRING + i + j]
    relative = max(relative, MIN_RELATIVE_STIFFNESS * abs(z[SPRING + i]) + 1e-6)
    for j in range(4):
        gradient[SPRING + i + j] = w[j] / relative
        slope_gradient[SPRING + i + j] = (slope[j] - relative_slope / relative * w[j]) / relative
    gradient[X] = now["growth"] + relative_slope / relative
    return now["growth"] * (x - now["reference"]) + math.log(relative), gradient[X]


@compiled
def damping(member: Record, geometry: Record, gradient: Array) -> tuple[float, float, bool]:
    """Damping [N s/m], its slope over the speed, its gradient (SIZE,), and whether the speed is near or beyond v*."""
    z = member[0]["mean"]
    v, value = z[V], 0.0
    if member[0]["model"]["spline_damper"]:
        w, slope = np.empty(3), np.empty(3)
        i = DAMPER + damping_spline(v, geometry[0]["speed_spacing"], w, slope)
        for j in range(3):
            value += w[j] * z[i + j]
            gradient[i + j] = w[j]
            gradient[V] += slope[j] * z[i + j]
        return value, gradient[V], False
    peak = peak_speed(z[D1], z[D2])
    if abs(v) < peak:
        value = paper_damping(z[D1], z[D2], v)
        gradient[D1], gradient[D2], gradient[V] = 1.0, 3.0 * v * v, damping_slope(z[D2], v)
    return value, gradient[V], abs(v) > PEAK_FRACTION * peak


@compiled
def quadratic_form(member: Record, gradient: Array) -> float:
    """Variance of an output with this gradient (SIZE,): covariance and friction bias."""
    one = member[0]
    p, active, variance, bias = one["covariance"], one["active"][: one["count"]], 0.0, 0.0
    for i in active:
        if gradient[i] != 0.0:
            bias += gradient[i] * one["bias"][i]
            for j in active:
                variance += gradient[i] * p[i, j] * gradient[j]
    return max(variance, 0.0) + bias * bias


@compiled
def member_impedance(member: Record, geometry: Record, out: Record) -> None:
    """Stiffness and damping of a member with variances inflated by its lack of fit, into `out`, (1,) IMPEDANCE."""
    one, o, now = member[0], out[0], geometry[0]
    of_stiffness, of_damping, of_slope = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE)
    o["ln_stiffness"], o["slope"] = ln_stiffness(member, geometry, of_stiffness, of_slope)
    value, slope, beyond = damping(member, geometry, of_damping)
    o["damping"], o["damping_slope"], o["beyond_peak"] = value, slope, 1.0 if beyond else 0.0
    if one["innovation"] != 0.0:
        variance = one["innovation_variance"]
        influence = np.sum(of_stiffness * one["gain"])
        one["stiffness_inflation"] = inflation(one["stiffness_lack"], influence, one["innovation"], variance)
        influence = np.sum(of_damping * one["gain"])
        one["damping_inflation"] = inflation(one["damping_lack"], influence, one["innovation"], variance)
    o["ln_stiffness_variance"] = quadratic_form(member, of_stiffness) * max(one["stiffness_inflation"], 1.0)
    interval, _ = locate(one["mean"][X], now["origin"], now["spacing"])
    grown = now["growth"] * (one["mean"][X] - now["reference"])
    o["ln_stiffness_variance"] += interpolation_variance(member, interval) * math.exp(2.0 * (grown - o["ln_stiffness"]))
    o["ln_stiffness_variance"] += (SLOPE_STD * extrapolation(geometry, one["mean"][X])) ** 2
    o["slope_variance"] = quadratic_form(member, of_slope) * max(one["stiffness_inflation"], 1.0)
    o["damping_variance"] = quadratic_form(member, of_damping) * max(one["damping_inflation"], 1.0)
    spline = one["model"]["spline_damper"]
    o["rest_damping"] = 0.5 * (one["mean"][DAMPER] + one["mean"][DAMPER + 1]) if spline else one["mean"][D1]
    o["inertia"], o["level"], o["coulomb"] = one["mean"][M], one["mean"][L], one["mean"][D0]


@compiled
def mixture(members: Record, geometry: Record, probabilities: Array, out: Record) -> int:
    """Moment-matched impedance and motion of all members, into `out`, (1,) IMPEDANCE; the probabilities are updated.

    Returns the index of the most probable member.
    The power of the likelihood is that of a coarsened posterior (Miller and Dunson, 2019): no member is the true law.
    """
    top, total = -np.inf, 0.0
    for m in range(members.size):
        top = max(top, members[m]["ln_likelihood"])
    for m in range(members.size):
        evidence = LIKELIHOOD_POWER * (members[m]["ln_likelihood"] - top)
        probabilities[m] = math.exp(evidence + members[m]["model"]["ln_prior"])
        total += probabilities[m]
    kept, best = 0.0, 0
    for m in range(members.size):
        probabilities[m] /= total
        best = m if probabilities[m] > probabilities[best] else best
        kept += probabilities[m] if probabilities[m] >= MIN_PROBABILITY else 0.0
    result, part = out[0], np.zeros(1, IMPEDANCE)
    squares = np.zeros(2)
    result["ln_stiffness"] = result["ln_stiffness_variance"] = result["slope"] = result["damping"] = 0.0
    result["slope_variance"] = result["rest_damping"] = 0.0
    result["damping_variance"] = result["damping_slope"] = result["beyond_peak"] = 0.0
    result["inertia"] = result["level"] = result["coulomb"] = 0.0
    result["motion"][:] = 0.0
    result["motion_covariance"][:, :] = 0.0
    for m in range(members.size):
        w = probabilities[m]
        if w < MIN_PROBABILITY:
            continue
        member_impedance(members[m : m + 1], geometry, part)
        add_part(result, part[0], members[m], w / kept, squares)
    result["ln_stiffness_variance"] += max(squares[0] - result["ln_stiffness"] ** 2, 0.0)
    result["damping_variance"] += max(squares[1] - result["damping"] ** 2, 0.0)
    result["ln_stiffness_variance"] += STIFFNESS_BIAS**2
    result["damping_variance"] += (DAMPING_BIAS * result["rest_damping"]) ** 2
    return best


@compiled
def add_part(result: Record, part: Record, member: Record, w: float, squares: Array) -> None:
    """Add the impedance `part` of a `member` with the weight w to `result`; squares of the means to `squares` (2,)."""
    result["ln_stiffness"] += w * part["ln_stiffness"]
    result["ln_stiffness_variance"] += w * part["ln_stiffness_variance"]
    result["slope"] += w * part["slope"]
    result["slope_variance"] += w * part["slope_variance"]
    result["rest_damping"] += w * part["rest_damping"]
    result["damping"] += w * part["damping"]
    result["damping_variance"] += w * part["damping_variance"]
    result["damping_slope"] += w * part["damping_slope"]
    result["beyond_peak"] += w * part["beyond_peak"]
    result["inertia"] += w * part["inertia"]
    result["level"] += w * part["level"]
    result["coulomb"] += w * part["coulomb"]
    squares[0] += w * part["ln_stiffness"] ** 2
    squares[1] += w * part["damping"] ** 2
    result["motion"] += w * member["mean"][:3]
    result["motion_covariance"] += w * member["covariance"][:3, :3]
