# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Newest measurements and estimates of a run, and why they do not permit a motion."""

import math
from dataclasses import dataclass, field
from typing import Protocol

from vsa_common.types import Status
from vsa_joint.excitation.model import CoefficientState
from vsa_joint.excitation.quantities import QuantityState
from vsa_joint.excitation.tuning import INVALID_TIMEOUT_NS

Pair = tuple[float, float]  # transmission_1, transmission_2; motor_1, motor_2

UNUSABLE = (Status.INITIALIZING, Status.STALE, Status.FAULT)


class EstimatorState(CoefficientState, QuantityState, Protocol):
    """Fields that an excitation reads of EstimatorState or of the estimator's own state."""

    samples_fused: int
    reason: str


class Impedance(Protocol):
    """Fields that `measure` reads of TransmissionImpedance."""

    force: float
    force_valid: bool
    deflection: float
    deflection_valid: bool
    status: int


@dataclass(frozen=True)
class Measurement:
    """Force [N] and deflection [m] of one transmission, the estimator's status, instants on a steady clock [ns]."""

    force: float
    deflection: float
    status: int
    usable_ns: int  # when the estimator was last neither STALE nor in FAULT, and the numbers finite
    valid_ns: int  # when force and deflection were last valid


def measure(impedance: Impedance, before: Measurement | None, now_ns: int) -> Measurement:
    """Measurement from a TransmissionImpedance that arrived at `now_ns`; `before` is the one before it."""
    finite = math.isfinite(impedance.force) and math.isfinite(impedance.deflection)
    usable = finite and impedance.status not in UNUSABLE
    valid = impedance.force_valid and impedance.deflection_valid
    return Measurement(
        impedance.force,
        impedance.deflection,
        impedance.status,
        usable_ns=now_ns if usable or before is None else before.usable_ns,
        valid_ns=now_ns if valid or before is None else before.valid_ns,
    )


@dataclass
class Inputs:
    """The newest of each input; None before the first. `angle` [rad] is None where the rig does not measure it."""

    measurements: list[Measurement | None] = field(default_factory=lambda: [None, None])
    states: list[EstimatorState | None] = field(default_factory=lambda: [None, None])
    states_ns: list[int] = field(default_factory=lambda: [0, 0])
    sample_rates: list[float] = field(default_factory=lambda: [0.0, 0.0])  # of the sensors [Hz]; 0: not known yet
    motors: Pair | None = None  # rad
    motors_ns: int = 0
    angle: float | None = None
    angle_ns: int = 0

    @property
    def forces(self) -> Pair:
        """Measured forces [N]; NaN before the first measurement."""
        first, second = (math.nan if one is None else one.force for one in self.measurements)
        return first, second

    @property
    def deflections(self) -> Pair:
        """Measured deflections [m]; NaN before the first measurement."""
        first, second = (math.nan if one is None else one.deflection for one in self.measurements)
        return first, second

    def fault(self, now_ns: int, timeout_ns: int) -> str:
        """Reason why a motion is not possible, empty for none; an input without update for `timeout_ns` is silent."""
        for number, (measurement, state) in enumerate(zip(self.measurements, self.states, strict=True), 1):
            if fault := _measurement_fault(measurement, now_ns, timeout_ns):
                reason = f" ({state.reason})" if state is not None and state.reason else ""
                return f"transmission_{number}: {fault}{reason}"
        if self.motors is None or now_ns - self.motors_ns > timeout_ns:
            return "motor_states silent"
        if self.angle is not None and now_ns - self.angle_ns > timeout_ns:
            return "joint_states silent"
        for number, (state, arrival) in enumerate(zip(self.states, self.states_ns, strict=True), 1):
            if state is None or now_ns - arrival > timeout_ns:
                return f"transmission_{number}/estimator_state silent"
        return "" if all(self.sample_rates) else "rate of the samples not known yet"


def _measurement_fault(measurement: Measurement | None, now_ns: int, timeout_ns: int) -> str:
    if measurement is None:
        return "impedance silent"
    if now_ns - measurement.usable_ns > timeout_ns:
        status = Status(measurement.status)
        return f"estimator {status.name}" if status in UNUSABLE else "impedance silent"
    return "force or deflection invalid" if now_ns - measurement.valid_ns > INVALID_TIMEOUT_NS else ""
