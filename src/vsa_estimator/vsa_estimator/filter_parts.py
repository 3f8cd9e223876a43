# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parts of the filter of one transmission, and what resets and suspends them."""

import math

from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.consistency import (
    AFTER_FAULT,
    AFTER_GAP,
    INCONSISTENT,
    ConsistencyMonitor,
    Decision,
)
from vsa_estimator.fault_detection.held_law import HeldLaw
from vsa_estimator.fault_detection.isolation import NO_SHIFT, SensorShift
from vsa_estimator.fault_detection.latch import Counters, FaultLatch
from vsa_estimator.fault_detection.position import PositionMonitor
from vsa_estimator.fault_detection.residual import DECISION_WINDOW, Coefficients
from vsa_estimator.filter.adaptation import NoiseAdaptation
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.general.models import peak_speed_of
from vsa_estimator.initialization.hand_over import HandOver
from vsa_estimator.initialization.previous_run import start_from
from vsa_estimator.law_choice import LawChoice
from vsa_estimator.modes import Event, ModeMachine
from vsa_estimator.output.adequacy import Adequacy
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.preprocessing.pipeline import Pipeline
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.fault_detection import WINDOWS
from vsa_estimator.tuning.supervisor import COUNTED_GAP, MOTION_HOLD_TIME

POSITION_UNCERTAIN = "consistency check: motion of the rod or encoder step"


class FilterParts:
    """State of all parts of the filter, with resets of the position, of the coefficients and of all."""

    def __init__(self, config: EstimatorConfig, pipeline: Pipeline, latch: FaultLatch) -> None:
        """`pipeline` has the sample period and the noise ratios of the sensors; encoder steps are raised in `latch`."""
        self._config, self._pipeline, self._latch = config, pipeline, latch
        self.counters = Counters()
        self.reset()

    def reset(self) -> None:
        """Drop all state but the counters."""
        rate = self._config.filter_rate
        self.noise = NoiseAdaptation(self._config)
        self.tracker = Tracker(self._config.initial, rate)
        self.hand_over = HandOver(self._config.initial, rate)
        self.laws = LawChoice(self._config)
        speed = peak_speed(self._config.initial.d1, self._config.initial.d2)
        self.consistency = ConsistencyMonitor(rate, speed, self._coefficients)
        self.bank_consistency = ConsistencyMonitor(rate, speed, self.laws.held)
        self.adequacy = Adequacy(self._config.initial.k2, peak_speed_of(self._config.initial))
        self.modes = ModeMachine()
        self.encoder_fault = False  # of the last sample
        self._rejected = False  # whether the last deflection was
        self.inertia_observable = False  # at the last step
        self.step_ns = 0  # instant of the last step
        self._position = PositionMonitor()
        self._samples_per_step = 1
        self._force = 0.0  # the newest one [N]
        self._epoch_ns = self._moved_ns = self._refreshed_ns = self._assessed_ns = 0

    def _coefficients(self) -> Coefficients:
        """Copies of the filter's coefficients."""
        tracker = self.tracker
        return Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference)

    @property
    def conditions(self) -> tuple[bool, bool, bool, bool]:
        """Whether updates are suspended, filter initialized, model inadequate, inertia observable."""
        modes = self.modes
        return modes.suspended, modes.initialized, self.adequacy.is_inadequate, self.inertia_observable

    @property
    def _monitor(self) -> ConsistencyMonitor:
        """Parity check of the law of the present mode."""
        return self.bank_consistency if self.modes.general else self.consistency

    @property
    def _bank_decides(self) -> bool:
        """Whether the evidence was against the filter's law at the bank's checkpoint: a later fault is none.

        A law that explains slow faults decides on a fast one only.
        """
        law = self.bank_consistency.checkpoint
        if not (isinstance(law, HeldLaw) and law.laws.prefers_another_law and self.bank_consistency.is_established):
            return False
        return self.consistency.is_fast or not law.explains_slow_faults

    def _assess_adequacy(self) -> None:
        """Add the parity residuals of the published law to its adequacy, each decision window once."""
        if self.modes.suspended or self.step_ns - self._assessed_ns < WINDOWS[DECISION_WINDOW] * 1e9:
            return
        self._assessed_ns = self.step_ns
        by_bank = self.laws.publishes_bank or not self.modes.initialized
        fit = (self.bank_consistency if by_bank else self.consistency).fit
        if fit is not None:
            (mean, std, hidden, in_motion), (_, residual, _, _, (deflection, velocity, _), _) = fit
            self.adequacy.add((abs(mean) - hidden, std, in_motion), residual, deflection, velocity)

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Apply the noise levels of another configuration; state and mode stay."""
        self._config = config
        self.noise.reconfigure(config)

    def start(self, instant_ns: int, force: float, deflection: float, previous: Coefficients | None) -> None:
        """Begin with the first sample ([ns], [N], [m]) and the coefficients of a previous run."""
        self.modes.handle(Event.FIRST_SAMPLE)
        self.tracker.start(deflection, force, self.noise.deflection.std**2)
        self._position.restart(instant_ns)
        self._epoch_ns = self.step_ns = self._refreshed_ns = instant_ns
        self._moved_ns = instant_ns - int(MOTION_HOLD_TIME * 1e9)
        if previous is not None:
            start_from(previous, self.tracker, self.modes, self.consistency)
            self.laws.confirm()

    def _apply(self, decision: Decision) -> None:
        """Carry out a decision: coefficients first, then mode and counters."""
        if isinstance(decision.restore, HeldLaw):
            self.laws.hold_at(decision.restore.laws)
        elif decision.restore is not None:
            self.tracker.restore(*decision.restore)
        if decision.reset is not ResetReason.NONE:
            self.counters.count_reset(decision.reset)
        if decision.fault:
            self._latch.raise_fault(decision.fault, self.step_ns)
        if decision.event is Event.REJECTED:
            self._restart_initialization(self._force)
        elif decision.event is not None:
            self.modes.handle(decision.event, decision.reason)
        if self.modes.suspended:
            self.laws.hold(self.modes.general)
        if decision.shift is NO_SHIFT or self.modes.general:
            return
        self.hand_over.clear()  # its data are of before the shift
        if self.laws.is_held:
            self.laws.shift(decision.shift)
        else:  # the bank has data of the shift from before it was isolated
            self.laws.restart()

    def _suspend(self, reason: str, interrupted: bool = False) -> bool:
        """Suspend updates; False where no checkpoint is established."""
        decision = self._monitor.suspend(self.modes, interrupted)
        if decision is None:
            return False
        self._apply(decision._replace(reason=reason))
        return True

    def _restart_initialization(self, force: float) -> None:
        """Drop the coefficients, and begin with the start values at the present `force` [N]."""
        self.modes.handle(Event.REJECTED)
        self.consistency.reset()
        self.bank_consistency.reset()
        self.adequacy.restart()
        self.hand_over.restart()
        self.tracker.reset_coefficients(force)
        self.laws.reject()

    def _restart_after_gap(self, block: Decimated, silence: float, deflection_variance: float) -> None:
        """Reset the motion, keep the coefficients."""
        self.tracker.reset_position(block.deflection, deflection_variance)
        self._interrupt(block, deflection_variance)
        self._suspend(AFTER_GAP, interrupted=True)
        if silence > COUNTED_GAP:
            self.counters.count_reset(ResetReason.GAP)

    def _reset_position(self, block: Decimated, deflection_variance: float) -> None:
        """Take over the encoder's position: an encoder step, or a motion that the gate has rejected."""
        tracker, step = self.tracker, self._position.step_size
        text, stepped, suspended = f"encoder step of {1e3 * step:+.2f} mm", True, False
        if self.modes.initialized:
            stepped = not self.encoder_fault and self._position.encoder_step(tracker)
            if self.modes.reason in (INCONSISTENT, AFTER_FAULT):
                stepped = False  # it may end the fault: the checkpoint is compared unshifted
            elif stepped:
                std = math.sqrt(self._position.step_variance + deflection_variance)
                suspended = self._shift_encoder(SensorShift(0.0, step, std), text)
            else:
                self._suspend(POSITION_UNCERTAIN, interrupted=True)
        else:
            tracker.set_reference(block.deflection)
            tracker.reset_coefficients(self._force)
            self.hand_over.restart()
            self.laws.restart()
        tracker.reset_position(block.deflection, deflection_variance)
        self.hand_over.clear()
        self._interrupt(block, deflection_variance)
        self.counters.count_reset(ResetReason.DEFLECTION)
        if stepped and not suspended:
            self._latch.raise_fault(text, block.stamp_ns)

    def _shift_encoder(self, shift: SensorShift, reason: str) -> bool:
        """The encoder reads this much more; whether updates are suspended until sensors and law are consistent."""
        law = self._monitor.shift(shift)
        if isinstance(law, HeldLaw):
            self.laws.hold_at(law.laws)
        else:
            self.tracker.restore(*law)
        suspended = self._suspend(reason)
        if not self.modes.general:
            self.laws.shift(shift)
            self.bank_consistency.reset()
        return suspended

    def _interrupt(self, block: Decimated, deflection_variance: float) -> None:
        """End what must not reach across a gap."""
        self._position.restart(block.stamp_ns)
        self.consistency.interrupt()
        self.bank_consistency.interrupt()
        self.laws.interrupt()
        self.noise.restart(block.deflection, deflection_variance)
