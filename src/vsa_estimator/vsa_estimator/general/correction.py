# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Scalar updates of a member by deflection and force, in Joseph form. Bar-Shalom, Li and Kirubarajan, ch. 5 and 10."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.ekf import inflate_innovation
from vsa_estimator.force_law.friction import friction_model_std, smoothing_speed
from vsa_estimator.general.basis import damping_spline
from vsa_estimator.general.law import LAW, general_force, linearize
from vsa_estimator.general.records import (
    D0,
    D1,
    D2,
    DAMPER,
    DELAY,
    MOTION,
    SIZE,
    SPRING,
    SPRING_SIZE,
    A,
    B,
    M,
    Record,
    V,
    X,
)  # fmt: skip
from vsa_estimator.tuning.filter import (
    CROSS_NOISE_SHARE,
    FORCE_INFLATION,
    HARD_GATE,
    MIN_MATCHING_SPEED,
    MIN_REVERSAL_FORCE,
    REVERSAL_SHARE,
    REVERSAL_SPEED,
    REVERSAL_TIME,
    SOFT_GATE,
)  # fmt: skip
from vsa_estimator.tuning.force_law import MIN_D1
from vsa_estimator.tuning.general import (
    MAX_DAMPING_UNCERTAINTY,
    MAX_DELAY,
    MAX_STIFFNESS_UNCERTAINTY,
    MIN_DAMPING_SHARE,
    MIN_EVIDENCE_SPEED,
    MIN_LEVEL_RATIO,
    MOTION_GATE,
    UNEXPLAINED_TIME,
)  # fmt: skip


@compiled
def correct(member: Record, ph: Array, gain: Array, innovation: float, variance: float) -> None:
    """Joseph form for any gain: P becomes P - K (PH)' - (PH) K' + K S K', symmetric to the last bit.

    `ph` and `gain` of states that are not active are zero.
    """
    one = member[0]
    z, p = one["mean"], one["covariance"]
    rest = ph - 0.5 * variance * gain
    z += gain * innovation
    for i in one["active"][: one["count"]]:
        row, k, r = p[i], gain[i], rest[i]
        for j in range(SIZE):
            row[j] -= k * rest[j] + r * gain[j]
    if one["model"]["exponential"]:
        retract(member, gain, innovation)


@compiled
def retract(member: Record, gain: Array, innovation: float) -> None:
    """Keep the coefficients exponential over the knots after a linear update; the tangent space follows them.

    An update c_j (1 + a + b g_j) along the tangents c_j and c_j g_j of c_j = exp(alpha + beta g_j) becomes
    c_j (1 + a) exp(b g_j).
    """
    one, last = member[0], SPRING_SIZE - 1
    z, p, bias, active = one["mean"], one["covariance"], one["bias"], one["active"][: one["count"]]
    at_first, at_last = gain[SPRING] * innovation, gain[SPRING + last] * innovation
    at_first /= z[SPRING] - at_first
    at_last /= z[SPRING + last] - at_last
    level, rate = max(1.0 + 0.5 * (at_first + at_last), MIN_LEVEL_RATIO), (at_last - at_first) / last
    for j in range(SPRING_SIZE):
        i, scale = SPRING + j, level * math.exp(rate * (j - 0.5 * last))
        z[i] = (z[i] - gain[i] * innovation) * scale
        bias[i] *= scale
        for k in active:
            p[i, k] *= scale
            p[k, i] *= scale


@compiled
def reset_motion(member: Record, encoder: Record) -> None:
    """Set the motion to that of the encoder alone; the coefficients stay."""
    one = member[0]
    z, p, bias = one["mean"], one["covariance"], one["bias"]
    states = MOTION + 1 if one["model"]["encoder"] else MOTION
    bias[:states] = 0.0
    p[:states] = 0.0
    p[:, :states] = 0.0
    z[:MOTION] = encoder[0]["mean"]
    p[:MOTION, :MOTION] = encoder[0]["covariance"]
    if one["model"]["encoder"]:
        variance = one["model"]["travel_std"] ** 2
        z[B] = 0.0
        p[B, B] = variance
        p[X, X] += variance
        p[X, B] = p[B, X] = -variance


@compiled
def correct_deflection(member: Record, measured: float, noise: float) -> bool:
    """Update by a deflection [m] with the variance `noise` [m^2]; False where the motion has to be reset."""
    one = member[0]
    z, p, bias, share = one["mean"], one["covariance"], one["bias"], 1.0 if one["model"]["encoder"] else 0.0
    ph = p[X] + share * p[B]
    variance = ph[X] + share * ph[B] + noise
    innovation = measured - z[X] - share * z[B]
    one["ln_likelihood"] -= 0.5 * (math.log(variance) + min(innovation * innovation / variance, SOFT_GATE))
    if innovation * innovation > MOTION_GATE * variance:
        return False
    gain = ph / variance
    bias -= gain * (bias[X] + share * bias[B])
    correct(member, ph, gain, innovation, variance)
    return True


@compiled
def second_order(member: Record, geometry: Record, law: Record, smoothed: bool) -> tuple[float, float, float, float]:
    """Second-order terms of the force: mean [N], variance [N^2]; variances of stiffness and damping at the motion."""
    p, motion, out = member[0]["covariance"], member[0]["linear_covariance"], law[0]
    first, w = SPRING + out["interval"], out["factor"] * out["weights"]
    by_x, stiffness, by_v, damping = 0.0, 0.0, 0.0, 0.0
    for j in range(4):
        by_x += w[j] * p[X, first + j]
        for k in range(4):
            stiffness += w[j] * w[k] * p[first + j, first + k]
    if member[0]["model"]["spline_damper"]:
        b, slope = np.empty(3), np.empty(3)
        first = DAMPER + damping_spline(out["speed"], geometry[0]["speed_spacing"], b, slope)
        for j in range(3):
            by_v += b[j] * p[V, first + j]
            for k in range(3):
                damping += b[j] * b[k] * p[first + j, first + k]
    else:
        cubic = 3.0 * out["clipped"] * out["clipped"]
        by_v = out["below_peak"] * (p[V, D1] + cubic * p[V, D2])
        damping = out["below_peak"] * (p[D1, D1] + 2.0 * cubic * p[D1, D2] + cubic * cubic * p[D2, D2])
    bend = out["stiffness_slope"] * motion[X, X]
    variance = 0.5 * bend * bend + out["damper_variance"] + motion[X, X] * stiffness
    variance += motion[V, V] * damping + motion[A, A] * p[M, M]
    if smoothed:  # independent of the errors of the coefficients
        return 0.5 * bend, variance, stiffness, damping
    return 0.5 * bend + by_x + by_v + p[A, M], variance + by_x * by_x + by_v * by_v, stiffness, damping


@compiled
def reversal_variance(member: Record, law: Record, dt: float) -> float:
    """Variance [N^2] of the Coulomb model error around zero velocity, correlated over the time at rest."""
    one = member[0]
    friction = abs(law[0]["friction"]) + math.sqrt(one["covariance"][D0, D0])
    near = math.exp(-(one["linear"][V] ** 2) / (REVERSAL_SPEED**2 + 2.0 * one["linear_covariance"][V, V]))
    error = max(REVERSAL_SHARE * friction, MIN_REVERSAL_FORCE) * near
    return float(error * error * max(1.0, max(REVERSAL_TIME, one["time_since_motion"]) / dt))


@compiled
def is_evidence(encoder: Record) -> bool:
    """Whether a force at the motion of an ENCODER record counts in the likelihood: not near a reversal of friction.

    There `reversal_variance` and the speed's own, through the slope of the friction, are bounds that scale with the
    friction of each member.
    """
    width = REVERSAL_SPEED**2 + 2.0 * encoder["covariance"][V, V]
    return bool(encoder["mean"][V] ** 2 > MIN_EVIDENCE_SPEED**2 * width)


@compiled
def partial_update(member: Record, law: Record, stiffness: float, damping: float, gain: Array) -> None:
    """Zero the gains of states that the force does not determine (Schmidt).

    The mass without a significant acceleration; the motion while stiffness or damping at it, whose variances are
    given, are too uncertain: the force would pull the motion with a wrong gradient.
    """
    linear = member[0]["linear"]
    if linear[A] ** 2 < 9.0 * member[0]["linear_covariance"][A, A]:
        gain[M] = 0.0
    least = MIN_DAMPING_SHARE * max(linear[D1], linear[DAMPER])
    tolerance = MAX_DAMPING_UNCERTAINTY * max(abs(law[0]["damper_slope"]), least)
    if stiffness > (MAX_STIFFNESS_UNCERTAINTY * law[0]["stiffness"]) ** 2 or damping > tolerance * tolerance:
        gain[:MOTION] = 0.0


@compiled
def correct_force(member: Record, geometry: Record, step: Record) -> None:
    """Update by the force of `step`, (1,) STEP; beyond the gate it is rejected."""
    smoothed = linearize(member, step)
    one, now = member[0], step[0]
    z, p, bias, gain, dt = one["mean"], one["covariance"], one["bias"], one["gain"], now["dt"]
    linear, speed_variance = one["linear"], one["linear_covariance"][V, V]
    active = one["active"][: one["count"]]
    gradient, law = np.zeros(SIZE), np.empty(1, LAW)
    coulomb_speed = smoothing_speed(linear[A], speed_variance, dt)
    expected = general_force(member, geometry, coulomb_speed, math.sqrt(speed_variance), gradient, law)
    mean, spread, stiffness, damping = second_order(member, geometry, law, smoothed)
    own = CROSS_NOISE_SHARE * law[0]["stiffness"] ** 2 * now["deflection_variance"]
    ph = np.zeros(SIZE)
    variance = now["force_variance"] + spread + reversal_variance(member, law, dt) + own
    for i in active:
        row, slope = p[i], gradient[i]
        for j in range(SIZE):
            ph[j] += slope * row[j]
    for i in active:
        variance += gradient[i] * ph[i]
    innovation = now["force"] - expected - mean
    modelled, variance = variance, variance + max(one["unexplained"], 0.0)
    nis = innovation * innovation / variance
    one["innovation"], one["innovation_variance"] = innovation, variance
    if is_evidence(now["encoder"]):
        one["ln_likelihood"] -= 0.5 * (math.log(variance) + min(nis, SOFT_GATE))
    match_unexplained(member, innovation, modelled, dt)
    if nis > HARD_GATE:
        return
    inflated = inflate_innovation(nis, variance, FORCE_INFLATION)
    gain[:] = ph / inflated
    partial_update(member, law, stiffness, damping, gain)
    error = friction_model_std(linear[V], abs(law[0]["friction"]), coulomb_speed)
    error -= np.sum(gradient * bias)
    bias += gain * error
    correct(member, ph, gain, innovation, inflated - own)
    apply_bounds(z)


@compiled
def match_unexplained(member: Record, innovation: float, modelled: float, dt: float) -> None:
    """Covariance matching (Mehra, 1970): leaky mean of the squared innovation beyond the modelled variance [N^2]."""
    if abs(member[0]["mean"][V]) > MIN_MATCHING_SPEED:
        square = min(innovation * innovation, SOFT_GATE * member[0]["innovation_variance"])
        member[0]["unexplained"] += dt / UNEXPLAINED_TIME * (square - modelled - member[0]["unexplained"])


@compiled
def apply_bounds(z: Array) -> None:
    """Keep the coefficients within their physical bounds."""
    z[M] = max(z[M], 0.0)
    z[D0] = max(z[D0], 0.0)
    z[D1] = max(z[D1], MIN_D1)
    z[DELAY] = min(max(z[DELAY], -MAX_DELAY), MAX_DELAY)
