# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force of the general transmission with its gradient.

It is linearised at `linear`: the state itself while the bank runs live; while it repeats its stored steps, the
coefficients of its last pass (iterated filter; Jazwinski, 1970), and the more certain motion of the state and that of
the smoothed encoder. At the motion of `linear` the force is exactly linear in the coefficients of the state.
"""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.damper import clip_speed, damper_terms, peak_speed
from vsa_estimator.force_law.friction import friction_slope, smoothed_sign
from vsa_estimator.general.basis import add_integrals, damper_integrals, elastic_spline, growth_factor
from vsa_estimator.general.records import (
    D0,
    D1,
    D2,
    DAMPER,
    DAMPER_SIZE,
    DELAY,
    HYSTERESIS,
    HYSTERESIS_SIZE,
    MOTION,
    RELAXATION,
    RELAXATION_SIZE,
    SIZE,
    SPRING,
    SPRING_SIZE,
    STRIBECK,
    STRIBECK_SIZE,
    A,
    B,
    L,
    M,
    Record,
    V,
    X,
)  # fmt: skip
from vsa_estimator.tuning.general import (
    MIN_SPEED_STD,
    STRIBECK_SPEEDS,
)  # fmt: skip

STRIBECK_SPEED = np.array(STRIBECK_SPEEDS)
HERMITE = np.array([-math.sqrt(3.0), 0.0, math.sqrt(3.0)])  # Gauss-Hermite, exact to the fifth moment
HERMITE_WEIGHTS = np.array([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0])

LAW = np.dtype([
    ("stiffness", "f8"), ("stiffness_slope", "f8"),  # [N/m, N/m^2]
    ("interval", "i8"), ("factor", "f8"), ("weights", "f8", (4,)),  # of the elastic spline
    ("deflection", "f8"), ("speed", "f8"),  # at the delayed instant
    ("damper_slope", "f8"), ("damper_variance", "f8"),  # of the statistical linearisation [N s/m, N^2]
    ("below_peak", "f8"), ("clipped", "f8"),  # of the paper's damper
    ("friction", "f8"), ("friction_slope", "f8"),  # amplitude [N], slope [N s/m]
])  # fmt: skip


@compiled
def prefers_smoothed(member: Record, step: Record) -> bool:
    """Whether the smoothed motion of `step`, (1,) STEP, is more certain than that of the member."""
    smoothed = step[0]["smoothed_covariance"][V, V] < member[0]["covariance"][V, V]
    return bool(step[0]["relinearizing"] and smoothed)


@compiled
def linearize(member: Record, step: Record) -> bool:
    """Set the point at which the force of `step`, (1,) STEP, is linearised; whether its motion is the smoothed one."""
    one, now = member[0], step[0]
    if prefers_smoothed(member, step):
        one["linear"][:MOTION] = now["smoothed"]
        one["linear_covariance"][:] = now["smoothed_covariance"]
        return True
    states = MOTION if now["relinearizing"] else SIZE
    one["linear"][:states] = one["mean"][:states]
    one["linear_covariance"][:] = one["covariance"][:MOTION, :MOTION]
    return False


@compiled
def add_spring(member: Record, geometry: Record, gradient: Array, law: Record) -> float:
    """Elastic force [N] and its gradient; stiffness and its slope into `law`, (1,) LAW."""
    z, linear, out = member[0]["mean"], member[0]["linear"], law[0]
    x, w, slope = out["deflection"], out["weights"], np.empty(4)
    i = elastic_spline(geometry, x, w, slope)
    integrals = gradient[SPRING:]
    integrals[:] = geometry[0]["table"][i]
    add_integrals(geometry, i, geometry[0]["origin"] + i * geometry[0]["spacing"], x, integrals)
    factor, relative, relative_slope, force = growth_factor(geometry, x), 0.0, 0.0, 0.0
    for j in range(4):
        relative += w[j] * linear[SPRING + i + j]
        relative_slope += slope[j] * linear[SPRING + i + j]
    for j in range(SPRING_SIZE):
        force += integrals[j] * z[SPRING + j]
    out["interval"], out["factor"] = i, factor
    out["stiffness"] = factor * relative
    out["stiffness_slope"] = factor * (geometry[0]["growth"] * relative + relative_slope)
    return force


@compiled
def add_damper(member: Record, geometry: Record, speed_std: float, gradient: Array, law: Record) -> float:
    """Mean damper force [N] over a Gaussian speed, and its gradient; statistical linearisation into `law`."""
    z, linear, out = member[0]["mean"], member[0]["linear"], law[0]
    std, basis = max(speed_std, MIN_SPEED_STD), np.empty(DAMPER_SIZE)
    peak = peak_speed(linear[D1], linear[D2])
    force, mean, square, slope, below = 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(3):
        v, weight, at = out["speed"] + HERMITE[n] * std, HERMITE_WEIGHTS[n], 0.0
        if member[0]["model"]["spline_damper"]:
            damper_integrals(v, geometry[0]["speed_spacing"], basis)
            for j in range(DAMPER_SIZE):
                at += basis[j] * linear[DAMPER + j]
                force += weight * basis[j] * z[DAMPER + j]
                gradient[DAMPER + j] += weight * basis[j]
        else:
            c = clip_speed(v, peak)
            at = sum(damper_terms(linear[D1], linear[D2], c))
            force += weight * sum(damper_terms(z[D1], z[D2], c))
            gradient[D1] += weight * c
            gradient[D2] += weight * c**3
            below += weight if abs(c) < peak else 0.0
        mean += weight * at
        square += weight * at * at
        slope += weight * at * HERMITE[n] / std
    out["damper_slope"], out["below_peak"] = slope, below
    out["damper_variance"] = max(square - mean * mean - (slope * std) ** 2, 0.0)
    out["clipped"] = clip_speed(out["speed"], peak)
    return force


@compiled
def add_friction(member: Record, coulomb_speed: float, gradient: Array, law: Record) -> float:
    """Friction force [N] with a Stribeck dip, and its gradient."""
    z, linear, out = member[0]["mean"], member[0]["linear"], law[0]
    v = out["speed"]
    sign = smoothed_sign(v, coulomb_speed)
    amplitude, slope, force = linear[D0], 0.0, z[D0] * sign
    gradient[D0] = sign
    for k in range(STRIBECK_SIZE):
        near = math.exp(-((v / STRIBECK_SPEED[k]) ** 2))
        gradient[STRIBECK + k] = sign * near
        force += sign * near * z[STRIBECK + k]
        amplitude += near * linear[STRIBECK + k]
        slope -= 2.0 * v / STRIBECK_SPEED[k] ** 2 * near * linear[STRIBECK + k]
    out["friction"] = amplitude
    out["friction_slope"] = friction_slope(amplitude, sign, coulomb_speed) + slope * sign
    return force


@compiled
def general_force(
    member: Record, geometry: Record, coulomb_speed: float, speed_std: float, gradient: Array, law: Record
) -> float:
    """Force [N] of a member at its state; `gradient` (SIZE,) and `law`, (1,) LAW, are overwritten.

    The force lags the encoder by the state DELAY, to second order in it. `coulomb_speed` [m/s] smooths the sign of the
    friction, `speed_std` [m/s] is the standard deviation of the speed.
    """
    z, linear, out = member[0]["mean"], member[0]["linear"], law[0]
    delay, v, a = linear[DELAY], linear[V], linear[A]
    gradient[:] = 0.0
    out["deflection"] = linear[X] - delay * v + 0.5 * delay * delay * a
    out["speed"] = v - delay * a
    force = z[L] + z[M] * a + add_spring(member, geometry, gradient, law)
    force += add_damper(member, geometry, speed_std, gradient, law)
    force += add_friction(member, coulomb_speed, gradient, law)
    for k in range(RELAXATION_SIZE):
        gradient[RELAXATION + k] = member[0]["relaxation"][k]
        force += member[0]["relaxation"][k] * z[RELAXATION + k]
    for k in range(HYSTERESIS_SIZE):
        gradient[HYSTERESIS + k] = member[0]["stop"][k]
        force += member[0]["stop"][k] * z[HYSTERESIS + k]
    if not member[0]["model"]["encoder"]:
        gradient[B] = 1.0
        force += z[B]
    stiffness, by_speed = out["stiffness"], out["damper_slope"] + out["friction_slope"]
    gradient[L], gradient[M], gradient[X] = 1.0, a, stiffness
    gradient[V] = by_speed - delay * stiffness
    gradient[A] = linear[M] + 0.5 * delay * delay * stiffness - delay * by_speed
    gradient[DELAY] = -stiffness * (v - delay * a) - by_speed * a
    for i in (X, V, A, DELAY):
        force += gradient[i] * (z[i] - linear[i])
    return force
