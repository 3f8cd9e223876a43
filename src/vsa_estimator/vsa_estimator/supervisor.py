"""Steps of one transmission's filter, and all that has to happen between them.

Where the rod is when the encoder tells another story, whether a motion has broken off, when to learn and to forget.
"""

import math

import numpy as np
from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.consistency import AFTER_GAP, INCONSISTENT, ConsistencyMonitor
from vsa_estimator.fault_detection.encoder_step import OffsetHypothesis
from vsa_estimator.fault_detection.latch import FaultLatch
from vsa_estimator.filter.ekf import REST_SPEED
from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.process_noise import LEAST, LEAST_HEAVY, JerkDensity
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.initialization.scheduler import Initializer
from vsa_estimator.output.predictor import MAX_PREDICTION_TIME
from vsa_estimator.output.validity import inertia_observable
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.preprocessing.pipeline import BEYOND_PEAK_SPEED, Pipeline
from vsa_estimator.settings import EstimatorConfig

REFRESH = 0.5  # noise, jerk density and start values are renewed this often [s]
NOISE_MEMORY = 9.0  # [s]
COUNTED_GAP = 1.0  # silence from this long on counts as a reset [s]
PAUSE = 2.5  # periods of filter or samples after which a deflection may be in another place than expected ...
UNSURE_NS = 100_000_000  # ... and for so long after samples in a hurry, or an encoder that was not believed [ns]
STOP = 1.0  # data is kept for learning until this long after motion ends [s]
MOVED = "looking whether the rod moved or the encoder jumped"
RELOCATE = 0.2  # deflections rejected for this long are taken for the truth [s]
ANOTHER = 30.0  # times the jerk density, at once: the motion has become another
LIGHT = 0.3  # of the force's noise, up to which what moves the mass is not felt
AUDIT_FIRST, AUDIT_MOST = 8_000_000_000, 64_000_000_000  # a filter that knows is compared with a regression [ns]


class Supervisor:
    """The filter of one transmission, block by block.

    `tracker` is the filter; `blind` says that the encoder is not to be believed.
    """

    def __init__(self, config: EstimatorConfig, samples: Pipeline, health: FaultLatch) -> None:
        """`samples` know their period and how much noisier they are than configured; `health` hears complaints."""
        self._config = config
        self._samples = samples
        self._health = health
        self.reset_count = 0
        self.reset_reason = ResetReason.NONE
        self.force_rejected = 0
        self.deflection_rejected = 0
        self.tracker: Tracker
        self.begin()

    def begin(self) -> None:
        """Forget everything but the counters."""
        rate, memory = self._config.filter_rate, int(NOISE_MEMORY * self._config.filter_rate)
        self.force_noise = NoiseLevel(self._config.force_noise_std, 0.0, memory)
        self.deflection_noise = NoiseLevel(self._config.deflection_std, self._config.quantisation_std, memory)
        self.jerk = JerkDensity()
        self.tracker = Tracker(self._config.initial, rate)
        self.initializer = Initializer(self._config.initial, rate)
        self.consistency = ConsistencyMonitor(rate)
        self.encoder_fault = False
        self.inertia_observable = False
        self.step_ns = 0  # instant of the last step
        self._offset_hypothesis = OffsetHypothesis()
        self._averaged = 1  # samples in the last block
        self._force = 0.0
        self._has_fit = False
        self._epoch_ns = self._moved_ns = self._refreshed_ns = self._accepted_ns = self._timing_suspect_ns = 0
        self._audit_ns = self._audit_pause = AUDIT_FIRST

    def start(self, instant_ns: int, force: float, deflection: float) -> None:
        """Begin with the first sample."""
        self.tracker.start(deflection, force, self.deflection_noise.std**2)
        self._epoch_ns = self.step_ns = self._refreshed_ns = self._accepted_ns = instant_ns
        self._moved_ns = instant_ns - int(STOP * 1e9)

    def mark_timing_suspect(self, instant_ns: int) -> None:
        """Samples came in a hurry: a clock may have stood still."""
        self._timing_suspect_ns = instant_ns

    def step(self, block: Decimated, force: float) -> None:
        """One step of the filter at a block's mean stamp; `force` [N] is the newest one, for a block that has none."""
        tracker = self.tracker
        self._force = block.force if block.forces else force
        dt = (block.stamp_ns - self.step_ns) * 1e-9
        deflection_variance = (self._samples.deflection_noise * self.deflection_noise.std) ** 2 / block.samples
        if 0.0 < dt <= MAX_PREDICTION_TIME:
            tracker.predict(dt, self.jerk.density)
        if self._is_discontinuous(block, dt, deflection_variance):
            self._restart_after_gap(block, dt, deflection_variance)
        self.step_ns = block.stamp_ns
        if not self._update_position(block, deflection_variance):
            return
        self._accepted_ns = block.stamp_ns
        self._offset_hypothesis.clear()
        self.deflection_noise.add(block.deflection, block.samples)
        self.jerk.add(block.deflection, deflection_variance, min(dt, MAX_PREDICTION_TIME))
        if abs(tracker.speed) > REST_SPEED:
            self._moved_ns = block.stamp_ns
        self._samples.memory[BEYOND_PEAK_SPEED] = tracker.beyond_peak_speed
        reset = self.consistency.evaluate(tracker, block.stamp_ns * 1e-9, block, self.encoder_fault)
        if reset is not ResetReason.NONE:
            self.count_reset(reset)
            if not tracker.initialized:
                self._restart_initialization(self._force)
        calm = self.jerk.density
        startled = tracker.initialized and self.jerk.detect_manoeuvre(tracker.deflection_nis)
        if self.jerk.density > ANOTHER * calm:
            tracker.reset_matching()
        if startled or self.consistency.reason:
            self.force_noise.interrupt()
        elif block.forces:
            self._update_force(block, dt, deflection_variance)
        else:
            self.force_noise.interrupt()
        if block.stamp_ns - self._refreshed_ns >= REFRESH * 1e9 - 0.5 * self._samples.period_ns:
            self._refreshed_ns = block.stamp_ns
            self._refresh(block)
        self._averaged = block.samples
        self.inertia_observable = inertia_observable(tracker, self.force_noise.std)

    def _is_discontinuous(self, block: Decimated, dt: float, deflection_variance: float) -> bool:
        """Whether a block is no sequel of the motion: after a long silence, or in another place where that may be.

        That is after a pause, samples in a hurry, or an encoder that was not believed: the clock may have stood still,
        or the encoder, and has not jumped.
        """
        if dt > MAX_PREDICTION_TIME:
            return True
        if self.encoder_fault:
            self._timing_suspect_ns = block.stamp_ns
            return False
        pause = PAUSE * max(1.0 / self._config.filter_rate, self._samples.period_ns * 1e-9)
        unsure = dt > pause or 0 <= block.stamp_ns - self._timing_suspect_ns < UNSURE_NS
        return unsure and self.tracker.is_outlier(block.deflection, deflection_variance)

    def _update_position(self, block: Decimated, deflection_variance: float) -> bool:
        """Take the deflection in, also of a rod that sets off; False where it is not believed."""
        tracker, jump = self.tracker, self._offset_hypothesis
        offset = block.deflection - float(tracker.z[0])
        insists = tracker.initialized and jump.is_repeated(offset)
        if not insists and tracker.update_deflection(block.deflection, deflection_variance):
            return True
        expected = tracker.predicted_force(float(tracker.z[0])) if block.forces else math.nan
        jump.reject(block.deflection, offset, block.force - expected)
        since = (block.stamp_ns - self._accepted_ns) * 1e-9
        if jump.is_motion_onset:
            self.jerk.detect_manoeuvre(tracker.deflection_nis)
            tracker.inflate_for_acceleration(offset, since)
        if (jump.is_motion_onset or (insists and not self._supported_by_force())) and tracker.update_deflection(
            block.deflection, deflection_variance
        ):
            return True
        self.deflection_rejected += 1
        if since > RELOCATE or (
            insists and jump.is_confirmed and tracker.position_uncertain(offset, deflection_variance)
        ):
            self._reset_position(block, deflection_variance)
        return False

    def _supported_by_force(self) -> bool:
        """Whether the force says that the rod is where it was expected, though the encoder insists on another place."""
        tracker, place = self.tracker, float(self.tracker.z[0])
        return self._offset_hypothesis.supported_by_force(
            tracker.predicted_force(place + self._offset_hypothesis.size) - tracker.predicted_force(place)
        )

    def _update_force(self, block: Decimated, dt: float, deflection_variance: float) -> None:
        tracker = self.tracker
        self.force_noise.add(block.force, block.forces)
        if block.stamp_ns - self._moved_ns < STOP * 1e9:
            self.initializer.add((block.stamp_ns - self._epoch_ns) * 1e-9, block.deflection, block.force)
        if not tracker.initialized:
            return
        force_variance = (self._samples.force_noise * self.force_noise.std) ** 2 / block.forces
        if not tracker.update_force(block.force, force_variance, deflection_variance, dt):
            self.force_rejected += 1
        if tracker.nis_test_failed and self.consistency.is_consistent:
            tracker.reset_nis_test()
        elif tracker.nis_test_failed and not self.consistency.suspend(tracker, INCONSISTENT):
            self._restart_initialization(block.force)
            self.count_reset(ResetReason.INNOVATION)

    def _restart_initialization(self, force: float) -> None:
        self.consistency.reset()
        self.initializer.clear()
        self.tracker.reset_coefficients(force)
        self._has_fit = False

    def _refresh(self, block: Decimated) -> None:
        self.force_noise.refresh()
        self.deflection_noise.refresh()
        light = self.tracker.initialized and self.tracker.max_inertial_force < LIGHT * self.force_noise.std
        self.jerk.refresh(LEAST if light else LEAST_HEAVY)
        if self.tracker.initialized and (block.stamp_ns < self._audit_ns or self.consistency.reason):
            return
        if not self.tracker.initialized and not self._has_fit and block.forces:
            self.tracker.reset_coefficients(block.force)
        period = max(1.0 / self._config.filter_rate, self._samples.period_ns * 1e-9)
        per_block = 1.0 / math.sqrt(block.samples)
        self.initializer.begin(
            period, self.tracker.reference, self.force_noise.std * per_block,
            self.deflection_noise.std * per_block, self.jerk.likeliest, audit=self.tracker.initialized,
        )  # fmt: skip

    def run_initialization(self) -> None:
        """A slice of learning; what is found goes into the filter."""
        fit = self.initializer.advance(self._samples.period_ns * 1e-9)
        if fit is None:
            return
        tracker, sure = (
            self.tracker,
            self.initializer.ready_to_hand_over(fit, self.force_noise.std / math.sqrt(self._averaged)),
        )
        if tracker.initialized:
            self._audit_pause = min(2 * self._audit_pause, AUDIT_MOST)
            self._audit_ns = self.step_ns + self._audit_pause
            if not sure or not tracker.cross_check_failed(
                fit.mean, fit.covariance, fit.acceleration, self.force_noise.std
            ):
                return
            self.consistency.reset()
            self.count_reset(ResetReason.INNOVATION)
        self._has_fit = True
        floor = np.array([1e-6, (1e-3 * fit.mean[1]) ** 2, 1.0, 1e10, 0.0, 0.0, 0.0])
        tracker.set_coefficients(fit.mean, fit.covariance + np.diag(floor))
        if sure and not tracker.initialized:
            tracker.initialized = True
            tracker.set_stroke(*self.initializer.range)
            self._audit_pause = AUDIT_FIRST
            self._audit_ns = self.step_ns + AUDIT_FIRST

    def _restart_after_gap(self, block: Decimated, silence: float, deflection_variance: float) -> None:
        """Where the motion has broken off: a new place, the old coefficients."""
        self.tracker.reset_position(block.deflection, deflection_variance)
        self._interrupt(block, deflection_variance)
        self.consistency.suspend(self.tracker, AFTER_GAP, broken=True)
        if silence > COUNTED_GAP:
            self.count_reset(ResetReason.GAP)

    def _reset_position(self, block: Decimated, deflection_variance: float) -> None:
        """The encoder insists on another place: re-zeroed, or moved while nobody believed it."""
        tracker, jump = self.tracker, self._offset_hypothesis.size
        words, jumped, told = f"encoder jumped by {1e3 * jump:+.2f} mm", True, False
        if tracker.initialized:
            jumped = not self.encoder_fault and self._offset_hypothesis.is_confirmed and self._supported_by_force()
            if jumped:
                self.consistency.move(tracker, jump, self._offset_hypothesis.variance + deflection_variance)
                told = self.consistency.suspend(tracker, words)
            else:
                self.consistency.suspend(tracker, MOVED, broken=True)
        else:
            tracker.reference = block.deflection
            tracker.reset_coefficients(self._force)
            self._has_fit = False
        tracker.reset_position(block.deflection, deflection_variance)
        self.initializer.clear()
        self._interrupt(block, deflection_variance)
        self.count_reset(ResetReason.DEFLECTION)
        if jumped and not told:  # by a doubt; too little is proven for one
            self._health.raise_fault(words, block.stamp_ns)

    def _interrupt(self, block: Decimated, deflection_variance: float) -> None:
        self._accepted_ns = block.stamp_ns
        self._offset_hypothesis.clear()
        self.consistency.interrupt()
        self.jerk.restart(block.deflection, deflection_variance)
        self.deflection_noise.interrupt()
        self.force_noise.interrupt()

    def count_reset(self, reason: ResetReason) -> None:
        """One more reset."""
        self.reset_count += 1
        self.reset_reason = reason
