# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of one transmission from its force and deflection, sample by sample.

A sample passes preprocessing, filter and output. Live and replayed samples pass the same code: the same samples give
the same estimates to the bit. No clock is read, and long computations are divided into parts counted in samples.
"""

import math

import numpy as np
from vsa_common.types import Array, Integers, ResetReason, Status
from vsa_estimator.bank_state import published_coefficients, with_choice
from vsa_estimator.fault_detection.latch import FaultLatch
from vsa_estimator.filter.records import Record
from vsa_estimator.initialization.previous_run import coefficients_of
from vsa_estimator.modes import Mode
from vsa_estimator.output.estimate import Estimate, State, empty_rows, row_of
from vsa_estimator.output.predictor import (
    ALIVE,
    FAST_PATH,
    Condition,
    Outcome,
    Predicted,
    predict,
    process_sample,
    process_samples,
)  # fmt: skip
from vsa_estimator.output.records import SNAPSHOT
from vsa_estimator.output.state import Diagnostics, state_of
from vsa_estimator.precompile import precompile
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.preprocessing.pipeline import Pipeline
from vsa_estimator.preprocessing.sensor_flags import SensorFlag
from vsa_estimator.preprocessing.validation import DROP, TIME_RESET
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.supervisor import Supervisor
from vsa_estimator.tuning.output import INVALID_TIME, STALE_PERIODS, STALE_TIME

Sample = tuple[int, float, float]  # stamp [ns], force [N], deflection [m]

_TUPLE = tuple.__new__
_STATUS = tuple(Status)
_ENCODER_FAULT, _TIMING_SUSPECT = SensorFlag.ENCODER_FAULT.value, SensorFlag.TIMING_SUSPECT.value
_FORCE_OUTLIER, _DEFLECTION_OUTLIER = SensorFlag.FORCE_OUTLIER.value, SensorFlag.DEFLECTION_OUTLIER.value


class Estimator:
    """The live estimator of one transmission, formulation `force`."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Compile everything first, so that no sample waits for the compiler."""
        self.config = config
        self._pipeline = Pipeline(config)
        self._latch = FaultLatch()
        self._supervisor = Supervisor(config, self._pipeline, self._latch)
        self._dropped = self._fused = 0
        self._estimate: Estimate | None
        self._pending: list[Decimated] | None  # finished blocks without their filter step
        self._snapshot: Record
        self._begin()
        precompile(with_bank=config.elastic_law == "automatic")

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Estimate at a sample of rod force [N] and deflection [m]; None for a dropped sample, which is counted.

        Where samples are decimated, the filter step that is due is made later: by `finish_pending`, or before the
        next sample.
        """
        self._finish_all_pending()
        outcome, predicted = process_sample(
            self._pipeline.state, self._supervisor.tracker.state, self._snapshot, stamp_ns, force, deflection
        )
        result, _, instant_ns, _ = outcome
        if result != FAST_PATH:
            return self._handle(outcome, (stamp_ns, force, deflection))
        self._supervisor.set_encoder_fault(False)
        return self._accept(stamp_ns, instant_ns, force, predicted)

    def add_many(self, stamp_ns: Integers, force: Array, deflection: Array) -> Record:
        """`add` each sample of arrays (n,): (n,) ROW, NaN for dropped samples; the same values to the bit."""
        rows, first, last = empty_rows(len(stamp_ns)), 0, len(stamp_ns) - 1
        while first <= last:
            self._finish_all_pending()
            part = slice(first, last)  # the last sample by `add`, which leaves the state as `add` does
            count, outcome = process_samples(
                rows[part], self._pipeline.state, self._supervisor.tracker.state, self._snapshot,
                stamp_ns[part], force[part], deflection[part],
            )  # fmt: skip
            at = first + count
            if count:
                self._fused += count
                self._force = float(force[at - 1])
            sample = int(stamp_ns[at]), float(force[at]), float(deflection[at])
            fast = outcome[0] == FAST_PATH
            estimate = self.add(*sample) if fast else self._handle(outcome, sample)
            rows[at] = row_of(estimate)
            first = at + 1
        return rows

    def count_lost(self, lost: int) -> None:
        """The driver counts the samples that are lost: `lost` since the last sample."""
        self._pipeline.count_lost(lost)

    def finish_pending(self) -> bool:
        """Do one part of the deferred work of the last sample, steps or initialization; whether there was any."""
        if self._pending is None:
            return False
        supervisor = self._supervisor
        blocks, self._pending = self._pending, None
        if blocks and supervisor.has_deferred_work:
            self._pending = []
        for block in blocks:
            supervisor.step(block, self._force)
        if not blocks:
            supervisor.run_initialization()
        if blocks or not supervisor.has_deferred_work:
            self._publish_snapshot()
        return True

    def predict_to(self, stamp_ns: int) -> Estimate | None:
        """Estimate at an instant [ns] without a sample; STALE after a silence. None before the first sample."""
        last = self._estimate
        if last is None or stamp_ns <= self._stamp_ns:
            return None
        self._finish_all_pending()
        silence = (stamp_ns - self._stamp_ns) * 1e-9
        condition = Condition.SENSORS_ALIVE if silence < INVALID_TIME else Condition(0)
        if self._supervisor.encoder_fault:
            condition |= Condition.ENCODER_FAULT
        if silence >= max(STALE_PERIODS * self._pipeline.period_ns * 1e-9, STALE_TIME):
            condition |= Condition.STALE
        instant_ns = self._instant_ns + stamp_ns - self._stamp_ns
        now = self._estimate_of(stamp_ns, predict(
            self._supervisor.tracker.state, self._snapshot, stamp_ns, instant_ns, math.nan, int(condition)
        ))  # fmt: skip
        growth = max(1.0, last.stiffness / max(now.stiffness, 1e-9))  # the variance grows also for a slackening spring
        return now._replace(stiffness_variance=now.stiffness_variance * growth * growth)

    def reset(self, reason: ResetReason = ResetReason.REQUESTED) -> None:
        """Drop all state but the counters."""
        self._latch.clear()
        self._begin()
        self._supervisor.counters.count_reset(reason)

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Apply the tunable parameters of another configuration; the estimate stays. Raises ConfigurationError."""
        coefficients_of(config.initial)  # of the next reset
        self._finish_all_pending()
        self.config = config
        self._pipeline.reconfigure(config)
        self._supervisor.reconfigure(config)
        if self._estimate is not None:
            self._publish_snapshot()

    def state(self) -> State:
        """State after the last sample, with all deferred work done."""
        self._finish_all_pending()
        supervisor = self._supervisor
        supervisor.tracker.update_uncertainty()
        faults = self._latch.active_faults(self._stamp_ns)
        state = state_of(supervisor.tracker, self._estimate, Diagnostics(
            stamp_ns=self._stamp_ns, mode=supervisor.modes.mode,
            faults=tuple(text for text in (*faults, supervisor.modes.reason, supervisor.adequacy.describe()) if text),
            reset_count=supervisor.counters.resets,
            reset_reason=supervisor.counters.reset_reason,
            sensor_fault=self._stamp_ns < self._latch.sensor_fault_until_ns,
            force_noise_std=supervisor.noise.force.std,
            deflection_noise_std=supervisor.noise.deflection.std,
            jerk_density=supervisor.noise.jerk.density,
            samples_fused=self._fused,
            samples_dropped=self._dropped,
            force_rejected=supervisor.counters.force_rejected,
            deflection_rejected=supervisor.counters.deflection_rejected,
            force_repeated=self._latch.force_repeated,
        ))  # fmt: skip
        return with_choice(state, supervisor.laws)

    def _begin(self) -> None:
        self._previous = coefficients_of(self.config.initial)
        self._pipeline.reset()
        self._supervisor.reset()
        self._estimate = self._pending = None
        self._stamp_ns, self._instant_ns, self._force = 0, 0, 0.0
        self._snapshot = np.zeros(1, SNAPSHOT)

    def _finish_all_pending(self) -> None:
        while self._pending is not None:
            self.finish_pending()

    def _handle(self, outcome: Outcome, sample: Sample) -> Estimate | None:
        """Do what a sample outside the fast path requires: drop, reset, start, flags, filter steps, initialization."""
        result, flags, instant_ns, finished = outcome
        stamp_ns, force, deflection = sample
        if result == DROP:
            self._dropped += 1
            return None
        if result == TIME_RESET:
            self.reset(ResetReason.TIME_JUMP)
            return self.add(*sample)
        supervisor = self._supervisor
        supervisor.set_encoder_fault(flags & _ENCODER_FAULT > 0)
        if supervisor.modes.mode is Mode.WAITING:
            supervisor.start(instant_ns, force, deflection, self._previous)
        if flags:
            self._handle_flags(flags, stamp_ns, instant_ns)
        blocks, decimating = self._pipeline.finished(finished), self._pipeline.is_decimating
        if not decimating:
            for block in blocks:
                supervisor.step(block, self._force)
            if supervisor.has_deferred_work:
                supervisor.run_initialization()
        elif blocks or supervisor.has_deferred_work:
            self._pending = blocks
        if flags or not decimating:
            self._publish_snapshot()
        usable = math.nan if flags & _DEFLECTION_OUTLIER else deflection
        condition = ALIVE | (int(Condition.ENCODER_FAULT) if supervisor.encoder_fault else 0)
        return self._accept(stamp_ns, instant_ns, force, predict(
            supervisor.tracker.state, self._snapshot, stamp_ns, instant_ns, usable, condition
        ))  # fmt: skip

    def _handle_flags(self, flags: int, stamp_ns: int, instant_ns: int) -> None:
        if flags & _TIMING_SUSPECT:
            self._supervisor.mark_timing_suspect(instant_ns)
        self._latch.add_flags(flags, stamp_ns)
        self._supervisor.counters.count_rejected(flags & _FORCE_OUTLIER > 0, flags & _DEFLECTION_OUTLIER > 0)

    def _publish_snapshot(self) -> None:
        """Update what the estimates are predicted from until the next step."""
        supervisor, tracker, laws = self._supervisor, self._supervisor.tracker, self._supervisor.laws
        tracker.update_uncertainty()
        self._force_variance = supervisor.noise.force.std**2
        self._constants = *supervisor.counters.last_reset, *published_coefficients(tracker, laws)
        self._snapshot["published"][0] = (
            not supervisor.has_deferred_work, tracker.reference, supervisor.noise.jerk.density,
            supervisor.noise.deflection.std**2, *supervisor.conditions,
            supervisor.step_ns, self._latch.until_ns, self._latch.sensor_fault_until_ns,
            laws.publishes_bank, laws.published_impedance[0], *laws.discrepancies, *self._constants,
        )  # fmt: skip

    def _accept(self, stamp_ns: int, instant_ns: int, force: float, predicted: Predicted) -> Estimate:
        self._fused += 1
        self._force, self._stamp_ns, self._instant_ns = force, stamp_ns, instant_ns
        estimate = self._estimate = self._estimate_of(stamp_ns, predicted)
        return estimate

    def _estimate_of(self, stamp_ns: int, predicted: Predicted) -> Estimate:
        *values, status = predicted
        return _TUPLE(Estimate, (  # without the 34 arguments of Estimate.__new__, for every sample
            stamp_ns, self._force, self._force_variance, *values, _STATUS[status], *self._constants,
        ))  # fmt: skip
