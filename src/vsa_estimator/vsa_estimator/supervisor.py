"""Steps of one transmission's filter, and all that has to happen between them.

Where the rod is when the encoder tells another story, whether a motion has broken off, when to learn and to forget.
"""

import math

import numpy as np
from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.consistency import CONTRADICTION, SILENCE, Trust
from vsa_estimator.fault_detection.encoder_step import Jump
from vsa_estimator.fault_detection.latch import Health
from vsa_estimator.filter.ekf import REST_SPEED
from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.process_noise import LEAST, LEAST_HEAVY, JerkDensity
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.initialization.scheduler import Learner
from vsa_estimator.output.predictor import BRIDGED
from vsa_estimator.output.validity import inertia_known
from vsa_estimator.preprocessing.decimator import Block
from vsa_estimator.preprocessing.pipeline import UNDAMPED, Samples
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

    def __init__(self, config: EstimatorConfig, samples: Samples, health: Health) -> None:
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
        self.learner = Learner(self._config.initial, rate)
        self.trust = Trust(rate)
        self.blind = False
        self.inertia_known = False
        self.step_ns = 0  # instant of the last step
        self._jump = Jump()
        self._averaged = 1  # samples in the last block
        self._force = 0.0
        self._has_fit = False
        self._epoch_ns = self._moved_ns = self._refreshed_ns = self._accepted_ns = self._unsure_ns = 0
        self._audit_ns = self._audit_pause = AUDIT_FIRST

    def start(self, instant_ns: int, force: float, deflection: float) -> None:
        """Begin with the first sample."""
        self.tracker.start(deflection, force, self.deflection_noise.std**2)
        self._epoch_ns = self.step_ns = self._refreshed_ns = self._accepted_ns = instant_ns
        self._moved_ns = instant_ns - int(STOP * 1e9)

    def hurry(self, instant_ns: int) -> None:
        """Samples came in a hurry: a clock may have stood still."""
        self._unsure_ns = instant_ns

    def step(self, block: Block, force: float) -> None:
        """One step of the filter at a block's mean stamp; `force` [N] is the newest one, for a block that has none."""
        tracker = self.tracker
        self._force = block.force if block.forces else force
        dt = (block.stamp_ns - self.step_ns) * 1e-9
        deflection_variance = (self._samples.deflection_noise * self.deflection_noise.std) ** 2 / block.samples
        if 0.0 < dt <= BRIDGED:
            tracker.predict(dt, self.jerk.density)
        if self._broken(block, dt, deflection_variance):
            self._resume(block, dt, deflection_variance)
        self.step_ns = block.stamp_ns
        if not self._place(block, deflection_variance):
            return
        self._accepted_ns = block.stamp_ns
        self._jump.clear()
        self.deflection_noise.add(block.deflection, block.samples)
        self.jerk.add(block.deflection, deflection_variance, min(dt, BRIDGED))
        if abs(tracker.speed) > REST_SPEED:
            self._moved_ns = block.stamp_ns
        self._samples.memory[UNDAMPED] = tracker.undamped
        reset = self.trust.weigh(tracker, block.stamp_ns * 1e-9, block, self.blind)
        if reset is not ResetReason.NONE:
            self.count_reset(reset)
            if not tracker.knows:
                self._start_over(self._force)
        calm = self.jerk.density
        startled = tracker.knows and self.jerk.startled(tracker.deflection_nis)
        if self.jerk.density > ANOTHER * calm:
            tracker.startle()
        if startled or self.trust.reason:
            self.force_noise.interrupt()
        elif block.forces:
            self._take_force(block, dt, deflection_variance)
        else:
            self.force_noise.interrupt()
        if block.stamp_ns - self._refreshed_ns >= REFRESH * 1e9 - 0.5 * self._samples.period_ns:
            self._refreshed_ns = block.stamp_ns
            self._refresh(block)
        self._averaged = block.samples
        self.inertia_known = inertia_known(tracker, self.force_noise.std)

    def _broken(self, block: Block, dt: float, deflection_variance: float) -> bool:
        """Whether a block is no sequel of the motion: after a long silence, or in another place where that may be.

        That is after a pause, samples in a hurry, or an encoder that was not believed: the clock may have stood still,
        or the encoder, and has not jumped.
        """
        if dt > BRIDGED:
            return True
        if self.blind:
            self._unsure_ns = block.stamp_ns
            return False
        pause = PAUSE * max(1.0 / self._config.filter_rate, self._samples.period_ns * 1e-9)
        unsure = dt > pause or 0 <= block.stamp_ns - self._unsure_ns < UNSURE_NS
        return unsure and self.tracker.surprised(block.deflection, deflection_variance)

    def _place(self, block: Block, deflection_variance: float) -> bool:
        """Take the deflection in, also of a rod that sets off; False where it is not believed."""
        tracker, jump = self.tracker, self._jump
        offset = block.deflection - float(tracker.z[0])
        insists = tracker.knows and jump.insists(offset)
        if not insists and tracker.correct_deflection(block.deflection, deflection_variance):
            return True
        expected = tracker.expected_force(float(tracker.z[0])) if block.forces else math.nan
        jump.reject(block.deflection, offset, block.force - expected)
        since = (block.stamp_ns - self._accepted_ns) * 1e-9
        if jump.sets_off:
            self.jerk.startled(tracker.deflection_nis)
            tracker.set_off(offset, since)
        if (jump.sets_off or (insists and not self._stayed())) and tracker.correct_deflection(
            block.deflection, deflection_variance
        ):
            return True
        self.deflection_rejected += 1
        if since > RELOCATE or (insists and jump.proven and tracker.doubts_place(offset, deflection_variance)):
            self._relocate(block, deflection_variance)
        return False

    def _stayed(self) -> bool:
        """Whether the force says that the rod is where it was expected, though the encoder insists on another place."""
        tracker, place = self.tracker, float(self.tracker.z[0])
        return self._jump.stayed(tracker.expected_force(place + self._jump.size) - tracker.expected_force(place))

    def _take_force(self, block: Block, dt: float, deflection_variance: float) -> None:
        tracker = self.tracker
        self.force_noise.add(block.force, block.forces)
        if block.stamp_ns - self._moved_ns < STOP * 1e9:
            self.learner.add((block.stamp_ns - self._epoch_ns) * 1e-9, block.deflection, block.force)
        if not tracker.knows:
            return
        force_variance = (self._samples.force_noise * self.force_noise.std) ** 2 / block.forces
        if not tracker.correct_force(block.force, force_variance, deflection_variance, dt):
            self.force_rejected += 1
        if tracker.suspicious and self.trust.agrees:
            tracker.clear_watch()
        elif tracker.suspicious and not self.trust.doubt(tracker, CONTRADICTION):
            self._start_over(block.force)
            self.count_reset(ResetReason.INNOVATION)

    def _start_over(self, force: float) -> None:
        self.trust.forget()
        self.learner.clear()
        self.tracker.forget(force)
        self._has_fit = False

    def _refresh(self, block: Block) -> None:
        self.force_noise.refresh()
        self.deflection_noise.refresh()
        light = self.tracker.knows and self.tracker.greatest_inertial_force < LIGHT * self.force_noise.std
        self.jerk.refresh(LEAST if light else LEAST_HEAVY)
        if self.tracker.knows and (block.stamp_ns < self._audit_ns or self.trust.reason):
            return
        if not self.tracker.knows and not self._has_fit and block.forces:
            self.tracker.forget(block.force)
        period = max(1.0 / self._config.filter_rate, self._samples.period_ns * 1e-9)
        per_block = 1.0 / math.sqrt(block.samples)
        self.learner.begin(
            period, self.tracker.reference, self.force_noise.std * per_block,
            self.deflection_noise.std * per_block, self.jerk.likeliest, audit=self.tracker.knows,
        )  # fmt: skip

    def learn(self) -> None:
        """A slice of learning; what is found goes into the filter."""
        fit = self.learner.advance(self._samples.period_ns * 1e-9)
        if fit is None:
            return
        tracker, sure = self.tracker, self.learner.sure(fit, self.force_noise.std / math.sqrt(self._averaged))
        if tracker.knows:
            self._audit_pause = min(2 * self._audit_pause, AUDIT_MOST)
            self._audit_ns = self.step_ns + self._audit_pause
            if not sure or not tracker.contradicts(fit.mean, fit.covariance, fit.acceleration, self.force_noise.std):
                return
            self.trust.forget()
            self.count_reset(ResetReason.INNOVATION)
        self._has_fit = True
        floor = np.array([1e-6, (1e-3 * fit.mean[1]) ** 2, 1.0, 1e10, 0.0, 0.0, 0.0])
        tracker.learn(fit.mean, fit.covariance + np.diag(floor))
        if sure and not tracker.knows:
            tracker.knows = True
            tracker.remember_stroke(*self.learner.range)
            self._audit_pause = AUDIT_FIRST
            self._audit_ns = self.step_ns + AUDIT_FIRST

    def _resume(self, block: Block, silence: float, deflection_variance: float) -> None:
        """Where the motion has broken off: a new place, the old coefficients."""
        self.tracker.place(block.deflection, deflection_variance)
        self._interrupt(block, deflection_variance)
        self.trust.doubt(self.tracker, SILENCE, broken=True)
        if silence > COUNTED_GAP:
            self.count_reset(ResetReason.GAP)

    def _relocate(self, block: Block, deflection_variance: float) -> None:
        """The encoder insists on another place: re-zeroed, or moved while nobody believed it."""
        tracker, jump = self.tracker, self._jump.size
        words, jumped, told = f"encoder jumped by {1e3 * jump:+.2f} mm", True, False
        if tracker.knows:
            jumped = not self.blind and self._jump.proven and self._stayed()
            if jumped:
                self.trust.move(tracker, jump, self._jump.variance + deflection_variance)
                told = self.trust.doubt(tracker, words)
            else:
                self.trust.doubt(tracker, MOVED, broken=True)
        else:
            tracker.reference = block.deflection
            tracker.forget(self._force)
            self._has_fit = False
        tracker.place(block.deflection, deflection_variance)
        self.learner.clear()
        self._interrupt(block, deflection_variance)
        self.count_reset(ResetReason.DEFLECTION)
        if jumped and not told:  # by a doubt; too little is proven for one
            self._health.complain(words, block.stamp_ns)

    def _interrupt(self, block: Block, deflection_variance: float) -> None:
        self._accepted_ns = block.stamp_ns
        self._jump.clear()
        self.trust.interrupt()
        self.jerk.restart(block.deflection, deflection_variance)
        self.deflection_noise.interrupt()
        self.force_noise.interrupt()

    def count_reset(self, reason: ResetReason) -> None:
        """One more reset."""
        self.reset_count += 1
        self.reset_reason = reason
