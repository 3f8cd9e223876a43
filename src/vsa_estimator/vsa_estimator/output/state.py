# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Construction of the State of the estimator from its parts."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from vsa_common.types import ResetReason, Status
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import Z
from vsa_estimator.modes import Mode
from vsa_estimator.output.elastic_law import exponential_law
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.output.validity import UNOBSERVABLE, assess_observability, describe_unobservable

_MOTION = {"deflection": Z.X, "velocity": Z.V, "acceleration": Z.A}
_COEFFICIENTS = {
    "ln_stiffness_reference": ("stiffness", Z.S), "k2": ("k2", Z.K2), "d1": ("d1", Z.D1), "d2": ("d2", Z.D2),
    "inertia": ("inertia", Z.M), "force_offset": ("force_offset", Z.F0),
    "coulomb_friction": ("coulomb_friction", Z.D0),
}  # fmt: skip


@dataclass(frozen=True)
class Diagnostics:
    """Mode, counters, noise in use and active faults, as in EstimatorState."""

    stamp_ns: int
    mode: Mode
    faults: tuple[str, ...]
    reset_count: int
    reset_reason: ResetReason
    sensor_fault: bool
    force_noise_std: float
    deflection_noise_std: float
    jerk_density: float
    samples_fused: int
    samples_dropped: int
    force_rejected: int
    deflection_rejected: int
    force_repeated: int


def state_of(tracker: Tracker, estimate: Estimate | None, diagnostics: Diagnostics) -> State:
    """State after the last step of the filter; `estimate` is the last one, None before the first sample."""
    observable = assess_observability(tracker, diagnostics.force_noise_std) if estimate else UNOBSERVABLE
    stiffness_valid, damping_valid = (estimate.stiffness_valid, estimate.damping_valid) if estimate else (False, False)
    lines = describe_unobservable(tracker, observable, stiffness_valid, damping_valid)
    reason = "; ".join(diagnostics.faults) or ("" if stiffness_valid else lines[0])
    covariance = tracker.covariance
    variance = np.diag(covariance).tolist()
    variance[Z.K2], variance[Z.D2] = tracker.uncertainty.k2_variance, tracker.uncertainty.d2_variance
    variance[Z.M] = tracker.uncertainty.inertia_variance
    law = exponential_law(
        tracker.reference,
        (tracker.z[Z.S], tracker.z[Z.K2], tracker.z[Z.F0]),
        covariance[Z.S : Z.K2 + 1, Z.S : Z.K2 + 1],
    )
    values: dict[str, Any] = {}
    for name, index in _MOTION.items():
        values |= _quantity(name, tracker.z[index], variance[index], estimate is not None and estimate.velocity_valid)
    for name, (flag, index) in _COEFFICIENTS.items():
        values |= _quantity(name, tracker.z[index], variance[index], getattr(observable, flag))
    force, deflection = tracker.force_monitor[0], tracker.deflection_monitor[0]
    counters = {name: value for name, value in vars(diagnostics).items() if name != "faults"}
    return State(
        **values, **counters,
        status=estimate.status if estimate else Status.INITIALIZING,
        reason=reason if estimate else "no sample yet",
        deflection_reference=tracker.reference,
        **law.fields(stiffness_valid),
        coefficient_covariance=tuple(covariance[3:, 3:].ravel().tolist()),
        observability=lines,
        force_innovation=float(force["innovation"]), force_innovation_variance=float(force["variance"]),
        deflection_innovation=float(deflection["innovation"]),
        deflection_innovation_variance=float(deflection["variance"]),
        normalised_innovation_squared=float(force["nis"]),
    )  # fmt: skip


def _quantity(name: str, value: float, variance: float, valid: bool) -> dict[str, Any]:
    return {name: float(value), f"{name}_variance": variance, f"{name}_valid": valid}
