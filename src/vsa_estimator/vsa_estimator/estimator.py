"""Impedance of one transmission from its force and deflection, sample by sample.

Live and replayed samples take the same way: intake -> block average -> filter -> report. The same samples give the
same estimates to the bit: nothing here asks a clock, and long computations are cut into slices counted in steps.
"""

import math

import numpy as np
from numpy.typing import NDArray
from vsa_estimator import signs
from vsa_estimator.assessment import (
    BELIEFS,
    BRIDGED,
    FOLLOWED,
    HOLDS,
    REFERENCE,
    Assessment,
    assess,
    follow,
    follow_all,
)
from vsa_estimator.blocks import Block
from vsa_estimator.filter import REST_SPEED
from vsa_estimator.health import Health
from vsa_estimator.intake import DROP, JUMP
from vsa_estimator.jerk import LEAST, LEAST_HEAVY, JerkDensity
from vsa_estimator.jump import Jump
from vsa_estimator.learner import Learner
from vsa_estimator.model import Array
from vsa_estimator.noise_level import NoiseLevel
from vsa_estimator.observability import Known, explain, inertia_known, judge
from vsa_estimator.samples import DEFLECTION_SPIKE, FORCE_SPIKE, UNDAMPED, Samples
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tracker import Tracker
from vsa_estimator.trust import CONTRADICTION, SILENCE, Trust
from vsa_estimator.values import Estimate, Reset, State, Status, no_rows, row_of
from vsa_estimator.warm_up import warm_up

REFRESH = 0.5  # noise, jerk density and start values are renewed this often [s]
NOISE_MEMORY = 9.0  # [s]
COUNTED_GAP = 1.0  # silence from this long on counts as a reset [s]
PAUSE = 2.5  # periods of filter or samples after which a deflection may be in another place than expected ...
UNSURE_NS = 100_000_000  # ... and for so long after samples in a hurry, or an encoder that was not believed [ns]
STOP = 1.0  # data is kept for learning until this long after motion ends [s]
MOVED = "looking whether the rod moved or the encoder jumped"
RELOCATE = 0.2  # deflections rejected for this long are taken for the truth [s]
STALE_PERIODS, STALE_TIME = 5, 0.05  # silence is stale after the longer of the two [1, s]
ANOTHER = 30.0  # times the jerk density, at once: the motion has become another
LIGHT = 0.3  # of the force's noise, up to which what moves the mass is not felt
AUDIT_FIRST, AUDIT_MOST = 8_000_000_000, 64_000_000_000  # a filter that knows is compared with a regression [ns]
INVALID_TIME = 0.1  # and its estimates are invalid from then on [s]
COEFFICIENTS = 6  # of an appraisal, the first ones, go with each estimate
_TUPLE = tuple.__new__
_STATUS = tuple(Status)


class Estimator:
    """The live estimator of one transmission, formulation `force`."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Compiles what has to be compiled, so that no sample waits for it."""
        self.config = config
        self._samples = Samples(config)
        self._health = Health()
        self._dropped = 0
        self._reset_count = 0
        self._reset_reason = Reset.NONE
        self._fused = 0
        self._force_rejected = 0
        self._deflection_rejected = 0
        self._estimate: Estimate | None
        self._started: bool
        self._tracker: Tracker
        self._left: list[Block] | None  # blocks that are to be taken, where a sample has left work to do
        self._beliefs: Array
        self._moments: NDArray[np.int64]
        self._begin()
        warm_up()

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Estimate at a sample of rod force [N] and deflection [m]; None for one that was dropped and counted.

        Where samples are averaged the step that is due comes after the estimate: by `catch_up`, or before the next.
        """
        self._settle()
        samples = self._samples
        verdict, found, instant_ns, blocks, assessment = follow(
            samples.memory, samples.stamps, self._tracker.known, self._beliefs, self._moments,
            stamp_ns, force, deflection,
        )  # fmt: skip
        if verdict != FOLLOWED:
            return self._heed(verdict, found, instant_ns, blocks, stamp_ns, force, deflection)
        self._blind = False
        return self._report(stamp_ns, instant_ns, force, assessment)

    def add_all(self, stamp_ns: NDArray[np.int64], force: Array, deflection: Array) -> Array:
        """`add` of samples in arrays: a row with the fields of an Estimate from force_valid on for each, NaN for none.

        To the bit what `add` says of each of them.
        """
        samples, end = self._samples, len(stamp_ns) - 1
        rows = no_rows(len(stamp_ns))
        first = 0
        while first <= end:  # the last one by itself: it leaves all as `add` does
            self._settle()
            until, verdict, found, instant_ns, blocks = follow_all(
                rows, samples.memory, samples.stamps, self._tracker.known, self._beliefs, self._moments,
                stamp_ns, force, deflection, first, end,
            )  # fmt: skip
            if until > first:
                self._fused += until - first
                self._force = float(force[until - 1])
            one = int(stamp_ns[until]), float(force[until]), float(deflection[until])
            if verdict == FOLLOWED:
                estimate = self.add(*one)
            else:
                estimate = self._heed(verdict, found, instant_ns, blocks, *one)
            rows[until] = row_of(estimate)
            first = until + 1
        return rows

    def catch_up(self) -> bool:
        """Do one thing that the last sample has left to do, steps or a slice of learning; whether there was any."""
        if self._left is None:
            return False
        blocks, self._left = self._left, None
        if blocks and self._learner.works:
            self._left = []
        for block in blocks:
            self._step(block)
        if not blocks:
            self._learn()
        if blocks or not self._learner.works:
            self._believe()
        return True

    def _settle(self) -> None:
        while self.catch_up():
            pass

    def coast(self, stamp_ns: int) -> Estimate | None:
        """Estimate at an instant [ns] without a sample; STALE when silence lasts. None before the first sample."""
        last = self._estimate
        if last is None or stamp_ns <= self._stamp_ns:
            return None
        self._settle()
        silence = (stamp_ns - self._stamp_ns) * 1e-9
        stale = silence >= max(STALE_PERIODS * self._samples.period_ns * 1e-9, STALE_TIME)
        now = self._estimate_of(stamp_ns, assess(
            self._tracker.known, self._beliefs, self._moments, stamp_ns, self._instant_ns + stamp_ns - self._stamp_ns,
            math.nan, silence < INVALID_TIME, self._blind, stale,
        ))  # fmt: skip
        shrunk = max(1.0, last.stiffness / max(now.stiffness, 1e-9))  # its variance grows, even where a spring slackens
        return now._replace(stiffness_variance=now.stiffness_variance * shrunk * shrunk)

    def reset(self, reason: Reset = Reset.REQUESTED) -> None:
        """Forget everything but the counters."""
        self._health.clear()
        self._begin()
        self._count_reset(reason)

    def state(self) -> State:
        """What the estimator knows now."""
        self._settle()
        tracker, estimate = self._tracker, self._estimate
        known = judge(tracker, self._force_noise.std) if estimate else Known(*[False] * 7)
        if estimate is None:
            status, stiffness_valid, damping_valid, moving = Status.INITIALIZING, False, False, False
        else:
            status, moving = estimate.status, estimate.velocity_valid
            stiffness_valid, damping_valid = estimate.stiffness_valid, estimate.damping_valid
        z, p = tracker.z.tolist(), tracker.covariance
        variance = np.diag(p).tolist()
        complaints = filter(None, [*self._health.complaints(self._stamp_ns), self._trust.reason])
        lines = explain(tracker, known, stiffness_valid, damping_valid)
        reason = "; ".join(complaints) or ("" if stiffness_valid else lines[0])
        if status is Status.INITIALIZING:
            reason = "no sample yet"
        return State(
            self._stamp_ns, status, reason, self._reset_count, self._reset_reason,
            z[0], variance[0], moving, z[1], variance[1], moving, z[2], variance[2], moving,
            tracker.reference, z[3], variance[3], known.stiffness,
            z[4], tracker.appraisal.k2_variance, known.k2,
            z[5], variance[5], known.d1,
            z[6], tracker.appraisal.d2_variance, known.d2,
            z[7], tracker.appraisal.inertia_variance, known.inertia,
            z[8], variance[8], known.force_offset,
            z[9], variance[9], known.coulomb_friction,
            tuple(p[3:, 3:].ravel().tolist()), lines,
            float(tracker.force_monitor[0]), float(tracker.force_monitor[1]),
            float(tracker.deflection_monitor[0]), float(tracker.deflection_monitor[1]),
            float(tracker.force_monitor[2]), self._force_noise.std, self._deflection_noise.std, self._jerk.density,
            self._fused, self._dropped, self._force_rejected, self._deflection_rejected,
            self._health.force_repeated,
        )  # fmt: skip

    def _begin(self) -> None:
        config = self.config
        rate = config.filter_rate
        memory = int(NOISE_MEMORY * rate)
        self._force_noise = NoiseLevel(config.force_noise_std, 0.0, memory)
        self._deflection_noise = NoiseLevel(config.deflection_std, config.quantisation_std, memory)
        self._jerk = JerkDensity()
        self._samples.forget()
        self._blind = False  # the encoder is not to be believed
        self._tracker = Tracker(config.initial, rate)
        self._learner = Learner(config.initial, rate)
        self._trust = Trust(rate)
        self._jump = Jump()
        self._inertia_known = False
        self._averaged = 1  # samples in the last block
        self._estimate = None
        self._left = None
        self._started = False
        self._has_fit = False
        self._stamp_ns = self._instant_ns = self._step_ns = self._epoch_ns = 0
        self._force = 0.0
        self._beliefs, self._moments = np.zeros(BELIEFS), np.zeros(2, dtype=np.int64)
        self._moved_ns = self._refreshed_ns = self._accepted_ns = self._unsure_ns = 0
        self._audit_ns = self._audit_pause = AUDIT_FIRST

    def _heed(
        self, verdict: int, found: int, instant_ns: int, blocks: int, stamp_ns: int, force: float, deflection: float
    ) -> Estimate | None:
        """What a sample makes one do: drop it, start, hear signs of trouble, take steps, learn."""
        if verdict == DROP:
            self._dropped += 1
            return None
        if verdict == JUMP:
            self.reset(Reset.TIME_JUMP)
            return self.add(stamp_ns, force, deflection)
        self._blind = found & signs.BLINDED > 0
        if not self._started:
            self._start(instant_ns, force, deflection)
        if found:
            if found & signs.HURRIED:
                self._unsure_ns = instant_ns
            self._health.hear(found, stamp_ns)
            self._force_rejected += found & FORCE_SPIKE > 0
            self._deflection_rejected += found & DEFLECTION_SPIKE > 0
        finished, averaged = self._samples.finished(blocks), self._samples.averaged
        if not averaged:
            for block in finished:
                self._step(block)
            if self._learner.works:
                self._learn()
        elif finished or self._learner.works:
            self._left = finished
        if found or not averaged:
            self._believe()
        if found & DEFLECTION_SPIKE:
            deflection = math.nan
        return self._report(stamp_ns, instant_ns, force, assess(
            self._tracker.known, self._beliefs, self._moments, stamp_ns, instant_ns, deflection,
            True, self._blind, False,
        ))  # fmt: skip

    def _believe(self) -> None:
        """What holds until the next sample that is to be heeded."""
        tracker = self._tracker
        self._force_variance = self._force_noise.std**2
        self._behind = self._reset_count, self._reset_reason, *tracker.appraisal[:COEFFICIENTS]
        self._moments[:] = self._step_ns, self._health.until_ns
        self._beliefs[HOLDS] = not self._learner.works
        self._beliefs[REFERENCE:] = (
            tracker.reference, self._jerk.density, self._deflection_noise.std**2,
            self._trust.reason != "", tracker.knows, self._inertia_known, *self._behind,
        )  # fmt: skip

    def _start(self, instant_ns: int, force: float, deflection: float) -> None:
        self._tracker.start(deflection, force, self._deflection_noise.std**2)
        self._epoch_ns = self._step_ns = self._refreshed_ns = self._accepted_ns = instant_ns
        self._moved_ns = instant_ns - int(STOP * 1e9)
        self._started = True

    def _step(self, block: Block) -> None:
        """One step of the filter at a block's mean stamp."""
        tracker = self._tracker
        dt = (block.stamp_ns - self._step_ns) * 1e-9
        deflection_variance = (self._samples.deflection_noise * self._deflection_noise.std) ** 2 / block.samples
        if 0.0 < dt <= BRIDGED:
            tracker.predict(dt, self._jerk.density)
        if self._broken(block, dt, deflection_variance):
            self._resume(block, dt, deflection_variance)
        self._step_ns = block.stamp_ns
        if not self._place(block, deflection_variance):
            return
        self._accepted_ns = block.stamp_ns
        self._jump.clear()
        self._deflection_noise.add(block.deflection, block.samples)
        self._jerk.add(block.deflection, deflection_variance, min(dt, BRIDGED))
        if abs(tracker.speed) > REST_SPEED:
            self._moved_ns = block.stamp_ns
        self._samples.memory[UNDAMPED] = tracker.undamped
        reset = self._trust.weigh(tracker, block.stamp_ns * 1e-9, block, self._blind)
        if reset is not Reset.NONE:
            self._count_reset(reset)
            if not tracker.knows:
                self._start_over(block.force if block.forces else self._force)
        calm = self._jerk.density
        startled = tracker.knows and self._jerk.startled(tracker.deflection_nis)
        if self._jerk.density > ANOTHER * calm:
            tracker.startle()
        if startled or self._trust.reason:
            self._force_noise.interrupt()
        elif block.forces:
            self._take_force(block, dt, deflection_variance)
        else:
            self._force_noise.interrupt()
        if block.stamp_ns - self._refreshed_ns >= REFRESH * 1e9 - 0.5 * self._samples.period_ns:
            self._refreshed_ns = block.stamp_ns
            self._refresh(block)
        self._averaged = block.samples
        self._inertia_known = inertia_known(tracker, self._force_noise.std)

    def _broken(self, block: Block, dt: float, deflection_variance: float) -> bool:
        """Whether a block is no sequel of the motion: after a long silence, or in another place where that may be.

        That is after a pause, samples in a hurry, or an encoder that was not believed: the clock may have stood still,
        or the encoder, and has not jumped.
        """
        if dt > BRIDGED:
            return True
        if self._blind:
            self._unsure_ns = block.stamp_ns
            return False
        pause = PAUSE * max(1.0 / self.config.filter_rate, self._samples.period_ns * 1e-9)
        unsure = dt > pause or 0 <= block.stamp_ns - self._unsure_ns < UNSURE_NS
        return unsure and self._tracker.surprised(block.deflection, deflection_variance)

    def _place(self, block: Block, deflection_variance: float) -> bool:
        """Take the deflection in, also of a rod that sets off; False where it is not believed."""
        tracker, jump = self._tracker, self._jump
        offset = block.deflection - float(tracker.z[0])
        insists = tracker.knows and jump.insists(offset)
        if not insists and tracker.correct_deflection(block.deflection, deflection_variance):
            return True
        expected = tracker.expected_force(float(tracker.z[0])) if block.forces else math.nan
        jump.reject(block.deflection, offset, block.force - expected)
        since = (block.stamp_ns - self._accepted_ns) * 1e-9
        if jump.sets_off:
            self._jerk.startled(tracker.deflection_nis)
            tracker.set_off(offset, since)
        if (jump.sets_off or (insists and not self._stayed())) and tracker.correct_deflection(
            block.deflection, deflection_variance
        ):
            return True
        self._deflection_rejected += 1
        if since > RELOCATE or (insists and jump.proven and tracker.doubts_place(offset, deflection_variance)):
            self._relocate(block, deflection_variance)
        return False

    def _stayed(self) -> bool:
        """Whether the force says that the rod is where it was expected, though the encoder insists on another place."""
        tracker, place = self._tracker, float(self._tracker.z[0])
        return self._jump.stayed(tracker.expected_force(place + self._jump.size) - tracker.expected_force(place))

    def _take_force(self, block: Block, dt: float, deflection_variance: float) -> None:
        tracker = self._tracker
        self._force_noise.add(block.force, block.forces)
        if block.stamp_ns - self._moved_ns < STOP * 1e9:
            self._learner.add((block.stamp_ns - self._epoch_ns) * 1e-9, block.deflection, block.force)
        if not tracker.knows:
            return
        force_variance = (self._samples.force_noise * self._force_noise.std) ** 2 / block.forces
        if not tracker.correct_force(block.force, force_variance, deflection_variance, dt):
            self._force_rejected += 1
        if tracker.suspicious and self._trust.agrees:
            tracker.clear_watch()
        elif tracker.suspicious and not self._trust.doubt(tracker, CONTRADICTION):
            self._start_over(block.force)
            self._count_reset(Reset.INNOVATION)

    def _start_over(self, force: float) -> None:
        self._trust.forget()
        self._learner.clear()
        self._tracker.forget(force)
        self._has_fit = False

    def _refresh(self, block: Block) -> None:
        self._force_noise.refresh()
        self._deflection_noise.refresh()
        light = self._tracker.knows and self._tracker.greatest_inertial_force < LIGHT * self._force_noise.std
        self._jerk.refresh(LEAST if light else LEAST_HEAVY)
        if self._tracker.knows and (block.stamp_ns < self._audit_ns or self._trust.reason):
            return
        if not self._tracker.knows and not self._has_fit and block.forces:
            self._tracker.forget(block.force)
        period = max(1.0 / self.config.filter_rate, self._samples.period_ns * 1e-9)
        per_block = 1.0 / math.sqrt(block.samples)
        self._learner.begin(
            period, self._tracker.reference, self._force_noise.std * per_block,
            self._deflection_noise.std * per_block, self._jerk.density, audit=self._tracker.knows,
        )  # fmt: skip

    def _learn(self) -> None:
        fit = self._learner.advance(self._samples.period_ns * 1e-9)
        if fit is None:
            return
        tracker, sure = self._tracker, self._learner.sure(fit, self._force_noise.std / math.sqrt(self._averaged))
        if tracker.knows:
            self._audit_pause = min(2 * self._audit_pause, AUDIT_MOST)
            self._audit_ns = self._step_ns + self._audit_pause
            if not sure or not tracker.contradicts(fit.mean, fit.covariance, fit.acceleration, self._force_noise.std):
                return
            self._trust.forget()
            self._count_reset(Reset.INNOVATION)
        self._has_fit = True
        floor = np.array([1e-6, (1e-3 * fit.mean[1]) ** 2, 1.0, 1e10, 0.0, 0.0, 0.0])
        tracker.learn(fit.mean, fit.covariance + np.diag(floor))
        if sure and not tracker.knows:
            tracker.knows = True
            tracker.remember_stroke(*self._learner.range)
            self._audit_pause = AUDIT_FIRST
            self._audit_ns = self._step_ns + AUDIT_FIRST

    def _resume(self, block: Block, silence: float, deflection_variance: float) -> None:
        """Where the motion has broken off: a new place, the old coefficients."""
        self._tracker.place(block.deflection, deflection_variance)
        self._interrupt(block, deflection_variance)
        self._trust.doubt(self._tracker, SILENCE, broken=True)
        if silence > COUNTED_GAP:
            self._count_reset(Reset.GAP)

    def _relocate(self, block: Block, deflection_variance: float) -> None:
        """The encoder insists on another place: re-zeroed, or moved while nobody believed it."""
        tracker, jump = self._tracker, self._jump.size
        words, jumped, told = f"encoder jumped by {1e3 * jump:+.2f} mm", True, False
        if tracker.knows:
            jumped = not self._blind and self._jump.proven and self._stayed()
            if jumped:
                self._trust.move(tracker, jump, self._jump.variance + deflection_variance)
                told = self._trust.doubt(tracker, words)
            else:
                self._trust.doubt(tracker, MOVED, broken=True)
        else:
            tracker.reference = block.deflection
            tracker.forget(block.force if block.forces else self._force)
            self._has_fit = False
        tracker.place(block.deflection, deflection_variance)
        self._learner.clear()
        self._interrupt(block, deflection_variance)
        self._count_reset(Reset.DEFLECTION)
        if jumped and not told:  # by a doubt; too little is proven for one
            self._health.complain(words, block.stamp_ns)

    def _interrupt(self, block: Block, deflection_variance: float) -> None:
        self._accepted_ns = block.stamp_ns
        self._jump.clear()
        self._trust.interrupt()
        self._jerk.restart(block.deflection, deflection_variance)
        self._deflection_noise.interrupt()
        self._force_noise.interrupt()

    def _count_reset(self, reason: Reset) -> None:
        self._reset_count += 1
        self._reset_reason = reason

    def _report(self, stamp_ns: int, instant_ns: int, force: float, assessment: Assessment) -> Estimate:
        self._fused += 1
        self._force, self._stamp_ns, self._instant_ns = force, stamp_ns, instant_ns
        estimate = self._estimate = self._estimate_of(stamp_ns, assessment)
        return estimate

    def _estimate_of(self, stamp_ns: int, assessment: Assessment) -> Estimate:
        *known, status = assessment
        return _TUPLE(Estimate, (  # past the many arguments of its __new__, at every sample
            stamp_ns, self._force, self._force_variance, *known, _STATUS[status], *self._behind,
        ))  # fmt: skip
