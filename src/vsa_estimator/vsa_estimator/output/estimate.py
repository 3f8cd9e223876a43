# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Results of the estimator: fields as in vsa_msgs, SI, immutable."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import ResetReason, Status
from vsa_estimator.modes import Mode


class Estimate(NamedTuple):
    """Mechanical impedance at one sensor sample, eqs. (8) and (9); fields as in TransmissionImpedance.

    Every number is finite; one whose flag is false must not be used. The last six are the coefficients behind it.
    """

    stamp_ns: int
    force: float  # [N]
    force_variance: float
    force_valid: bool
    deflection: float  # [m]
    deflection_variance: float
    deflection_valid: bool
    velocity: float  # [m/s]
    velocity_variance: float
    velocity_valid: bool
    acceleration: float  # [m/s^2]
    acceleration_variance: float
    acceleration_valid: bool
    stiffness: float  # [N/m]; the interval is stiffness * exp(+- z std / stiffness)
    stiffness_variance: float
    stiffness_valid: bool
    damping: float  # [N s/m]
    damping_variance: float
    damping_valid: bool
    inertia: float  # [kg]
    inertia_variance: float
    inertia_valid: bool
    stiffness_damping_covariance: float
    stiffness_inertia_covariance: float
    damping_inertia_covariance: float
    status: Status
    reset_count: int
    reset_reason: ResetReason
    k2: float  # [1/m]
    k2_variance: float
    d2: float  # [N s^3/m^3]
    d2_variance: float
    force_offset: float  # [N]
    coulomb_friction: float  # [N]


# One record of the fields from force_valid on, for samples in arrays; flags, status and reset_reason as numbers.
ROW_FIELDS = Estimate._fields[Estimate._fields.index("force_valid") :]
ROW = np.dtype([(name, "f8") for name in ROW_FIELDS])


def empty_rows(count: int) -> NDArray[Any]:
    """(count,) ROW of NaN: samples without an estimate."""
    return np.full(count, np.nan, ROW)


def row_of(estimate: Estimate | None) -> tuple[float, ...] | float:
    """Values of ROW; NaN for None."""
    return math.nan if estimate is None else estimate[-len(ROW_FIELDS) :]


class State(NamedTuple):
    """State and diagnostics of the estimator, at a lower rate; fields as in EstimatorState."""

    stamp_ns: int
    status: Status
    mode: Mode
    reason: str
    reset_count: int
    reset_reason: ResetReason
    sensor_fault: bool
    deflection: float
    deflection_variance: float
    deflection_valid: bool
    velocity: float
    velocity_variance: float
    velocity_valid: bool
    acceleration: float
    acceleration_variance: float
    acceleration_valid: bool
    deflection_reference: float
    ln_stiffness_reference: float
    ln_stiffness_reference_variance: float
    ln_stiffness_reference_valid: bool
    k2: float
    k2_variance: float
    k2_valid: bool
    d1: float
    d1_variance: float
    d1_valid: bool
    d2: float
    d2_variance: float
    d2_valid: bool
    inertia: float
    inertia_variance: float
    inertia_valid: bool
    force_offset: float
    force_offset_variance: float
    force_offset_valid: bool
    coulomb_friction: float
    coulomb_friction_variance: float
    coulomb_friction_valid: bool
    coefficient_covariance: tuple[float, ...]
    observability: tuple[str, ...]
    force_innovation: float
    force_innovation_variance: float
    deflection_innovation: float
    deflection_innovation_variance: float
    normalised_innovation_squared: float
    force_noise_std: float
    deflection_noise_std: float
    jerk_density: float
    samples_fused: int
    samples_dropped: int
    force_rejected: int
    deflection_rejected: int
    force_repeated: int
    elastic_law: str
    elastic_law_valid: bool
    elastic_force: float
    elastic_deflection: tuple[float, ...]
    elastic_ln_stiffness: tuple[float, ...]
    elastic_ln_stiffness_covariance: tuple[float, ...]
