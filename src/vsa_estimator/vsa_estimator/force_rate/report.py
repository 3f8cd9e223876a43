# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimate and state of the formulation `force_rate`, from a snapshot of its filters."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from vsa_common.types import Array, ResetReason, Status
from vsa_estimator.force_law.state import C
from vsa_estimator.force_rate.ekf import SIZE, R
from vsa_estimator.modes import Mode
from vsa_estimator.output.elastic_law import exponential_law
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.tuning.output import (
    INVALID_TIME,
    MAX_D2_STD,
    MAX_DAMPING_STD,
    MAX_FORCE_OFFSET_STD,
    MAX_FRICTION_STD,
    MAX_INERTIA_STD,
    MAX_K2_STD,
    MAX_STIFFNESS_STD,
    MIN_DAMPING_SCALE,
    STALE_TIME,
)

NO_SAMPLE = "no sample yet"
NOT_CONVERGED = "stiffness: not yet known within 10 %; move slowly over several millimetres"


@dataclass(frozen=True)
class Snapshot:
    """What estimate and state are computed from, SI."""

    stamp_ns: int  # of the last sample
    force: float  # the last one [N]
    force_variance: float  # [N^2]
    state: Array  # (10,): order of `R`
    covariance: Array  # (10, 10)
    reference: float  # deflection at which the stiffness is given [m]
    offset: float  # F0 [N]
    friction: float  # d0 [N]
    offset_covariance: Array  # (2, 2): of F0 and d0 [N^2]
    explained: bool  # the model explains force rate and force
    friction_dominant: bool  # Coulomb friction degrades damping and inertia
    reason: str  # why the estimate is degraded, "" if it is not
    reset_count: int
    reset_reason: ResetReason


def estimate_at(snapshot: Snapshot, stamp_ns: int) -> Estimate:
    """Estimate at `stamp_ns`, at or after the last sample."""
    z, p = snapshot.state, snapshot.covariance
    silence = (stamp_ns - snapshot.stamp_ns) * 1e-9
    recent = silence <= INVALID_TIME
    stiffness_valid, damping_valid, inertia_valid = _impedance_validity(snapshot, recent)
    return Estimate(
        stamp_ns=stamp_ns,
        force=snapshot.force,
        force_variance=snapshot.force_variance,
        force_valid=recent,
        **_field("deflection", z, p, R.X, recent),
        **_field("velocity", z, p, R.V, recent),
        **_field("acceleration", z, p, R.A, recent),
        **_field("stiffness", z, p, R.SIGMA, stiffness_valid),
        **_field("damping", z, p, R.D, damping_valid),
        **_field("inertia", z, p, R.M, inertia_valid),
        stiffness_damping_covariance=float(p[R.SIGMA, R.D]),
        stiffness_inertia_covariance=float(p[R.SIGMA, R.M]),
        damping_inertia_covariance=float(p[R.D, R.M]),
        status=_status(snapshot, silence, stiffness_valid),
        reset_count=snapshot.reset_count,
        reset_reason=snapshot.reset_reason,
        k2=float(z[R.K2]),
        k2_variance=float(p[R.K2, R.K2]),
        d2=float(z[R.D2]),
        d2_variance=float(p[R.D2, R.D2]),
        force_offset=snapshot.offset,
        coulomb_friction=snapshot.friction,
    )


def state_of(snapshot: Snapshot, estimate: Estimate | None, diagnostics: Mapping[str, Any]) -> State:
    """State with the last `estimate`, None before the first sample; `diagnostics` are the fields that it passes on."""
    z, p = snapshot.state, snapshot.covariance
    values, covariance = _coefficients(snapshot)
    variances = np.diag(covariance)
    stiffness_valid = estimate is not None and estimate.stiffness_valid
    names = ("ln_stiffness_reference", "k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
    relative = (MAX_K2_STD, MAX_DAMPING_STD, MAX_D2_STD, MAX_INERTIA_STD)
    valid = [
        stiffness_valid,
        *(math.sqrt(v) < share * abs(x) for x, v, share in zip(values[1:5], variances[1:5], relative, strict=True)),
        math.sqrt(variances[C.F0]) < MAX_FORCE_OFFSET_STD,
        math.sqrt(variances[C.D0]) < MAX_FRICTION_STD,
    ]
    fields: dict[str, Any] = {}
    for name, value, variance, is_valid in zip(names, values, variances, valid, strict=True):
        fields |= {name: value, f"{name}_variance": variance, f"{name}_valid": is_valid}
    for name, index in (("deflection", R.X), ("velocity", R.V), ("acceleration", R.A)):
        fields |= {name: z[index], f"{name}_variance": p[index, index], f"{name}_valid": estimate is not None}
    observed = {"stiffness": stiffness_valid, **dict(zip(names[1:5], valid[1:5], strict=True))}
    reason = NO_SAMPLE if estimate is None else snapshot.reason
    return State(
        stamp_ns=snapshot.stamp_ns,
        status=Status.INITIALIZING if estimate is None else estimate.status,
        mode=Mode.WAITING if estimate is None else Mode.TRACKING,  # no others
        reason=reason or ("" if stiffness_valid else NOT_CONVERGED),
        reset_count=snapshot.reset_count,
        reset_reason=snapshot.reset_reason,
        sensor_fault=False,  # this formulation has no checks of the sensors
        deflection_reference=snapshot.reference,
        **exponential_law(snapshot.reference, (*values[:2], values[C.F0]), covariance[:2, :2]).fields(stiffness_valid),
        coefficient_covariance=tuple(covariance.ravel().tolist()),
        observability=tuple(f"{name}: not known from this motion" for name, known in observed.items() if not known),
        **fields,
        **diagnostics,
    )


def _field(name: str, z: Array, p: Array, index: R, valid: bool) -> dict[str, Any]:
    """Value, variance and validity of one quantity, by field name."""
    return {name: float(z[index]), f"{name}_variance": float(p[index, index]), f"{name}_valid": valid}


def _impedance_validity(snapshot: Snapshot, recent: bool) -> tuple[bool, bool, bool]:
    """Validity of stiffness, damping and inertia."""
    z = snapshot.state
    sigma, damping, mass = z[[R.SIGMA, R.D, R.M]]
    std = np.sqrt(np.maximum(np.diag(snapshot.covariance), 0.0))
    undisturbed = recent and snapshot.explained and not snapshot.friction_dominant
    min_damping = MIN_DAMPING_SCALE * (damping - 3.0 * z[R.D2] * z[R.V] ** 2)
    return (
        bool(recent and snapshot.explained and std[R.SIGMA] < MAX_STIFFNESS_STD * sigma),
        bool(undisturbed and std[R.D] < MAX_DAMPING_STD * max(abs(damping), min_damping) and damping > min_damping),
        bool(undisturbed and std[R.M] < MAX_INERTIA_STD * mass),
    )


def _status(snapshot: Snapshot, silence: float, stiffness_valid: bool) -> Status:
    if silence > STALE_TIME:
        return Status.STALE
    if not stiffness_valid:
        return Status.CONVERGING
    return Status.DEGRADED if snapshot.reason else Status.VALID


def _coefficients(snapshot: Snapshot) -> tuple[Array, Array]:
    """[ln sigma at the reference, k2, d1, d2, M, F0, d0] (7,) with covariance (7, 7), SI."""
    z, p = snapshot.state, snapshot.covariance
    back = snapshot.reference - z[R.X]
    ln_sigma = math.log(max(z[R.SIGMA], 1e-9)) + z[R.K2] * back
    d1 = z[R.D] - 3.0 * z[R.D2] * z[R.V] ** 2
    values = np.array([ln_sigma, z[R.K2], d1, z[R.D2], z[R.M], snapshot.offset, snapshot.friction])
    g = np.zeros((5, SIZE))
    g[0, [R.X, R.SIGMA, R.K2]] = -z[R.K2], 1.0 / max(z[R.SIGMA], 1e-9), back
    g[1, R.K2] = g[3, R.D2] = g[4, R.M] = 1.0
    g[2, [R.V, R.D, R.D2]] = -6.0 * z[R.D2] * z[R.V], 1.0, -3.0 * z[R.V] ** 2
    covariance = np.zeros((7, 7))
    covariance[:5, :5] = g @ p @ g.T
    covariance[5:, 5:] = snapshot.offset_covariance
    return values, covariance
