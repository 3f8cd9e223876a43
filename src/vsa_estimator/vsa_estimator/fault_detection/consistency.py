# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Consistency of the coefficients with both sensors: when to suspend updates, what to restore, when to give up.

While updates are suspended the coefficients are those of the last checkpoint, and stiffness is invalid until the
parity residuals are small again. An inconsistency that lasts is explained by a shift of one sensor, or the coefficients
are rejected.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from vsa_common.types import Array, ResetReason
from vsa_estimator.fault_detection.held_law import Law
from vsa_estimator.fault_detection.isolation import NO_SHIFT, Residuals, SensorShift
from vsa_estimator.fault_detection.parity_check import ParityCheck
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
    restore: Law | None = None  # to be set before the event
    shift: SensorShift = NO_SHIFT  # of a sensor, which the restored coefficients contain
    reset: ResetReason = ResetReason.NONE
    fault: str = ""  # the isolated one
    reason: str = INCONSISTENT  # why updates are suspended, if they are


NOMINAL = Decision()
Conditions = tuple[bool, bool]  # whether the encoder is faulty, and whether the deflection before was rejected


class ConsistencyMonitor:
    """Parity check over time, with checkpoints of the coefficients."""

    def __init__(self, rate: float, peak_speed: float, present: Callable[[], Law]) -> None:
        """`rate` of the filter [Hz]; initial v* [m/s]; the `present` law, which checkpoints are copies of."""
        self._present = present
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

    def begin(self) -> None:
        """Make the present coefficients, those of a previous run, the checkpoint.

        If they are inconsistent, they are given up: the transmission may be another one, and a shift of one sensor
        can explain that for some seconds.
        """
        self._is_previous_run = True
        self._time_in_fault = 0.0
        self._parity.replace(self._present())

    def renew(self) -> None:
        """Make the present law the checkpoint: what is known has changed, as by a cross-check or a repetition."""
        self._parity.replace(self._present())

    def interrupt(self) -> None:
        """Drop the recent steps: the motion has a gap."""
        self._parity.interrupt()

    @property
    def is_consistent(self) -> bool:
        """Whether the sensors agree with a sensitive checkpoint: a large NIS is then the lag of the filter."""
        parity = self._parity
        sensitive = parity.checkpoint is not None and not parity.is_uncertain and not parity.is_insensitive
        return sensitive and parity.is_consistent

    @property
    def fit(self) -> tuple[Array, Residuals] | None:
        """`ParityCheck.fit`; None without evidence."""
        return None if self._parity.checkpoint is None or self._parity.no_evidence else self._parity.fit

    @property
    def is_fast(self) -> bool:
        """Whether the inconsistency shows in the shortest window alone: it is none of a slow fault."""
        return self._parity.exceeded == [0]

    @property
    def checkpoint(self) -> Law | None:
        """Law that the sensors are compared with."""
        return self._parity.checkpoint

    @property
    def is_established(self) -> bool:
        """Whether the checkpoint outweighs the present sensors."""
        return self._tracking_time >= MIN_TRACKING_TIME

    def suspend(self, modes: ModeMachine, interrupted: bool = False) -> Decision | None:
        """Decision to suspend updates and to restore the checkpoint; None if no checkpoint is established.

        After an `interrupted` motion a checkpoint need not be established: the present coefficients become it.
        """
        checkpoint = self._parity.checkpoint
        if checkpoint is None or not (self.is_established or interrupted):
            return None
        if modes.suspended:
            return Decision(Event.INCONSISTENT)
        self._time_in_fault, self._has_moved = 0.0, False
        self._parity.begin_fault()
        if self.is_established:
            return Decision(Event.INCONSISTENT, checkpoint)
        self._parity.replace(self._present())
        return Decision(Event.INCONSISTENT)

    def shift(self, shift: SensorShift) -> Law:
        """The law for sensors that read this much more; it is the checkpoint."""
        return self._replace((self._parity.checkpoint or self._present()).shifted(shift))

    def evaluate(
        self, modes: ModeMachine, known: bool, step: Decimated, deflection_variance: float, conditions: Conditions
    ) -> Decision:
        """Decision after a filter step, whose mean deflection has this variance [m^2], on a law that is `known`."""
        encoder_fault, after_rejection = conditions
        time, force = step.stamp_ns * 1e-9, step.force if step.forces else math.nan
        evaluated = self._parity.add((time, step.deflection, force), deflection_variance, after_rejection)
        if not known:
            return NOMINAL
        if self._parity.checkpoint is None:
            self._keep(time)
        if encoder_fault:
            decision = self.suspend(modes)
            self._time_in_fault = 0.0
            return decision._replace(reason=AFTER_FAULT) if decision else NOMINAL
        if not evaluated:
            return NOMINAL
        return self._suspended() if modes.suspended else self._nominal(modes, time)

    def _nominal(self, modes: ModeMachine, time: float) -> Decision:
        if self._parity.is_uncertain or self._parity.extrapolates:
            if self._parity.is_consistent:
                self._parity.extend_travel()
            self._parity.replace(self._present())
        elif self._parity.exceeded and not self._parity.is_insensitive:
            if self._parity.choose_law():
                return NOMINAL
            decision = self.suspend(modes)
            if decision is not None:
                return decision
            self._tracking_time = 0.0
            self._parity.replace(self._present())
        elif not self._parity.no_evidence:
            self._tracking_time += 0.0 if self._parity.is_insensitive else EVALUATION_PERIOD
            self._parity.accept()
            if time - self._checkpoint_time > CHECKPOINT_PERIOD:
                self._keep(time)
        return NOMINAL

    def _suspended(self) -> Decision:
        self._parity.measure_fault()
        if self._parity.is_consistent and self._parity.fault_would_show(of_encoder=False):
            decision = self._consistent()
            if decision is not None:
                return decision
        if self._parity.has_expired:
            self._parity.end_fault()
            return Decision(Event.CONSISTENT)
        if not self._parity.is_inconsistent:
            return NOMINAL
        self._time_in_fault += EVALUATION_PERIOD
        self._has_moved |= self._parity.moves
        if self._is_previous_run and self._time_in_fault > ISOLATION_TIME:
            self._is_previous_run = False
            return Decision(Event.REJECTED, reset=ResetReason.INNOVATION)
        shift = self._parity.isolate_fault() if self._time_in_fault > ISOLATION_TIME else None
        if shift is not None:
            return self._shifted(shift)
        if self._time_in_fault > FAULT_TIMEOUT and self._has_moved:
            return Decision(Event.REJECTED, reset=ResetReason.INNOVATION, fault=REJECTED)
        return NOMINAL

    def _consistent(self) -> Decision | None:
        """Decision to continue; None while what can be hidden of the fault would make the stiffness invalid.

        A shift of the encoder where the spring is too soft for it to show, and another law where it has the same force,
        count with their size as a standard deviation of the stiffness.
        """
        checkpoint, restore = self._parity.checkpoint or self._present(), None
        shift = 0.0 if self._parity.fault_would_show() else self._parity.growth * self._parity.fault_size[1]
        hidden = math.hypot(shift, self._parity.hidden_change())
        if hidden > MAX_STIFFNESS_STD:
            return None
        if hidden > 0.0:
            restore = self._replace(checkpoint.widened(hidden**2))
        self._parity.end_fault()
        self._is_previous_run = False
        return Decision(Event.CONSISTENT, restore)

    def _shifted(self, shift: SensorShift) -> Decision:
        """Decision on an isolated shift: it is compensated."""
        if shift.deflection:
            fault, reset = f"encoder offset of {1e3 * shift.deflection:+.2f} mm", ResetReason.DEFLECTION
        else:
            fault, reset = f"force offset of {shift.force:+.2f} N", ResetReason.INNOVATION
        return Decision(restore=self.shift(shift), shift=shift, reset=reset, fault=fault)

    def _replace(self, law: Law) -> Law:
        """Make this the checkpoint, and return it."""
        self._time_in_fault = 0.0
        self._parity.replace(law)
        return law

    def _keep(self, time: float) -> None:
        self._checkpoint_time = time
        self._parity.keep(self._present())
