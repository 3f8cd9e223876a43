"""Filter steps of one transmission, with resets of the position, suspension of updates, and initialization."""

import math

from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.consistency import AFTER_GAP, INCONSISTENT, ConsistencyMonitor, Decision
from vsa_estimator.fault_detection.counters import Counters
from vsa_estimator.fault_detection.latch import FaultLatch
from vsa_estimator.fault_detection.position import PositionMonitor, PositionUpdate, is_pause
from vsa_estimator.filter.adaptation import NoiseAdaptation
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.initialization.hand_over import HandOver, StepNoise
from vsa_estimator.modes import Event, ModeMachine
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
        self.modes = ModeMachine()
        self.encoder_fault = False  # of the last sample
        self.inertia_observable = False  # at the last step
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
        self.inertia_observable = inertia_observable(tracker, self.noise.force.std)

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
        force_variance = (self._pipeline.force_noise_ratio * self.noise.force.std) ** 2 / block.forces
        if not tracker.update_force(block.force, force_variance, deflection_variance, dt):
            self.counters.count_rejected(force=True)
        if not tracker.nis_test_failed:
            return
        if self.consistency.is_consistent:
            tracker.reset_nis_test()
        elif not self._suspend(INCONSISTENT):
            self._restart_initialization(block.force)
            self.counters.count_reset(ResetReason.INNOVATION)

    def _restart_initialization(self, force: float) -> None:
        """Drop the coefficients, and begin with the start values at the present `force` [N]."""
        self.modes.handle(Event.REJECTED)
        self.consistency.reset()
        self.hand_over.restart()
        self.tracker.reset_coefficients(force)

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
        """Do the due part of a regression; its result initializes the filter, or replaces its coefficients."""
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
            if stepped:
                variance = self._position.step_variance + deflection_variance
                tracker.restore(*self.consistency.shift_reference(tracker, step, variance))
                suspended = self._suspend(text)
            else:
                self._suspend(POSITION_UNCERTAIN, interrupted=True)
        else:
            tracker.set_reference(block.deflection)
            tracker.reset_coefficients(self._force)
            self.hand_over.restart()
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
        self.noise.restart(block.deflection, deflection_variance)
