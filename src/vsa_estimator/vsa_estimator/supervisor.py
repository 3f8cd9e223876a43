"""Filter steps of one transmission, with resets of the position, suspension of updates, and initialization."""

import math

import numpy as np
from vsa_common.accel import ACCELERATED
from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.consistency import AFTER_GAP, INCONSISTENT, ConsistencyMonitor, Decision
from vsa_estimator.fault_detection.counters import Counters
from vsa_estimator.fault_detection.latch import FaultLatch
from vsa_estimator.fault_detection.position import PositionMonitor, PositionUpdate, is_pause
from vsa_estimator.filter.adaptation import NoiseAdaptation
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.records import PREDICTION
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.general.records import IMPEDANCE, Record
from vsa_estimator.general.selection import LawSelection
from vsa_estimator.initialization.hand_over import HandOver, StepNoise
from vsa_estimator.modes import Event, Mode, ModeMachine
from vsa_estimator.output.validity import inertia_observable
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.preprocessing.pipeline import Pipeline
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.filter import STATIONARY_SPEED
from vsa_estimator.tuning.output import MAX_PREDICTION_TIME
from vsa_estimator.tuning.supervisor import (
    COUNTED_GAP,
    INERTIA_NEGLIGIBLE,
    MANOEUVRE_RATIO,
    MOTION_HOLD_TIME,
    REFRESH_PERIOD,
)

NO_IMPEDANCE = np.zeros(1, IMPEDANCE)
POSITION_UNCERTAIN = "consistency check: motion of the rod or encoder step"


class Supervisor:
    """The filter of one transmission, step by step."""

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
        self.consistency = ConsistencyMonitor(rate)
        automatic = self._config.elastic_law == "automatic" and ACCELERATED  # plain Python is too slow for the bank
        self.laws = LawSelection(self._config.initial, rate) if automatic else None
        self.modes = ModeMachine()
        self.encoder_fault = False  # of the last sample
        self.inertia_observable = False  # at the last step
        self.publishes_bank = False  # whether the estimates are those of the bank
        self.step_ns = 0  # instant of the last step
        self._position = PositionMonitor()
        self._samples_per_step = 1
        self._force = 0.0  # the newest one [N]
        self._epoch_ns = self._moved_ns = self._refreshed_ns = 0

    def start(self, instant_ns: int, force: float, deflection: float) -> None:
        """Begin with the first sample ([ns], [N], [m])."""
        self.modes.handle(Event.FIRST_SAMPLE)
        self.tracker.start(deflection, force, self.noise.deflection.std**2)
        self._position.restart(instant_ns)
        self._epoch_ns = self.step_ns = self._refreshed_ns = instant_ns
        self._moved_ns = instant_ns - int(MOTION_HOLD_TIME * 1e9)

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
        if not self._update_position(block, deflection_variance):
            return
        self.noise.deflection.add(block.deflection, block.samples)
        self.noise.jerk.add(block.deflection, deflection_variance, min(dt, MAX_PREDICTION_TIME))
        if abs(tracker.speed) > STATIONARY_SPEED:
            self._moved_ns = block.stamp_ns
        self._step_laws(block, deflection_variance)
        if self.modes.general:
            self._step_general(block)
            return
        self._pipeline.set_beyond_peak_speed(self.modes.initialized and tracker.beyond_peak_speed)
        decision = self.consistency.evaluate(tracker, self.modes, block.stamp_ns * 1e-9, block, self.encoder_fault)
        self._apply(decision, INCONSISTENT)
        if self._detect_manoeuvre() or self.modes.suspended or not block.forces:
            self.noise.force.interrupt()
        else:
            self._update_force(block, dt, deflection_variance)
        if block.stamp_ns - self._refreshed_ns >= REFRESH_PERIOD * 1e9 - 0.5 * self._pipeline.period_ns:
            self._refreshed_ns = block.stamp_ns
            self._refresh(block)
        self._samples_per_step = block.samples
        tracker.update_uncertainty()
        self._choose()
        self.inertia_observable = inertia_observable(tracker, self.noise.force.std)

    def _step_laws(self, block: Decimated, deflection_variance: float) -> None:
        """Step the bank of laws; mode GENERAL where it refutes the exponential law."""
        if self.laws is None:
            return
        if self.encoder_fault:
            self.laws.interrupt()
            return
        deflection = block.deflection, deflection_variance
        force = block.force if block.forces else math.nan, self._force_variance(block)
        k2 = self.tracker.uncertainty.k2 if self.modes.mode is Mode.TRACKING else None
        self.laws.step(block.stamp_ns, deflection, force, k2)
        if self.modes.mode in (Mode.INITIALIZING, Mode.TRACKING) and self.laws.is_refuted:
            self.modes.handle(Event.REFUTED)
            self.hand_over.clear()
        elif self.modes.general and self.laws.has_failed:
            self._restart_initialization(self._force)
            self.counters.count_reset(ResetReason.INNOVATION)

    def _force_variance(self, block: Decimated) -> float:
        """Variance of the mean force of a block [N^2]."""
        return (self._pipeline.force_noise_ratio * self.noise.force.std) ** 2 / max(block.forces, 1)

    def _step_general(self, block: Decimated) -> None:
        """What a step does in mode GENERAL beside the bank: noise of the sensors; the filter follows the encoder alone."""
        if block.forces:
            self.noise.force.add(block.force, block.forces)
        self._detect_manoeuvre()
        if block.stamp_ns - self._refreshed_ns >= REFRESH_PERIOD * 1e9 - 0.5 * self._pipeline.period_ns:
            self._refreshed_ns = block.stamp_ns
            self.noise.refresh(False)
        self._samples_per_step = block.samples
        self.inertia_observable, self.publishes_bank = False, True

    def _apply(self, decision: Decision, reason: str) -> None:
        """Carry out a decision: coefficients first, then mode and counters."""
        if decision.restore is not None:
            self.tracker.restore(*decision.restore)
        if decision.reset is not ResetReason.NONE:
            self.counters.count_reset(decision.reset)
        if decision.event is Event.REJECTED:
            self._restart_initialization(self._force)
        elif decision.event is not None:
            self.modes.handle(decision.event, reason)

    def _suspend(self, reason: str, interrupted: bool = False) -> bool:
        """Suspend updates; False where no checkpoint is established."""
        decision = self.consistency.suspend(self.tracker, self.modes, interrupted)
        if decision is None:
            return False
        self._apply(decision, reason)
        return True

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
        exponential = self.modes.initialized and not self.modes.general
        update = self._position.update(self.tracker, self.noise.jerk, block, deflection_variance, exponential)
        if update is PositionUpdate.ACCEPTED:
            return True
        self.counters.count_rejected(deflection=True)
        if update is PositionUpdate.RESET_DUE:
            self._reset_position(block, deflection_variance)
        return False

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
        if not tracker.nis_test_failed:
            return
        if self.consistency.is_consistent:
            tracker.reset_nis_test()
        elif not self._suspend(INCONSISTENT):
            self._restart_initialization(block.force)
            self.counters.count_reset(ResetReason.INNOVATION)

    def _choose(self) -> None:
        """Choose what is published: the bank in mode GENERAL, and where it contradicts the filter."""
        self.publishes_bank = self.modes.general
        if self.laws is None or self.modes.general or self.modes.suspended:
            return
        prediction = np.empty(1, PREDICTION)
        predict_output(self.tracker.state, self.tracker.reference, 0.0, self.noise.jerk.density, prediction)
        self.publishes_bank = self.laws.is_preferred(prediction)

    @property
    def impedance(self) -> Record:
        """(1,) IMPEDANCE of the bank; zero without one."""
        return self.laws.impedance if self.laws is not None else NO_IMPEDANCE

    @property
    def published_coefficients(self) -> tuple[float, float, float, float, float, float]:
        """k2 and d2 with their variances, force offset and Coulomb friction; k2 of the bank is the local slope."""
        if self.publishes_bank:
            now = self.impedance[0]
            return float(now["slope"]), float(now["slope_variance"]), 0.0, 0.0, float(now["level"]), float(now["coulomb"])
        known = self.tracker.uncertainty
        return known.k2, known.k2_variance, known.d2, known.d2_variance, known.force_offset, known.coulomb_friction

    def _restart_initialization(self, force: float) -> None:
        """Drop the coefficients, and begin with the start values at the present `force` [N]."""
        self.modes.handle(Event.REJECTED)
        self.consistency.reset()
        self.hand_over.restart()
        self.tracker.reset_coefficients(force)
        if self.laws is not None and not self.laws.is_adequate:
            self.laws.restart()

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
            self.noise.force.std * averaging, self.noise.deflection.std * averaging, self.noise.jerk.ml_estimate
        )
        self.hand_over.begin(self.modes, self._period, self.tracker.reference, noise)

    def run_initialization(self) -> None:
        """Do the due part of a regression and of a repetition of the bank.

        The result of a regression initializes the filter, or replaces its coefficients.
        """
        if self.laws is not None:
            self.laws.bank.repeat_slice()
        if not self.hand_over.is_running:
            return
        period, force_std = self._pipeline.period_ns * 1e-9, self.noise.force.std
        new = self.hand_over.advance(self.tracker, self.modes, self.step_ns, period, force_std, self._samples_per_step)
        if new is None:
            return
        if new.event is Event.REPLACED:
            self.consistency.reset()
            self.counters.count_reset(ResetReason.INNOVATION)
        self.tracker.set_coefficients(new.mean, new.covariance)
        if new.event is Event.HAND_OVER:
            self.tracker.set_stroke(*new.stroke)
        if new.event is not None:
            self.modes.handle(new.event)

    @property
    def has_deferred_work(self) -> bool:
        """Whether a regression or a repetition of the bank is running."""
        return self.hand_over.is_running or (self.laws is not None and self.laws.bank.is_repeating)

    def _restart_after_gap(self, block: Decimated, silence: float, deflection_variance: float) -> None:
        """Reset the motion, keep the coefficients."""
        self.tracker.reset_position(block.deflection, deflection_variance)
        self._interrupt(block, deflection_variance)
        if not self.modes.general:
            self._suspend(AFTER_GAP, interrupted=True)
        if silence > COUNTED_GAP:
            self.counters.count_reset(ResetReason.GAP)

    def _reset_position(self, block: Decimated, deflection_variance: float) -> None:
        """Take over the encoder's position: an encoder step, or a motion that the gate has rejected."""
        tracker, step = self.tracker, self._position.step_size
        text, stepped, suspended = f"encoder step of {1e3 * step:+.2f} mm", True, False
        if self.modes.general:
            self._restart_initialization(self._force)
        if self.modes.initialized:
            stepped = not self.encoder_fault and self._position.encoder_step(tracker)
            if stepped:
                variance = self._position.step_variance + deflection_variance
                tracker.restore(*self.consistency.shift_reference(tracker, step, variance))
                suspended = self._suspend(text)
                if self.laws is not None:
                    self.laws.shift(step)
            else:
                self._suspend(POSITION_UNCERTAIN, interrupted=True)
        else:
            tracker.set_reference(block.deflection)
            tracker.reset_coefficients(self._force)
            self.hand_over.restart()
            if self.laws is not None:
                self.laws.restart()
        tracker.reset_position(block.deflection, deflection_variance)
        self.hand_over.clear()
        self._interrupt(block, deflection_variance)
        self.counters.count_reset(ResetReason.DEFLECTION)
        if stepped and not suspended:
            self._latch.raise_fault(text, block.stamp_ns)

    def _interrupt(self, block: Decimated, deflection_variance: float) -> None:
        """End what must not reach across a gap."""
        self._position.restart(block.stamp_ns)
        self.consistency.interrupt()
        if self.laws is not None:
            self.laws.interrupt()
        self.noise.restart(block.deflection, deflection_variance)
