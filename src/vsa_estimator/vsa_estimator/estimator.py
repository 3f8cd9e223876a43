"""Impedance of one transmission from its force and deflection, sample by sample.

Live and replayed samples take the same way: intake -> block average -> filter -> report. The same samples give the
same estimates to the bit: nothing here asks a clock, and long computations are cut into slices counted in steps.
"""

import math

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array, ResetReason, Status
from vsa_estimator.fault_detection.latch import FaultLatch
from vsa_estimator.modes import Mode
from vsa_estimator.output.estimate import Estimate, State, no_rows, row_of
from vsa_estimator.output.predictor import (
    FAST_PATH,
    HOLDS,
    REFERENCE,
    SNAPSHOT,
    Assessment,
    predict_row,
    process_sample,
    process_samples,
)
from vsa_estimator.output.validity import Observability, assess_observability, describe_unobservable
from vsa_estimator.precompile import precompile
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.preprocessing.pipeline import Pipeline
from vsa_estimator.preprocessing.sensor_flags import SensorFlag
from vsa_estimator.preprocessing.validation import DROP, TIME_RESET
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.supervisor import Supervisor

STALE_PERIODS, STALE_TIME = 5, 0.05  # silence is stale after the longer of the two [1, s]
INVALID_TIME = 0.1  # and its estimates are invalid from then on [s]
COEFFICIENTS = 6  # of an appraisal, the first ones, go with each estimate
_TUPLE = tuple.__new__
_STATUS = tuple(Status)


class Estimator:
    """The live estimator of one transmission, formulation `force`."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Compiles what has to be compiled, so that no sample waits for it."""
        self.config = config
        self._samples = Pipeline(config)
        self._health = FaultLatch()
        self._supervisor = Supervisor(config, self._samples, self._health)
        self._dropped = 0
        self._fused = 0
        self._estimate: Estimate | None
        self._started: bool
        self._pending: list[Decimated] | None  # blocks that are to be taken, where a sample has left work to do
        self._snapshot: Array
        self._moments: NDArray[np.int64]
        self._begin()
        precompile()

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Estimate at a sample of rod force [N] and deflection [m]; None for one that was dropped and counted.

        Where samples are averaged, the step that is due comes later: by `finish_pending` or before the next sample.
        """
        self._finish_pending()
        samples = self._samples
        verdict, found, instant_ns, blocks, assessment = process_sample(
            samples.state, self._supervisor.tracker.state, self._snapshot, self._moments,
            stamp_ns, force, deflection,
        )  # fmt: skip
        if verdict != FAST_PATH:
            return self._handle_events(verdict, found, instant_ns, blocks, stamp_ns, force, deflection)
        self._supervisor.encoder_fault = False
        return self._report(stamp_ns, instant_ns, force, assessment)

    def add_many(self, stamp_ns: NDArray[np.int64], force: Array, deflection: Array) -> Array:
        """`add` of samples in arrays: a row with the fields of an Estimate from force_valid on for each, NaN for none.

        To the bit what `add` says of each of them.
        """
        samples, end = self._samples, len(stamp_ns) - 1
        rows = no_rows(len(stamp_ns))
        first = 0
        while first <= end:  # the last one by itself: it leaves all as `add` does
            self._finish_pending()
            until, verdict, found, instant_ns, blocks = process_samples(
                rows, samples.state, self._supervisor.tracker.state, self._snapshot, self._moments,
                stamp_ns, force, deflection, first, end,
            )  # fmt: skip
            if until > first:
                self._fused += until - first
                self._force = float(force[until - 1])
            one = int(stamp_ns[until]), float(force[until]), float(deflection[until])
            if verdict == FAST_PATH:
                estimate = self.add(*one)
            else:
                estimate = self._handle_events(verdict, found, instant_ns, blocks, *one)
            rows[until] = row_of(estimate)
            first = until + 1
        return rows

    def finish_pending(self) -> bool:
        """Do one thing that the last sample has left to do, steps or a slice of learning; whether there was any."""
        if self._pending is None:
            return False
        supervisor = self._supervisor
        blocks, self._pending = self._pending, None
        if blocks and supervisor.initializer.is_running:
            self._pending = []
        for block in blocks:
            supervisor.step(block, self._force)
        if not blocks:
            supervisor.run_initialization()
        if blocks or not supervisor.initializer.is_running:
            self._publish_snapshot()
        return True

    def _finish_pending(self) -> None:
        while self.finish_pending():
            pass

    def predict_to(self, stamp_ns: int) -> Estimate | None:
        """Estimate at an instant [ns] without a sample; STALE when silence lasts. None before the first sample."""
        last = self._estimate
        if last is None or stamp_ns <= self._stamp_ns:
            return None
        self._finish_pending()
        silence = (stamp_ns - self._stamp_ns) * 1e-9
        stale = silence >= max(STALE_PERIODS * self._samples.period_ns * 1e-9, STALE_TIME)
        supervisor = self._supervisor
        now = self._estimate_of(stamp_ns, predict_row(
            supervisor.tracker.state, self._snapshot, self._moments, stamp_ns,
            self._instant_ns + stamp_ns - self._stamp_ns, math.nan, silence < INVALID_TIME, supervisor.encoder_fault,
            stale,
        ))  # fmt: skip
        shrunk = max(1.0, last.stiffness / max(now.stiffness, 1e-9))  # its variance grows, even where a spring slackens
        return now._replace(stiffness_variance=now.stiffness_variance * shrunk * shrunk)

    def reset(self, reason: ResetReason = ResetReason.REQUESTED) -> None:
        """Forget everything but the counters."""
        self._health.clear()
        self._begin()
        self._supervisor.count_reset(reason)

    def state(self) -> State:
        """What the estimator knows now."""
        self._finish_pending()
        supervisor, tracker, estimate = self._supervisor, self._supervisor.tracker, self._estimate
        tracker.update_uncertainty()
        known = assess_observability(tracker, supervisor.force_noise.std) if estimate else Observability(*[False] * 7)
        if estimate is None:
            status, stiffness_valid, damping_valid, moving = Status.INITIALIZING, False, False, False
        else:
            status, moving = estimate.status, estimate.velocity_valid
            stiffness_valid, damping_valid = estimate.stiffness_valid, estimate.damping_valid
        z, p = tracker.z.tolist(), tracker.covariance
        variance = np.diag(p).tolist()
        complaints = filter(None, [*self._health.active_faults(self._stamp_ns), supervisor.modes.reason])
        lines = describe_unobservable(tracker, known, stiffness_valid, damping_valid)
        reason = "; ".join(complaints) or ("" if stiffness_valid else lines[0])
        if status is Status.INITIALIZING:
            reason = "no sample yet"
        return State(
            self._stamp_ns, status, reason, supervisor.reset_count, supervisor.reset_reason,
            z[0], variance[0], moving, z[1], variance[1], moving, z[2], variance[2], moving,
            tracker.reference, z[3], variance[3], known.stiffness,
            z[4], tracker.uncertainty.k2_variance, known.k2,
            z[5], variance[5], known.d1,
            z[6], tracker.uncertainty.d2_variance, known.d2,
            z[7], tracker.uncertainty.inertia_variance, known.inertia,
            z[8], variance[8], known.force_offset,
            z[9], variance[9], known.coulomb_friction,
            tuple(p[3:, 3:].ravel().tolist()), lines,
            float(tracker.force_monitor["innovation"][0]), float(tracker.force_monitor["variance"][0]),
            float(tracker.deflection_monitor["innovation"][0]), float(tracker.deflection_monitor["variance"][0]),
            float(tracker.force_monitor["nis"][0]),
            supervisor.force_noise.std, supervisor.deflection_noise.std, supervisor.jerk.density,
            self._fused, self._dropped, supervisor.force_rejected, supervisor.deflection_rejected,
            self._health.force_repeated,
        )  # fmt: skip

    def _begin(self) -> None:
        self._samples.reset()
        self._supervisor.reset()
        self._estimate = None
        self._pending = None
        self._started = False
        self._stamp_ns = self._instant_ns = 0
        self._force = 0.0
        self._snapshot, self._moments = np.zeros(SNAPSHOT), np.zeros(2, dtype=np.int64)

    def _handle_events(
        self, verdict: int, found: int, instant_ns: int, blocks: int, stamp_ns: int, force: float, deflection: float
    ) -> Estimate | None:
        """What a sample makes one do: drop it, start, hear signs of trouble, take steps, learn."""
        if verdict == DROP:
            self._dropped += 1
            return None
        if verdict == TIME_RESET:
            self.reset(ResetReason.TIME_JUMP)
            return self.add(stamp_ns, force, deflection)
        supervisor = self._supervisor
        supervisor.encoder_fault = found & SensorFlag.ENCODER_FAULT.value > 0
        if not self._started:
            supervisor.start(instant_ns, force, deflection)
            self._started = True
        if found:
            if found & SensorFlag.TIMING_SUSPECT.value:
                supervisor.mark_timing_suspect(instant_ns)
            self._health.add_flags(found, stamp_ns)
            supervisor.force_rejected += found & SensorFlag.FORCE_OUTLIER.value > 0
            supervisor.deflection_rejected += found & SensorFlag.DEFLECTION_OUTLIER.value > 0
        finished, averaged = self._samples.finished(blocks), self._samples.is_decimating
        if not averaged:
            for block in finished:
                supervisor.step(block, self._force)
            if supervisor.initializer.is_running:
                supervisor.run_initialization()
        elif finished or supervisor.initializer.is_running:
            self._pending = finished
        if found or not averaged:
            self._publish_snapshot()
        if found & SensorFlag.DEFLECTION_OUTLIER.value:
            deflection = math.nan
        return self._report(stamp_ns, instant_ns, force, predict_row(
            supervisor.tracker.state, self._snapshot, self._moments, stamp_ns, instant_ns, deflection,
            True, supervisor.encoder_fault, False,
        ))  # fmt: skip

    def _publish_snapshot(self) -> None:
        """What holds until the next sample that is to be heeded."""
        supervisor, tracker = self._supervisor, self._supervisor.tracker
        tracker.update_uncertainty()
        self._force_variance = supervisor.force_noise.std**2
        self._behind = supervisor.reset_count, supervisor.reset_reason, *tracker.uncertainty[:COEFFICIENTS]
        self._moments[:] = supervisor.step_ns, self._health.until_ns
        self._snapshot[HOLDS] = not supervisor.initializer.is_running
        self._snapshot[REFERENCE:] = (
            tracker.reference, supervisor.jerk.density, supervisor.deflection_noise.std**2,
            supervisor.mode is Mode.SUSPENDED, supervisor.mode.initialized, supervisor.inertia_observable,
            *self._behind,
        )  # fmt: skip

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
