# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Consistency of the coefficients with both sensors: when to suspend updates, what to restore, when to give up.

While updates are suspended the coefficients are those of the last checkpoint, and stiffness is invalid until the
parity residuals are small again. An inconsistency that lasts is explained by a shift of one sensor, or the coefficients
are rejected.
"""

import math
from typing import NamedTuple

from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.isolation import NO_SHIFT, SensorShift
from vsa_estimator.fault_detection.parity_check import ParityCheck
from vsa_estimator.fault_detection.residual import Coefficients
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import C
from vsa_estimator.modes import Event, ModeMachine
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.tuning.fault_detection import (
    CHECKPOINT_PERIOD,
    EVALUATION_PERIOD,
    FAULT_TIMEOUT,
    ISOLATION_TIME,
    MIN_TRACKING_TIME,
)
from vsa_estimator.tuning.output import MAX_STIFFNESS_STD

INCONSISTENT = "force and encoder are inconsistent with the estimated model: sensor drift or a changed transmission"
REJECTED = "coefficients rejected: force and encoder stay inconsistent with them"
AFTER_GAP = "consistency check after a gap"
AFTER_FAULT = "consistency check after a burst of samples or an encoder fault"


class Decision(NamedTuple):
    """What a filter step makes of the operating mode and of the coefficients."""

    event: Event | None = None
    restore: Coefficients | None = None  # to be set before the event
    shift: SensorShift = NO_SHIFT  # of a sensor, which the restored coefficients contain
    reset: ResetReason = ResetReason.NONE
    fault: str = ""  # the isolated one
    reason: str = INCONSISTENT  # why updates are suspended, if they are


NOMINAL = Decision()


class ConsistencyMonitor:
    """Parity check over time, with checkpoints of the coefficients."""

    def __init__(self, rate: float, peak_speed: float) -> None:
        """`rate` of the filter [Hz]; initial v* [m/s]."""
        self._parity = ParityCheck(rate, peak_speed)
        self._checkpoint_time = -math.inf  # [s]
        self._time_in_fault = 0.0  # [s]
        self._has_moved = False  # in this fault
        self._tracking_time = 0.0  # of consistent tracking [s]
        self._is_previous_run = False  # whether no sample has confirmed the coefficients of a previous run

    def reset(self) -> None:
        """Drop the checkpoints: the coefficients are new."""
        self._tracking_time = 0.0
        self._parity.reset()

    def begin(self, tracker: Tracker) -> None:
        """Make the present coefficients, those of a previous run, the checkpoint.

        If they are inconsistent, they are given up: the transmission may be another one, and a shift of one sensor
        can explain that for some seconds.
        """
        self._is_previous_run = True
        self._time_in_fault = 0.0
        self._parity.replace(_present(tracker))

    def renew(self, tracker: Tracker) -> None:
        """Make the present coefficients, less certain by a cross-check, the checkpoint."""
        self._parity.replace(_present(tracker))

    def interrupt(self) -> None:
        """Drop the recent steps: the motion has a gap."""
        self._parity.interrupt()

    @property
    def is_consistent(self) -> bool:
        """Whether the sensors agree with a sensitive checkpoint: a large NIS is then the lag of the filter."""
        parity = self._parity
        sensitive = parity.checkpoint is not None and not parity.is_uncertain and not parity.is_insensitive
        return sensitive and parity.is_consistent

    def suspend(self, tracker: Tracker, modes: ModeMachine, interrupted: bool = False) -> Decision | None:
        """Decision to suspend updates and to restore the checkpoint; None if no checkpoint is established.

        After an `interrupted` motion a checkpoint need not be established: the present coefficients become it.
        """
        checkpoint = self._parity.checkpoint
        established = self._tracking_time >= MIN_TRACKING_TIME
        if not modes.initialized or checkpoint is None or not (established or interrupted):
            return None
        if modes.suspended:
            return Decision(Event.INCONSISTENT)
        self._time_in_fault, self._has_moved = 0.0, False
        self._parity.begin_fault()
        if established:
            return Decision(Event.INCONSISTENT, checkpoint)
        self._parity.replace(_present(tracker))
        return Decision(Event.INCONSISTENT)

    def shift_reference(self, tracker: Tracker, shift: float, variance: float) -> Coefficients:
        """Coefficients for an encoder that reads `shift` [m] more; its variance [m^2] widens the stiffness."""
        checkpoint = self._parity.checkpoint or _present(tracker)
        widened = _widened(checkpoint, float(checkpoint.mean[C.K2]) ** 2 * variance)
        return self._replace(widened._replace(reference=checkpoint.reference + shift))

    def evaluate(
        self,
        tracker: Tracker,
        modes: ModeMachine,
        step: Decimated,
        deflection_variance: float,
        conditions: tuple[bool, bool],
    ) -> Decision:
        """Decision after a filter step, whose mean deflection has this variance [m^2].

        `conditions`: whether the encoder is faulty, and whether the deflection before was rejected.
        """
        encoder_fault, after_rejection = conditions
        time, force = step.stamp_ns * 1e-9, step.force if step.forces else math.nan
        evaluated = self._parity.add((time, step.deflection, force), deflection_variance, after_rejection)
        if not modes.initialized:
            return NOMINAL
        if self._parity.checkpoint is None:
            self._keep(tracker, time)
        if encoder_fault:
            decision = self.suspend(tracker, modes)
            self._time_in_fault = 0.0
            return decision._replace(reason=AFTER_FAULT) if decision else NOMINAL
        if not evaluated:
            return NOMINAL
        return self._suspended(tracker) if modes.suspended else self._nominal(tracker, modes, time)

    def _nominal(self, tracker: Tracker, modes: ModeMachine, time: float) -> Decision:
        if self._parity.is_uncertain or self._parity.extrapolates:
            if self._parity.is_consistent:
                self._parity.extend_travel()
            self._parity.replace(_present(tracker))
        elif self._parity.exceeds_threshold and not self._parity.is_insensitive:
            decision = self.suspend(tracker, modes)
            if decision is not None:
                return decision
            self._tracking_time = 0.0
            self._parity.replace(_present(tracker))
        elif not self._parity.no_evidence:
            self._tracking_time += 0.0 if self._parity.is_insensitive else EVALUATION_PERIOD
            self._parity.accept()
            if time - self._checkpoint_time > CHECKPOINT_PERIOD:
                self._keep(tracker, time)
        return NOMINAL

    def _suspended(self, tracker: Tracker) -> Decision:
        self._parity.measure_fault()
        if self._parity.is_consistent and self._parity.fault_would_show(of_encoder=False):
            decision = self._consistent(tracker)
            if decision is not None:
                return decision
        if not self._parity.is_inconsistent:
            return NOMINAL
        self._time_in_fault += EVALUATION_PERIOD
        self._has_moved |= self._parity.moves
        if self._is_previous_run and self._time_in_fault > ISOLATION_TIME:
            self._is_previous_run = False
            return Decision(Event.REJECTED, reset=ResetReason.INNOVATION)
        shift = self._parity.isolate_fault() if self._time_in_fault > ISOLATION_TIME else None
        if shift is not None:
            return self._shifted(tracker, shift)
        if self._time_in_fault > FAULT_TIMEOUT and self._has_moved:
            return Decision(Event.REJECTED, reset=ResetReason.INNOVATION, fault=REJECTED)
        return NOMINAL

    def _consistent(self, tracker: Tracker) -> Decision | None:
        """Decision to continue; None while what can be hidden of the fault would make the stiffness invalid.

        A shift of the encoder where the spring is too soft for it to show, and another law where it has the same force,
        count with their size as a standard deviation of the stiffness.
        """
        checkpoint, restore = self._parity.checkpoint or _present(tracker), None
        shift = 0.0 if self._parity.fault_would_show() else float(checkpoint.mean[C.K2]) * self._parity.fault_size[1]
        hidden = math.hypot(shift, self._parity.hidden_change())
        if hidden > MAX_STIFFNESS_STD:
            return None
        if hidden > 0.0:
            restore = self._replace(_widened(checkpoint, hidden**2))
        self._parity.end_fault()
        self._is_previous_run = False
        return Decision(Event.CONSISTENT, restore)

    def _shifted(self, tracker: Tracker, shift: SensorShift) -> Decision:
        """Decision on an isolated shift: it is compensated."""
        if shift.deflection:
            restore = self.shift_reference(tracker, shift.deflection, shift.std**2)
            fault = f"encoder offset of {1e3 * shift.deflection:+.2f} mm"
            return Decision(restore=restore, shift=shift, reset=ResetReason.DEFLECTION, fault=fault)
        restore = self._shift_force_offset(tracker, shift.force, shift.std**2)
        fault = f"force offset of {shift.force:+.2f} N"
        return Decision(restore=restore, shift=shift, reset=ResetReason.INNOVATION, fault=fault)

    def _shift_force_offset(self, tracker: Tracker, shift: float, variance: float) -> Coefficients:
        checkpoint = self._parity.checkpoint or _present(tracker)
        mean, covariance = checkpoint.mean.copy(), checkpoint.covariance.copy()
        mean[C.F0] += shift
        covariance[C.F0, C.F0] += variance
        return self._replace(checkpoint._replace(mean=mean, covariance=covariance))

    def _replace(self, coefficients: Coefficients) -> Coefficients:
        """Make these the checkpoint, and return them."""
        self._time_in_fault = 0.0
        self._parity.replace(coefficients)
        return coefficients

    def _keep(self, tracker: Tracker, time: float) -> None:
        self._checkpoint_time = time
        self._parity.keep(_present(tracker))


def _present(tracker: Tracker) -> Coefficients:
    """Copies of the present coefficients."""
    return Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference)


def _widened(coefficients: Coefficients, ln_stiffness_variance: float) -> Coefficients:
    """Coefficients with a greater variance of ln stiffness."""
    covariance = coefficients.covariance.copy()
    covariance[C.S, C.S] += ln_stiffness_variance
    return coefficients._replace(covariance=covariance)
