# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of the bank of laws, predicted from its last step."""

import math

from vsa_common.accel import compiled
from vsa_estimator.filter.records import Record
from vsa_estimator.tuning.force_law import UNBOUNDED_SPEED
from vsa_estimator.tuning.output import MAX_BEYOND_PEAK


@compiled
def predict_general(impedance: Record, ahead: float, jerk_density: float, prediction: Record) -> None:
    """Motion, stiffness and damping, `ahead` [s] of `impedance`, an IMPEDANCE record, into (1,) PREDICTION.

    Stiffness and damping follow their local slopes; their covariances are not known. The inertia stays as it is.
    """
    now, out, t, q = impedance, prediction[0], ahead, jerk_density
    z, p, half = now["motion"], now["motion_covariance"], 0.5 * t * t
    out["deflection"] = z[0] + t * z[1] + half * z[2]
    growing = 2.0 * (t * p[0, 1] + half * p[0, 2]) + t * t * (p[1, 1] + t * p[1, 2]) + half * half * p[2, 2]
    growing = max(growing + q * t**5 / 20.0, 0.0)
    out["deflection_variance"] = p[0, 0] + growing
    out["velocity"], out["acceleration"] = z[1] + t * z[2], z[2]
    faster = max(2.0 * t * p[1, 2] + t * t * p[2, 2] + q * t**3 / 3.0, 0.0)
    out["velocity_variance"], out["acceleration_variance"] = p[1, 1] + faster, p[2, 2] + q * t
    slope, by_speed = now["slope"], now["damping_slope"]
    out["stiffness"] = math.exp(now["ln_stiffness"] + slope * (out["deflection"] - z[0]))
    out["ln_stiffness_variance"] = now["ln_stiffness_variance"] + slope * slope * growing
    out["damping"] = now["damping"] + by_speed * (out["velocity"] - z[1])
    out["damping_variance"] = now["damping_variance"] + by_speed * by_speed * faster
    out["stiffness_damping_covariance"] = 0.0
    out["stiffness_inertia_covariance"] = out["damping_inertia_covariance"] = 0.0
    out["peak_speed"] = 0.0 if now["beyond_peak"] > MAX_BEYOND_PEAK else UNBOUNDED_SPEED
