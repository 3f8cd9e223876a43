# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of eqs. (8) and (9) with its covariance, predicted from the last step of the filter."""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.records import Record
from vsa_estimator.force_law.damper import clip_speed, damping, damping_slope, peak_speed
from vsa_estimator.force_law.elastic import ln_stiffness_gradient, stiffness
from vsa_estimator.force_law.state import D1, D2, K2, SIZE, A, M, S, V, X


@compiled
def predict_motion(z: Array, p: Array, ahead: float, jerk_density: float, prediction: Record) -> None:
    """Deflection, velocity and acceleration with their variances, `ahead` [s], into `prediction`."""
    out, t, q = prediction[0], ahead, jerk_density
    half = 0.5 * t * t
    out["deflection"] = z[X] + t * z[V] + half * z[A]
    variance = p[X, X] + 2.0 * (t * p[X, V] + half * p[X, A]) + t * t * (p[V, V] + t * p[V, A]) + half * half * p[A, A]
    out["deflection_variance"] = variance + q * t**5 / 20.0
    out["velocity"] = z[V] + t * z[A]
    out["velocity_variance"] = p[V, V] + 2.0 * t * p[V, A] + t * t * p[A, A] + q * t**3 / 3.0
    out["acceleration"] = z[A]
    out["acceleration_variance"] = p[A, A] + q * t


@compiled
def ln_stiffness_component(row: Array, t: float, by_x: float, by_s: float, by_k2: float) -> float:
    """Product of a row (10) with the gradient of the ln stiffness predicted by t [s]."""
    return by_x * (row[X] + t * row[V] + 0.5 * t * t * row[A]) + by_s * row[S] + by_k2 * row[K2]


@compiled
def damping_component(row: Array, t: float, by_v: float, by_d2: float) -> float:
    """Product of a row (10) with the gradient of the damping predicted by t [s]."""
    return by_v * (row[V] + t * row[A]) + row[D1] + by_d2 * row[D2]


@compiled
def predict_output(state: Record, reference: float, ahead: float, jerk_density: float, prediction: Record) -> None:
    """Motion and impedance with their covariance, `ahead` [s] of `state`, into `prediction`; `state` is unchanged.

    `state` is (1,) FILTER_STATE, `prediction` (1,) PREDICTION, `reference` [m] that of s, `jerk_density` [m^2/s^5].
    The friction bias and the entries of `uncertainty` count as standard deviations beyond the covariance; the scales
    of `uncertainty` reduce the gradients by position and velocity. Gradients are propagated back to the state.
    """
    z, p, bias, beyond = state[0]["mean"], state[0]["covariance"], state[0]["friction_bias"], state[0]["uncertainty"]
    predict_motion(z, p, ahead, jerk_density, prediction)
    out, t, q = prediction[0], ahead, jerk_density
    d1, d2, dx = z[D1], z[D2], out["deflection"] - reference
    sigma, v_peak = stiffness(z[S], z[K2], dx), peak_speed(d1, d2)
    c = clip_speed(out["velocity"], v_peak)
    by_x, by_s, by_k2 = ln_stiffness_gradient(z[K2], dx)
    by_v, by_d2 = damping_slope(d2, c), 3.0 * c * c
    scaled_x, scaled_v = by_x * beyond["position_scale"], by_v * beyond["velocity_scale"]
    p_ln, p_damping = np.empty(SIZE), np.empty(SIZE)
    for i in range(SIZE):
        p_ln[i] = ln_stiffness_component(p[i], t, scaled_x, by_s, by_k2)
        p_damping[i] = damping_component(p[i], t, scaled_v, by_d2)
    bias_ln, bias_damping = ln_stiffness_component(bias, t, by_x, by_s, by_k2), damping_component(bias, t, by_v, by_d2)

    variance = ln_stiffness_component(p_ln, t, scaled_x, by_s, by_k2) + by_x * by_x * q * t**5 / 20.0
    out["stiffness"] = sigma
    out["ln_stiffness_variance"] = variance + (bias_ln * bias_ln + (beyond["stiffness_std"] / sigma) ** 2)
    variance = damping_component(p_damping, t, scaled_v, by_d2)
    variance += by_v * by_v * q * t**3 / 3.0 + bias_damping * bias_damping
    out["damping"] = damping(d1, d2, c)
    out["damping_variance"] = variance + ((by_d2 * beyond["d2_std"]) ** 2 + beyond["d1_std"] ** 2)
    out["inertia"] = z[M]
    out["inertia_variance"] = beyond["inertia_variance"]
    covariance = damping_component(p_ln, t, scaled_v, by_d2) + by_x * by_v * q * t**4 / 8.0
    out["stiffness_damping_covariance"] = sigma * (covariance + bias_ln * bias_damping)
    out["stiffness_inertia_covariance"] = sigma * p_ln[M]
    out["damping_inertia_covariance"] = p_damping[M]
    out["peak_speed"] = v_peak
