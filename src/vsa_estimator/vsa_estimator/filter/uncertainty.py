# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Uncertainty of the coefficients beyond the covariance, from what the recent motion excites."""

from typing import NamedTuple

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.filter.excitation import consistency_ratio
from vsa_estimator.filter.records import Record
from vsa_estimator.force_law.elastic import compliance_at_reference
from vsa_estimator.force_law.state import D1, D2, K2, A, M, S, V
from vsa_estimator.tuning.filter import (
    BEYOND_PEAK_SHARE,
    MASS_STIFFNESS_AMBIGUITY,
    MIN_POSITION_SHARE,
    MIN_VELOCITY_SHARE,
    PEAK_SPEED_ERROR,
)


class CoefficientUncertainty(NamedTuple):
    """Coefficients with their uncertainty beyond the covariance, SI."""

    k2: float
    k2_variance: float  # with the mass-stiffness ambiguity
    d2: float
    d2_variance: float  # with the bias by the velocity error
    force_offset: float
    coulomb_friction: float
    inertia_variance: float  # with the bias by the acceleration error
    inertial_force: float  # root mean square [N]


@compiled
def single_tone_fit(excitation: Record) -> tuple[float, float]:
    """Least squares of a = -w^2 x over the recent motion: w^2 [1/s^2] and the part of a^2 that it explains [m^2/s^4].

    A motion of one tone has a in proportion to x: mass and stiffness are then ambiguous.
    """
    e = excitation[0]
    x_variance, covariance = 0.0, 0.0
    if e["weight"] > 0.0:
        mean = e["mean_x"] / e["weight"]
        x_variance = e["mean_xx"] / e["weight"] - mean * mean
        covariance = e["mean_xa"] / e["weight"] - mean * e["mean_a"] / e["weight"]
    square_frequency = max(0.0, -covariance / x_variance) if x_variance > 1e-12 else 0.0
    return square_frequency, -covariance * square_frequency


@compiled
def assess_uncertainty(state: Record, excitation: Record, force_variance: float, inertia_std: float) -> None:
    """Update the record `uncertainty` of `state`, (1,) FILTER_STATE.

    Errors in variables: an error of the speed in phase with it biases d2, one of the acceleration biases M. A motion
    of one tone leaves mass and stiffness ambiguous. `force_variance` [N^2] is the noise of the last force,
    `inertia_std` [kg] the initial standard deviation of the mass.
    """
    z, p, e, out = state[0]["mean"], state[0]["covariance"], excitation[0], state[0]["uncertainty"]
    square_frequency, explained = single_tone_fit(excitation)
    independent = e["acceleration_square"] - explained
    acceleration_square = max(e["acceleration_square"], explained)  # the difference of a^2 and its noise is biased low
    k2, d2, mass = z[K2], z[D2], z[M]
    velocity_error_bias = min(3.0 * p[V, V] / max(e["velocity_square"], 1e-12), 1.0)
    acceleration_error_bias = min(p[A, A] / max(independent, 1e-12), 1.0)
    beyond_peak = min(1.0, e["beyond_peak_share"] / BEYOND_PEAK_SHARE)
    peak_speed_error = PEAK_SPEED_ERROR * beyond_peak
    inertia_variance = p[M, M] + mass * mass * acceleration_error_bias
    inertia_observable = inertia_variance * acceleration_square > force_variance
    ambiguous = inertia_variance * (1.0 if inertia_observable else max(0.0, 1.0 - p[M, M] / inertia_std**2))
    k2_ambiguity = MASS_STIFFNESS_AMBIGUITY * k2 * square_frequency * compliance_at_reference(z[S])
    share = 1.0 if inertia_observable else max(consistency_ratio(excitation), beyond_peak)
    out["k2_variance"] = p[K2, K2] + k2_ambiguity * k2_ambiguity * ambiguous
    out["d2_variance"] = p[D2, D2] + (d2 * velocity_error_bias) ** 2 + (2.0 * peak_speed_error * d2) ** 2
    out["inertia_variance"] = inertia_variance
    out["inertial_force"] = mass * np.sqrt(acceleration_square)
    out["stiffness_std"] = MASS_STIFFNESS_AMBIGUITY * square_frequency * np.sqrt(ambiguous)
    out["d1_std"] = peak_speed_error * z[D1]
    out["d2_std"] = d2 * velocity_error_bias
    out["position_scale"] = np.sqrt(MIN_POSITION_SHARE + (1.0 - MIN_POSITION_SHARE) * share)
    out["velocity_scale"] = np.sqrt(max(share, MIN_VELOCITY_SHARE))


def coefficient_uncertainty(state: Record) -> CoefficientUncertainty:
    """Coefficients and the record `uncertainty` of `state`, (1,) FILTER_STATE, by name."""
    k2_variance, d2_variance, inertia_variance, inertial_force, *_ = state["uncertainty"][0].tolist()
    _, k2, _, d2, _, force_offset, coulomb_friction = state["mean"][0, 3:].tolist()
    return CoefficientUncertainty(
        k2, k2_variance, d2, d2_variance, force_offset, coulomb_friction, inertia_variance, inertial_force
    )
