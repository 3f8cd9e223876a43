# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimates between two filter steps: prediction to a sample's stamp, validity, status."""

from enum import IntFlag

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array, Integers, Status
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.records import PREDICTION, Record
from vsa_estimator.force_law.elastic import ln_stiffness_gradient
from vsa_estimator.force_law.state import D1, K2, M
from vsa_estimator.output.estimate import ROW
from vsa_estimator.output.general import predict_general
from vsa_estimator.preprocessing.pipeline import preprocess
from vsa_estimator.preprocessing.validation import ACCEPT
from vsa_estimator.tuning.output import (
    MAX_DAMPING_STD,
    MAX_PREDICTION_TIME,
    MAX_SEPARATION_STD,
    MAX_SPEED_SHARE,
    MAX_STIFFNESS_STD,
    MIN_DAMPING_SCALE,
    POSITION_GATE,
)

FAST_PATH = 3  # beside the outcomes of `validate`: accepted, nothing else to do, estimate written


class Condition(IntFlag):
    """State of the sensors at a prediction."""

    SENSORS_ALIVE = 1  # silent for less than INVALID_TIME
    ENCODER_FAULT = 2
    STALE = 4


ALIVE, ENCODER_FAULT, STALE = (int(one) for one in Condition)
_CONVERGING, _VALID, _DEGRADED, _STALE, _INADEQUATE = (
    int(one) for one in (Status.CONVERGING, Status.VALID, Status.DEGRADED, Status.STALE, Status.MODEL_INADEQUATE)
)

Predicted = tuple[
    bool, float, float, bool, float, float, bool, float, float, bool, float, float, bool, float, float, bool,
    float, float, bool, float, float, float, int,
]  # fmt: skip


Outcome = tuple[int, int, int, int]  # of a sample: outcome, SensorFlag bits, instant [ns], count of finished blocks


@compiled
def inflate_position(snapshot: Record, error: float, variance: float) -> None:
    """Update the position inflation by a deflection that differs by `error` [m] from a prediction of this variance.

    Two successive outliers leave the position uncertain by the second error.
    """
    square = error * error
    outlier = square > POSITION_GATE * (variance + snapshot[0]["published"]["deflection_noise_variance"])
    snapshot[0]["position_inflation"] = square if outlier and snapshot[0]["previous_outlier"] else 0.0
    snapshot[0]["previous_outlier"] = outlier


@compiled
def predict_into(
    row: Record, state: Record, snapshot: Record, stamp_ns: int, instant_ns: int, deflection: float, condition: int
) -> None:
    """Write the fields force_valid to status of `row`, (1,) ROW, for an instant [ns] of the filter's clock.

    `state`: (1,) FILTER_STATE; `snapshot`: (1,) SNAPSHOT, whose position inflation a `deflection` [m] updates unless
    it is NaN; `condition`: bits of Condition.
    """
    now = snapshot[0]["published"]
    prediction = np.empty(1, PREDICTION)
    ahead = min(max((instant_ns - now["step_ns"]) * 1e-9, 0.0), MAX_PREDICTION_TIME)
    if now["general"]:
        predict_general(now["impedance"], ahead, now["jerk_density"], prediction)
        prediction[0]["inertia"] = state[0]["mean"][M]
        prediction[0]["inertia_variance"] = state[0]["uncertainty"]["inertia_variance"]
    else:
        predict_output(state, now["reference"], ahead, now["jerk_density"], prediction)
        prediction[0]["ln_stiffness_variance"] += now["stiffness_discrepancy"]
        prediction[0]["damping_variance"] += now["damping_discrepancy"]
    predicted = prediction[0]
    position_variance, ln_variance = predicted["deflection_variance"], predicted["ln_stiffness_variance"]
    if not np.isnan(deflection):
        inflate_position(snapshot, deflection - predicted["deflection"], position_variance)
    inflation = snapshot[0]["position_inflation"]
    if inflation > 0.0:
        position_variance += inflation
        growth = now["impedance"]["slope"] if now["general"] else state[0]["mean"][K2]
        by_x = ln_stiffness_gradient(growth, 0.0)[0]
        ln_variance += by_x * by_x * inflation
    write_motion(row, prediction, position_variance, condition & ALIVE > 0)
    write_impedance(row, prediction, ln_variance)
    write_validity(row, state, snapshot, stamp_ns, condition, ln_variance, predicted["peak_speed"])


@compiled
def write_validity(
    row: Record, state: Record, snapshot: Record, stamp_ns: int, condition: int, ln_variance: float, peak_speed: float
) -> None:
    """Write validity of force, stiffness, damping and inertia, and the status, into a (1,) ROW with its values."""
    now, out = snapshot[0]["published"], row[0]
    d1, d1_variance = state[0]["mean"][D1], state[0]["covariance"][D1, D1]
    if now["general"]:
        d1 = abs(now["impedance"]["rest_damping"])
    alive, initialized = condition & ALIVE > 0, now["initialized"] or now["general"]
    degraded = now["suspended"] or stamp_ns < now["fault_until_ns"]
    usable = alive and not (now["suspended"] or condition & ENCODER_FAULT > 0)
    separated = initialized or d1_variance < (MAX_SEPARATION_STD * d1) ** 2
    stiffness_valid = usable and separated and ln_variance < MAX_STIFFNESS_STD * MAX_STIFFNESS_STD
    tolerance = MAX_DAMPING_STD * max(abs(out["damping"]), MIN_DAMPING_SCALE * d1)
    damping_valid = usable and initialized and out["damping_variance"] < tolerance * tolerance
    out["force_valid"] = usable and stamp_ns >= now["sensor_fault_until_ns"]
    out["stiffness_valid"] = stiffness_valid
    out["damping_valid"] = damping_valid and abs(out["velocity"]) < MAX_SPEED_SHARE * peak_speed
    out["inertia_valid"] = usable and now["inertia_observable"]
    if condition & STALE:
        out["status"] = _STALE
    elif degraded and initialized:
        out["status"] = _DEGRADED
    elif now["model_inadequate"]:
        out["status"] = _INADEQUATE
    else:
        out["status"] = _VALID if stiffness_valid else _CONVERGING


@compiled
def write_impedance(row: Record, prediction: Record, ln_variance: float) -> None:
    """Write stiffness, damping and inertia with variances and covariances of a (1,) PREDICTION into a (1,) ROW."""
    out, predicted = row[0], prediction[0]
    stiffness = predicted["stiffness"]
    out["stiffness"], out["stiffness_variance"] = stiffness, stiffness * stiffness * ln_variance
    out["damping"], out["damping_variance"] = predicted["damping"], predicted["damping_variance"]
    out["inertia"], out["inertia_variance"] = predicted["inertia"], predicted["inertia_variance"]
    out["stiffness_damping_covariance"] = predicted["stiffness_damping_covariance"]
    out["stiffness_inertia_covariance"] = predicted["stiffness_inertia_covariance"]
    out["damping_inertia_covariance"] = predicted["damping_inertia_covariance"]


@compiled
def write_motion(row: Record, prediction: Record, position_variance: float, valid: bool) -> None:
    """Write the motion of a (1,) PREDICTION into a (1,) ROW."""
    out, predicted = row[0], prediction[0]
    out["deflection"], out["deflection_variance"] = predicted["deflection"], position_variance
    out["velocity"], out["velocity_variance"] = predicted["velocity"], predicted["velocity_variance"]
    out["acceleration"], out["acceleration_variance"] = predicted["acceleration"], predicted["acceleration_variance"]
    out["deflection_valid"] = out["velocity_valid"] = out["acceleration_valid"] = valid


@compiled
def as_tuple(row: Record) -> Predicted:
    """Fields force_valid to status of a (1,) ROW as Python types."""
    r = row[0]
    return (
        r["force_valid"] > 0.0, float(r["deflection"]), float(r["deflection_variance"]), r["deflection_valid"] > 0.0,
        float(r["velocity"]), float(r["velocity_variance"]), r["velocity_valid"] > 0.0,
        float(r["acceleration"]), float(r["acceleration_variance"]), r["acceleration_valid"] > 0.0,
        float(r["stiffness"]), float(r["stiffness_variance"]), r["stiffness_valid"] > 0.0,
        float(r["damping"]), float(r["damping_variance"]), r["damping_valid"] > 0.0,
        float(r["inertia"]), float(r["inertia_variance"]), r["inertia_valid"] > 0.0,
        float(r["stiffness_damping_covariance"]), float(r["stiffness_inertia_covariance"]),
        float(r["damping_inertia_covariance"]), int(r["status"]),
    )  # fmt: skip


@compiled
def predict(
    state: Record, snapshot: Record, stamp_ns: int, instant_ns: int, deflection: float, condition: int
) -> Predicted:
    """`predict_into` as a tuple."""
    row = np.empty(1, ROW)
    predict_into(row, state, snapshot, stamp_ns, instant_ns, deflection, condition)
    return as_tuple(row)


@compiled
def process_into(
    row: Record, pipeline: Record, state: Record, snapshot: Record, stamp_ns: int, force: float, deflection: float
) -> Outcome:
    """`preprocess` a sample; if only a prediction is due, write it into `row`: outcome FAST_PATH."""
    outcome, flags, instant_ns, finished = preprocess(pipeline, stamp_ns, force, deflection)
    if outcome == ACCEPT and not flags and not finished and snapshot[0]["published"]["is_current"]:
        outcome = FAST_PATH
        predict_into(row, state, snapshot, stamp_ns, instant_ns, deflection, ALIVE)
    return outcome, flags, instant_ns, finished


@compiled
def process_sample(
    pipeline: Record, state: Record, snapshot: Record, stamp_ns: int, force: float, deflection: float
) -> tuple[Outcome, Predicted]:
    """`process_into`; the prediction is meaningful with FAST_PATH only."""
    row = np.zeros(1, ROW)
    outcome = process_into(row, pipeline, state, snapshot, stamp_ns, force, deflection)
    return outcome, as_tuple(row)


@compiled
def process_samples(
    rows: Record,
    pipeline: Record,
    state: Record,
    snapshot: Record,
    stamps_ns: Integers,
    force: Array,
    deflection: Array,
) -> tuple[int, Outcome]:
    """`process_into` the samples up to one without FAST_PATH: its index and outcome.

    The constant fields are written into the rows, too.
    """
    for i in range(rows.size):
        row = rows[i : i + 1]
        outcome = process_into(row, pipeline, state, snapshot, stamps_ns[i], force[i], deflection[i])
        if outcome[0] != FAST_PATH:
            return i, outcome
        write_constants(row, snapshot)
    return rows.size, (FAST_PATH, 0, 0, 0)


@compiled
def write_constants(row: Record, snapshot: Record) -> None:
    """Write the fields that are constant between two steps into a (1,) ROW."""
    out, constants = row[0], snapshot[0]["published"]
    out["reset_count"], out["reset_reason"] = constants["reset_count"], constants["reset_reason"]
    out["k2"], out["k2_variance"] = constants["k2"], constants["k2_variance"]
    out["d2"], out["d2_variance"] = constants["d2"], constants["d2_variance"]
    out["force_offset"], out["coulomb_friction"] = constants["force_offset"], constants["coulomb_friction"]
