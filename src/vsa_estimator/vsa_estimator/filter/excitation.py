# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""What the recent motion excites: travel, leaky moments, time since motion, innovation covariance matching.

`excitation` is (1,) EXCITATION.
"""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.records import Record
from vsa_estimator.force_law.damper import force_slope, peak_speed
from vsa_estimator.force_law.elastic import stiffness
from vsa_estimator.force_law.state import D1, D2, K2, A, S, V, X
from vsa_estimator.tuning.filter import (
    EXCITATION_TIME_CONSTANT,
    MATCHING_TIME_CONSTANT,
    MIN_MATCHING_SPEED,
    PEAK_FRACTION,
    STATIONARY_SPEED,
    STATIONARY_TIME,
)


@compiled
def stroke(excitation: Record) -> float:
    """Travel of the recent motion [m]."""
    return float(excitation[0]["position_max"] - excitation[0]["position_min"])


@compiled
def accumulate_time_since_motion(excitation: Record, z: Array, p: Array, dt: float) -> None:
    """Add `dt` [s] to the time without a significant speed, or reset it."""
    moves = abs(z[V]) > STATIONARY_SPEED + 3.0 * np.sqrt(p[V, V])
    excitation[0]["time_since_motion"] = 0.0 if moves else excitation[0]["time_since_motion"] + dt


@compiled
def is_stationary(excitation: Record) -> bool:
    """Whether the transmission is at rest: stiction then holds any force, which updates no coefficient."""
    return bool(excitation[0]["time_since_motion"] > STATIONARY_TIME)


@compiled
def accumulate_excitation(excitation: Record, z: Array, p: Array, reference: float, dt: float) -> None:
    """Add `dt` [s] of motion at state z with covariance p."""
    e = excitation[0]
    leak = dt / EXCITATION_TIME_CONSTANT
    x, v, a = z[X], z[V], z[A]
    dx = x - reference
    e["position_max"] = max(x, e["position_max"] - leak * (e["position_max"] - x))
    e["position_min"] = min(x, e["position_min"] + leak * (x - e["position_min"]))
    e["velocity_square"] += leak * (v * v - p[V, V] - e["velocity_square"])
    e["acceleration_square"] += leak * (a * a - p[A, A] - e["acceleration_square"])
    beyond = 1.0 if near_peak_speed(z) else 0.0
    e["beyond_peak_share"] += leak * (beyond - e["beyond_peak_share"])
    e["weight"] += leak * (1.0 - e["weight"])
    e["mean_x"] += leak * (dx - e["mean_x"])
    e["mean_a"] += leak * (a - e["mean_a"])
    e["mean_xx"] += leak * (dx * dx - e["mean_xx"])
    e["mean_xa"] += leak * (dx * a - e["mean_xa"])


@compiled
def near_peak_speed(z: Array) -> bool:
    """Whether the speed is near or beyond v*."""
    return bool(abs(z[V]) > PEAK_FRACTION * peak_speed(z[D1], z[D2]))


@compiled
def kinematic_force_variance(z: Array, p: Array, reference: float) -> float:
    """Variance of the force by position and speed under the covariance p [N^2]."""
    sigma = stiffness(z[S], z[K2], z[X] - reference)
    slope = force_slope(z[D1], z[D2], z[V], peak_speed(z[D1], z[D2]))
    return float(sigma * sigma * p[X, X] + slope * (2.0 * sigma * p[X, V] + slope * p[V, V]))


@compiled
def accumulate_matching(excitation: Record, speed: float, predicted_var: float, observed_var: float, dt: float) -> None:
    """Add the variance of the force by position and speed, predicted and observed [N^2], of `dt` [s].

    At a low speed the error of the friction model dominates the innovation: no value is added.
    """
    if abs(speed) > MIN_MATCHING_SPEED:
        e = excitation[0]
        leak = dt / MATCHING_TIME_CONSTANT
        e["matching_weight"] += leak * (1.0 - e["matching_weight"])
        e["predicted_var"] += leak * (predicted_var - e["predicted_var"])
        e["observed_var"] += leak * (observed_var - e["observed_var"])


def reset_matching(excitation: Record) -> None:
    """Restart the matching for a motion of another jerk density."""
    for field in ("matching_weight", "predicted_var", "observed_var"):
        excitation[field] = 0.0


@compiled
def consistency_ratio(excitation: Record) -> float:
    """Observed over predicted variance of the force by position and speed, within 0 to 1 (Mehra, 1970).

    White jerk is rougher than most motions: the predicted variance is an upper bound.
    """
    e = excitation[0]
    if e["predicted_var"] <= 0.0:
        return 1.0
    ratio = 1.0 - e["matching_weight"] + e["matching_weight"] * e["observed_var"] / e["predicted_var"]
    return min(max(ratio, 0.0), 1.0)
