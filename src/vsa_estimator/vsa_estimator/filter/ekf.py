# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Extended Kalman filter: prediction and scalar updates in Joseph form, each with a gate.

`state` is (1,) FILTER_STATE, `excitation` (1,) EXCITATION, `monitor` (1,) MONITOR. Bar-Shalom, Li and Kirubarajan,
Estimation with Applications to Tracking and Navigation, ch. 5 and 10.
"""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.consider import force_update_mask, partial_update_mask, propagate_bias
from vsa_estimator.filter.excitation import (
    accumulate_excitation,
    accumulate_matching,
    accumulate_time_since_motion,
    is_stationary,
    kinematic_force_variance,
    stroke,
)
from vsa_estimator.filter.measurement_noise import friction_error_variance, measurement_cross_noise
from vsa_estimator.filter.process_noise import add_jerk_process_noise, add_parameter_process_noise
from vsa_estimator.filter.records import ForceMeasurement, Record
from vsa_estimator.force_law.damper import linearize_near_peak
from vsa_estimator.force_law.friction import friction_model_std, smoothing_speed
from vsa_estimator.force_law.state import D0, D1, K2, SIZE, A, M, V, X
from vsa_estimator.force_law.transmission import force
from vsa_estimator.tuning.filter import DEFLECTION_INFLATION, FORCE_INFLATION, HARD_GATE, SOFT_GATE
from vsa_estimator.tuning.force_law import MIN_D1, MIN_K2

STATIONARY, REJECTED, ACCEPTED = range(3)  # results of `process_force`


@compiled
def predict(state: Record, dt: float, jerk_density: float) -> None:
    """Predict by dt [s]: constant acceleration, white jerk of `jerk_density` [m^2/s^5]."""
    z, p = state[0]["mean"], state[0]["covariance"]
    half = 0.5 * dt * dt
    z[0] += dt * z[1] + half * z[2]
    z[1] += dt * z[2]
    p[0] += dt * p[1] + half * p[2]
    p[1] += dt * p[2]
    p[:, 0] += dt * p[:, 1] + half * p[:, 2]
    p[:, 1] += dt * p[:, 2]
    add_jerk_process_noise(p, dt, jerk_density)
    for i in range(3):
        p[i + 1 :, i] = p[i, i + 1 :]
    propagate_bias(state[0]["friction_bias"], dt)


@compiled
def apply_correction(z: Array, p: Array, ph: Array, gain: Array, innovation: float, variance: float) -> None:
    """Joseph form for any gain: P becomes P - K (PH)' - (PH) K' + K S K', symmetric to the bit."""
    z += gain * innovation
    for i in range(SIZE):
        p[i] += gain[i] * (variance * gain - ph) - ph[i] * gain
    for i in range(SIZE):
        p[i + 1 :, i] = p[i, i + 1 :]


@compiled
def inflate_innovation(nis: float, variance: float, exponent: float) -> float:
    """Innovation variance inflated beyond the soft gate by (nis / gate)^exponent (M-estimation).

    With 1/2 the influence of an innovation beyond the gate is constant; above 1/2 it decreases.
    """
    return variance * (nis / SOFT_GATE) ** exponent if nis > SOFT_GATE else variance


@compiled
def update_deflection(state: Record, excitation: Record, monitor: Record, measured: float, noise: float) -> bool:
    """Update by a deflection [m] with the variance `noise` [m^2]; False where the gate rejects it."""
    z, p, bias = state[0]["mean"], state[0]["covariance"], state[0]["friction_bias"]
    ph = p[X].copy()
    variance = ph[X] + noise
    innovation = measured - z[X]
    nis = innovation * innovation / variance
    monitor[0]["innovation"] = innovation
    monitor[0]["variance"] = variance
    monitor[0]["nis"] = nis
    if nis > HARD_GATE:
        return False
    variance = inflate_innovation(nis, variance, DEFLECTION_INFLATION)
    gain = ph / variance
    partial_update_mask(z, p, stroke(excitation), gain)
    apply_correction(z, p, ph, gain, innovation, variance)
    bias -= gain * bias[X]
    return True


@compiled
def second_order_terms(hessian: Array, p: Array) -> tuple[float, float]:
    """tr(H P) and tr(H P H P): twice the mean and twice the variance of the second-order term of the force [N, N^2]."""
    curvature = hessian @ p
    trace = 0.0
    for i in range(SIZE):
        trace += curvature[i, i]
    return trace, np.sum(curvature * curvature.T)


@compiled
def apply_bounds(z: Array) -> None:
    """Keep the coefficients within their physical bounds."""
    z[K2] = max(z[K2], MIN_K2)
    z[D1] = max(z[D1], MIN_D1)
    z[M] = max(z[M], 0.0)
    z[D0] = max(z[D0], 0.0)


@compiled
def update_force(state: Record, excitation: Record, monitor: Record, measurement: ForceMeasurement) -> bool:
    """Update by a force; False where the gate rejects it.

    Second-order filter: mean and variance of the force's curvature under P go into innovation and noise. The gain
    includes the noise of the encoder through the stiffness (measurement cross-noise), without which the stiffness
    drifts by 0.1 % on a short stroke. The covariance is that of this suboptimal gain with the actual noise.
    """
    z, p, bias = state[0]["mean"], state[0]["covariance"], state[0]["friction_bias"]
    gradient = np.zeros(SIZE)
    hessian = np.zeros((SIZE, SIZE))
    coulomb_speed = smoothing_speed(z[A], p[V, V], measurement.dt)
    expected = force(z, measurement.reference, coulomb_speed, gradient, hessian)
    linearize_near_peak(z, np.sqrt(p[V, V]), gradient, hessian)
    trace, spread = second_order_terms(hessian, p)
    cross_noise = measurement_cross_noise(z, measurement.reference, measurement.deflection_variance)
    friction_error = friction_error_variance(z, p, excitation[0]["time_since_motion"], measurement.dt)
    noise = measurement.variance + friction_error + 0.5 * max(spread, 0.0)
    innovation = measurement.force - expected - 0.5 * trace
    ph = p @ gradient
    variance = gradient @ ph + noise + cross_noise
    nis = innovation * innovation / variance
    monitor[0]["innovation"] = innovation
    monitor[0]["variance"] = variance
    monitor[0]["nis"] = nis
    if nis > HARD_GATE:
        return False
    variance = inflate_innovation(nis, variance, FORCE_INFLATION)
    gain = ph / variance
    partial_update_mask(z, p, stroke(excitation), gain)
    force_update_mask(z, p, measurement.variance, ph, variance, gain)
    bias -= gain * (gradient @ bias - friction_model_std(z[V], z[D0], coulomb_speed))
    apply_correction(z, p, ph, gain, innovation, variance - cross_noise)
    apply_bounds(z)
    return True


@compiled
def process_force(
    state: Record, excitation: Record, monitor: Record, reference: float, force: float, variance: float,
    deflection_variance: float, dt: float,
) -> int:  # fmt: skip
    """Update by a force [N], dt [s] after the one before: STATIONARY (no update), REJECTED or ACCEPTED."""
    z, p = state[0]["mean"], state[0]["covariance"]
    accumulate_time_since_motion(excitation, z, p, dt)
    if is_stationary(excitation):
        return STATIONARY
    add_parameter_process_noise(p, dt)
    accumulate_excitation(excitation, z, p, reference, dt)
    speed, predicted_var = z[V], kinematic_force_variance(z, p, reference)
    cross_noise = measurement_cross_noise(z, reference, deflection_variance)
    measurement = ForceMeasurement(force, variance, deflection_variance, reference, dt)
    accepted = update_force(state, excitation, monitor, measurement)
    result = monitor[0]
    if result["nis"] < SOFT_GATE:
        observed_var = result["innovation"] * result["innovation"] - result["variance"] + cross_noise + predicted_var
        accumulate_matching(excitation, speed, predicted_var, observed_var, dt)
    return ACCEPTED if accepted else REJECTED
