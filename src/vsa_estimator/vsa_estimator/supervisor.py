# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Filter steps of one transmission, with resets of the position, suspension of updates, and initialization."""

import math

from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.consistency import INCONSISTENT, NOMINAL, Conditions
from vsa_estimator.fault_detection.position import PositionUpdate, is_pause
from vsa_estimator.filter_parts import FilterParts
from vsa_estimator.initialization.hand_over import StepNoise
from vsa_estimator.modes import Event
from vsa_estimator.output.validity import inertia_observable
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.tuning.filter import STATIONARY_SPEED
from vsa_estimator.tuning.output import MAX_BEYOND_PEAK, MAX_PREDICTION_TIME
from vsa_estimator.tuning.supervisor import (
    INERTIA_NEGLIGIBLE,
    MANOEUVRE_RATIO,
    MOTION_HOLD_TIME,
    REFRESH_PERIOD,
)


class Supervisor(FilterParts):
    """The filter of one transmission, step by step."""

    def mark_timing_suspect(self, instant_ns: int) -> None:
        """Samples came in a burst at `instant_ns` [ns]: a clock may have stood still."""
        self._position.mark_timing_suspect(instant_ns)

    def set_encoder_fault(self, faulty: bool) -> None:
        """Set whether the encoder was faulty at the last sample."""
        self.encoder_fault = faulty

    def step(self, block: Decimated, force: float) -> None:
        """Make one filter step at a mean stamp; `force` [N] is the newest one, for a block that has none."""
        tracker = self.tracker
        self._force = block.force if block.forces else force
        dt = (block.stamp_ns - self.step_ns) * 1e-9
        deflection_variance = (self._pipeline.deflection_noise_ratio * self.noise.deflection.std) ** 2 / block.samples
        if 0.0 < dt <= MAX_PREDICTION_TIME:
            tracker.predict(dt, self.noise.jerk.density)
        if self._is_discontinuous(block, dt, deflection_variance):
            self._restart_after_gap(block, dt, deflection_variance)
        self.step_ns = block.stamp_ns
        conditions = self.encoder_fault, self._rejected
        self._rejected = not self._update_position(block, deflection_variance)
        if self._rejected:
            return
        self.noise.deflection.add(block.deflection, block.samples)
        self.noise.jerk.add(block.deflection, deflection_variance, min(dt, MAX_PREDICTION_TIME))
        if abs(tracker.speed) > STATIONARY_SPEED:
            self._moved_ns = block.stamp_ns
        self._step_laws(block, deflection_variance)
        self._pipeline.set_beyond_peak_speed(self._is_beyond_peak_speed)
        self._check_consistency(block, deflection_variance, conditions)
        self._assess_adequacy()
        if self.modes.general:
            self._step_general(block)
            return
        if self._detect_manoeuvre() or self.modes.suspended or not block.forces:
            self.noise.force.interrupt()
        else:
            self._update_force(block, dt, deflection_variance)
        if self._is_refresh_due(block):
            self._refresh(block)
        self._samples_per_step = block.samples
        tracker.update_uncertainty()
        self.laws.choose(tracker, self.modes, block.stamp_ns)
        self.inertia_observable = not self.laws.replaces_filter and inertia_observable(tracker, self.noise.force.std)

    def _step_laws(self, block: Decimated, deflection_variance: float) -> None:
        """Step the bank of laws; mode GENERAL where it refutes the exponential law, and back where it fails."""
        if self.encoder_fault:
            self.laws.interrupt()
        elif self.laws.step(block, (deflection_variance, self._force_variance(block)), self.modes):
            if self.modes.general:
                self._restart_initialization(self._force)
                self.counters.count_reset(ResetReason.INNOVATION)
            else:
                self._refute()

    def _check_consistency(self, block: Decimated, deflection_variance: float, conditions: Conditions) -> None:
        """Compare both sensors with the filter's coefficients and with the bank; decide by the law that holds.

        Where the bank decides, an inconsistency of the filter's coefficients alone is one of their law.
        """
        modes, by_bank = self.modes, NOMINAL
        if modes.general or (self.laws.is_rich and not modes.suspended):
            by_bank = self.bank_consistency.evaluate(modes, True, block, deflection_variance, conditions)
        else:
            self.bank_consistency.reset()
        if modes.general:
            self._apply(by_bank)
            return
        by_filter = self.consistency.evaluate(modes, modes.initialized, block, deflection_variance, conditions)
        of_filter = by_filter.event is Event.INCONSISTENT
        of_bank = by_bank.event is Event.INCONSISTENT and (of_filter or self.laws.replaces_filter)
        if self.encoder_fault or not (of_filter or of_bank):
            self._apply(by_filter)
        elif self._bank_decides:
            if of_bank:
                self._refute()
                self._apply(by_bank)
            else:
                self.consistency.renew()
        elif of_filter and self.laws.explains_inconsistency:
            self._refute()
        else:
            self._apply(by_filter)

    def _refute(self) -> None:
        """The bank of laws replaces the filter."""
        self.modes.handle(Event.REFUTED)
        self.laws.refute()
        self.hand_over.clear()

    def _step_general(self, block: Decimated) -> None:
        """Rest of a step in mode GENERAL: noise of the sensors; the filter follows the encoder alone."""
        if block.forces:
            self.noise.force.add(block.force, block.forces)
        self._detect_manoeuvre()
        if self._is_refresh_due(block):
            self.noise.refresh(False)
        self._samples_per_step = block.samples
        self.inertia_observable = False
        self.laws.choose(self.tracker, self.modes, block.stamp_ns)

    def _is_refresh_due(self, block: Decimated) -> bool:
        """Whether noise levels and start values are to be renewed; counted from there on."""
        if block.stamp_ns - self._refreshed_ns < REFRESH_PERIOD * 1e9 - 0.5 * self._pipeline.period_ns:
            return False
        self._refreshed_ns = block.stamp_ns
        return True

    def _force_variance(self, block: Decimated) -> float:
        """Variance of the mean force of a block [N^2]."""
        return (self._pipeline.force_noise_ratio * self.noise.force.std) ** 2 / max(block.forces, 1)

    def _detect_manoeuvre(self) -> bool:
        """Raise the jerk density at the onset of a manoeuvre; whether there is one."""
        before = self.noise.jerk.density
        manoeuvre = self.modes.initialized and self.noise.jerk.detect_manoeuvre(self.tracker.deflection_nis)
        if self.noise.jerk.density > MANOEUVRE_RATIO * before:
            self.tracker.reset_matching()
        return manoeuvre

    def _is_discontinuous(self, block: Decimated, dt: float, deflection_variance: float) -> bool:
        """Whether the motion has a gap before a block."""
        if dt > MAX_PREDICTION_TIME:
            return True
        if self.encoder_fault:
            self._position.mark_timing_suspect(block.stamp_ns)
            return False
        return self._position.is_discontinuous(self.tracker, block, deflection_variance, is_pause(dt, self._period))

    def _update_position(self, block: Decimated, deflection_variance: float) -> bool:
        """Update by the deflection; False where it is rejected."""
        update = self._position.update(
            self.tracker, self.noise.jerk, block, deflection_variance, self.modes.initialized
        )
        if update is PositionUpdate.ACCEPTED:
            return True
        self.counters.count_rejected(deflection=True)
        if update is PositionUpdate.RESET_DUE:
            self._reset_position(block, deflection_variance)
        return False

    @property
    def _is_beyond_peak_speed(self) -> bool:
        """Whether the rod is near or beyond v*: by the filter, the bank, and until the hand-over by the initial v*."""
        by_bank = bool(self.laws.impedance["beyond_peak"][0] > MAX_BEYOND_PEAK)
        if self.modes.general:
            return by_bank
        return self.tracker.beyond_peak_speed or (by_bank and not self.modes.initialized)

    @property
    def _period(self) -> float:
        """Time between two steps [s]."""
        return max(1.0 / self._config.filter_rate, self._pipeline.period_ns * 1e-9)

    def _update_force(self, block: Decimated, dt: float, deflection_variance: float) -> None:
        tracker = self.tracker
        self.noise.force.add(block.force, block.forces)
        if block.stamp_ns - self._moved_ns < MOTION_HOLD_TIME * 1e9:
            self.hand_over.add((block.stamp_ns - self._epoch_ns) * 1e-9, block.deflection, block.force)
        if not self.modes.initialized:
            return
        if not tracker.update_force(block.force, self._force_variance(block), deflection_variance, dt):
            self.counters.count_rejected(force=True)
        if self.consistency.is_consistent:
            tracker.reset_nis_test()
        elif not tracker.nis_test_failed:
            return
        elif self.laws.explains_inconsistency:
            self._refute()
        elif not self._suspend(INCONSISTENT):
            self._restart_initialization(block.force)
            self.counters.count_reset(ResetReason.INNOVATION)

    def _refresh(self, block: Decimated) -> None:
        """Renew noise levels and jerk density; begin a regression or a cross-check where it is due."""
        limit = INERTIA_NEGLIGIBLE * self.noise.force.std
        self.noise.refresh(self.modes.initialized and self.tracker.max_inertial_force < limit)
        if not self.hand_over.is_due(self.modes, block.stamp_ns):
            return
        if not self.modes.initialized and not self.hand_over.has_fit and block.forces:
            self.tracker.reset_coefficients(block.force)
        averaging = 1.0 / math.sqrt(block.samples)
        noise = StepNoise(
            self._regression_noise * averaging, self.noise.deflection.std * averaging, self.noise.jerk.ml_estimate
        )
        self.hand_over.begin(self.modes, self._period, self.tracker.reference, noise)

    def run_initialization(self) -> None:
        """Do the due part of a regression, and of a repetition of the bank of laws.

        The result of a regression initializes the filter, or replaces its coefficients.
        """
        if self.laws.repeat_slice() and self.laws.is_rich:
            self.bank_consistency.renew()
        if not self.hand_over.is_running:
            return
        period, force_std = self._pipeline.period_ns * 1e-9, self._regression_noise
        new = self.hand_over.advance(self.tracker, self.modes, self.step_ns, period, force_std, self._samples_per_step)
        if new is None:
            return
        self.tracker.set_coefficients(new.mean, new.covariance)
        if self.modes.initialized:
            self.consistency.renew()
        if new.event is Event.HAND_OVER:
            self.tracker.set_stroke(*new.stroke)
        if new.event is not None:
            self.modes.handle(new.event)

    @property
    def _regression_noise(self) -> float:
        """Noise of a force in a regression [N]; a cross-check must not take rough motion for it."""
        return self.noise.force.least_std if self.modes.initialized else self.noise.force.std

    @property
    def has_deferred_work(self) -> bool:
        """Whether a part of a regression or of a repetition of the bank of laws is due."""
        return self.hand_over.is_running or self.laws.is_slice_due
