# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Live estimator in the paper's formulation, eqs. (14) to (17) corrected: force rate in, deflection measured.

`force` is the more accurate formulation. Here Coulomb friction disturbs the force rate at each reversal; the noise of
the rate includes the disturbance, and `reason` names it where it dominates.
"""

import math

import numpy as np
from vsa_common.types import Array, Integers, ResetReason
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.records import Record
from vsa_estimator.force_rate.ekf import SIZE, ForceRateFilter, OffsetFilter, R
from vsa_estimator.force_rate.rate_filter import RateFilter
from vsa_estimator.force_rate.rate_noise import RateNoise
from vsa_estimator.force_rate.report import Snapshot, estimate_at, state_of
from vsa_estimator.output.estimate import Estimate, State, empty_rows, row_of
from vsa_estimator.preprocessing.decimator import Decimated, add_sample, finished_blocks, initial_decimator
from vsa_estimator.preprocessing.validation import DROP, TIME_RESET, initial_validation, validate
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.filter import NIS_CAP, NIS_THRESHOLD, NIS_WINDOW
from vsa_estimator.tuning.force_rate import (
    JERK_BANDWIDTH,
    OFFSET_PERIOD,
    REVERSAL_SPEED,
    START_STDS,
)
from vsa_estimator.tuning.supervisor import COUNTED_GAP, REFRESH_PERIOD


class ForceRateEstimator:
    """The live estimator of one transmission, formulation `force_rate`."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Without samples; every method has the signature of `Estimator`."""
        self.config = config
        self._validation = initial_validation(config.force_limit, config.deflection_limit)
        self._dropped = 0
        self._reset_count, self._reset_reason = 0, ResetReason.NONE
        self._fused = self._stamp_ns = 0
        self._restart()

    def _restart(self) -> None:
        initial = self.config.initial
        self._filter: ForceRateFilter | None = None  # from the first sample on
        self._offsets = OffsetFilter(
            initial.force_offset, initial.force_offset_std, initial.coulomb_friction, initial.coulomb_friction_std
        )
        self._rate = RateFilter()
        self._rate_noise = RateNoise(self.config.force_noise_std)
        self._jerk = JerkDensity()
        self._decimator = initial_decimator(self.config.filter_rate)
        self._stamp_ns = 0
        self._step_ns = self._refreshed_ns = self._offset_ns = 0
        self._force = self._reference = self._innovation = 0.0
        self._innovation_variance = 1.0
        self._nis_mean = 1.0

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Estimate at a sample of transmission force [N] and deflection [m]; None for a sample that is dropped."""
        action = validate(self._validation[0], stamp_ns, force, deflection)
        if action == DROP:
            self._dropped += 1
            return None
        if action == TIME_RESET:
            self.reset(ResetReason.TIME_JUMP)
            return self.add(stamp_ns, force, deflection)
        if self._filter is not None and stamp_ns - self._stamp_ns > COUNTED_GAP * 1e9:
            self.reset(ResetReason.GAP)
        if self._filter is None:
            self._filter = self._initial_filter(force, deflection)
            self._reference = deflection
            self._step_ns = self._refreshed_ns = self._offset_ns = stamp_ns
        decimator = self._decimator[0]
        finished = add_sample(decimator, stamp_ns, deflection, force, True, True)
        for block in finished_blocks(decimator, finished):
            self._step(self._filter, block)
        self._fused += 1
        self._force, self._stamp_ns = force, stamp_ns
        return estimate_at(self._snapshot(), stamp_ns)

    def add_many(self, stamp_ns: Integers, force: Array, deflection: Array) -> Record:
        """`add` each sample of arrays (n,): (n,) ROW, NaN for dropped samples."""
        rows = empty_rows(len(stamp_ns))
        samples = zip(stamp_ns.tolist(), force.tolist(), deflection.tolist(), strict=True)
        for i, sample in enumerate(samples):
            rows[i] = row_of(self.add(*sample))
        return rows

    def count_lost(self, lost: int) -> None:
        """Ignored: this formulation uses the stamps as they are."""

    def finish_pending(self) -> bool:
        """False: no work is deferred."""
        return False

    def predict_to(self, stamp_ns: int) -> Estimate | None:
        """The last estimate at `stamp_ns`, stale and then invalid; None before the first sample."""
        if self._filter is None or stamp_ns <= self._stamp_ns:
            return None
        return estimate_at(self._snapshot(), stamp_ns)

    def reset(self, reason: ResetReason = ResetReason.REQUESTED) -> None:
        """Drop all state but the counters."""
        self._restart()
        self._reset_count += 1
        self._reset_reason = reason

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Apply the tunable parameters of another configuration; the estimate stays."""
        limits = initial_validation(config.force_limit, config.deflection_limit)
        for field in ("max_force", "max_deflection"):
            self._validation[field] = limits[field]
        if config.force_noise_std != self.config.force_noise_std:
            self._rate_noise = RateNoise(config.force_noise_std)
        self.config = config

    def state(self) -> State:
        """State with coefficients, validity and diagnostics."""
        snapshot = self._snapshot()
        estimate = estimate_at(snapshot, self._stamp_ns) if self._filter is not None else None
        nis, rejected = (self._filter.nis, self._filter.rejected) if self._filter is not None else (0.0, [0, 0])
        diagnostics = {
            "force_innovation": self._innovation,
            "force_innovation_variance": self._innovation_variance,
            "deflection_innovation": 0.0,
            "deflection_innovation_variance": self._deflection_std(1) ** 2,
            "normalised_innovation_squared": nis,
            "force_noise_std": self.config.force_noise_std,
            "deflection_noise_std": self._deflection_std(1),
            "jerk_density": self._jerk.density,
            "samples_fused": self._fused,
            "samples_dropped": self._dropped,
            "force_rejected": rejected[1],
            "deflection_rejected": rejected[0],
            "force_repeated": 0,
        }
        return state_of(snapshot, estimate, diagnostics)

    def _initial_filter(self, force: float, deflection: float) -> ForceRateFilter:
        """The filter at the first sample [N, m]: stiffness by the elastic force, the rest as configured."""
        initial = self.config.initial
        elastic = max(force - initial.force_offset, 0.2 * initial.force_offset_std, 1e-2)
        sigma = initial.k2 * elastic
        relative_std = math.hypot(initial.force_offset_std / elastic, initial.k2_std / initial.k2)
        z, std = np.zeros(SIZE), np.ones(SIZE)
        z[[R.X, R.SIGMA, R.D, R.M, R.K2, R.D2]] = deflection, sigma, initial.d1, initial.inertia, initial.k2, initial.d2
        std[R.X] = self._deflection_std(1)
        std[R.V : R.SIGMA] = START_STDS
        std[R.SIGMA :] = (
            min(relative_std, 1.0) * sigma, initial.d1_std, initial.inertia_std, initial.k2_std, initial.d2_std,
        )  # fmt: skip
        return ForceRateFilter(z, std)

    def _step(self, kalman: ForceRateFilter, block: Decimated) -> None:
        """One step of all filters."""
        dt = (block.stamp_ns - self._step_ns) * 1e-9
        self._step_ns = block.stamp_ns
        rate = self._rate.add(block.force, dt)
        deflection_std = self._deflection_std(block.samples)
        if dt > 0.0:
            self._jerk.add(block.deflection, deflection_std**2, dt)
            density = self._jerk.density
            bandwidth = min((density / (deflection_std**2 * dt)) ** (1.0 / 6.0), JERK_BANDWIDTH)
            kalman.advance(dt, density * bandwidth**2)
        self._innovation = rate - float(kalman.x[R.RATE, 0])
        self._rate_noise.update(block.stamp_ns, float(kalman.state[R.V]))
        rate_std = self._rate_noise.std(block.stamp_ns, block.samples, self._friction)
        self._innovation_variance = float(kalman.P[R.RATE, R.RATE]) + rate_std**2
        kalman.correct(block.deflection, rate, deflection_std, rate_std)
        self._nis_mean += (min(kalman.nis, NIS_CAP) - self._nis_mean) * min(dt / NIS_WINDOW, 1.0)
        if block.stamp_ns - self._refreshed_ns >= REFRESH_PERIOD * 1e9:
            self._refreshed_ns = block.stamp_ns
            self._jerk.refresh()
        self._update_offset(kalman, block)

    def _update_offset(self, kalman: ForceRateFilter, block: Decimated) -> None:
        """Update the slower, parallel filter of section V-A."""
        z, p = kalman.state, kalman.covariance
        elapsed = (block.stamp_ns - self._offset_ns) * 1e-9
        if elapsed < OFFSET_PERIOD or abs(z[R.V]) < REVERSAL_SPEED:
            return
        self._offset_ns = block.stamp_ns
        v, a, sigma, damping, mass, k2, d2 = z[[R.V, R.A, R.SIGMA, R.D, R.M, R.K2, R.D2]]
        impedance = sigma / k2 + damping * v - 2.0 * d2 * v**3 + mass * a  # force without offset and friction [N]
        by = np.zeros(SIZE)
        by[[R.V, R.A, R.SIGMA, R.D, R.M, R.K2, R.D2]] = (
            damping - 6.0 * d2 * v**2, mass, 1.0 / k2, v, a, -sigma / k2**2, -2.0 * v**3,
        )  # fmt: skip
        variance = self.config.force_noise_std**2 + float(by @ p @ by)
        # Errors of the impedance force are correlated over time: the variance must not decrease by averaging.
        self._offsets.add(block.force - impedance, math.copysign(1.0, v), variance / OFFSET_PERIOD, elapsed)

    def _snapshot(self) -> Snapshot:
        if self._filter is None:
            z, p = np.where(np.arange(SIZE) == R.K2, self.config.initial.k2, 1e-9), np.eye(SIZE)
        else:
            z, p = self._filter.state, self._filter.covariance
        return Snapshot(
            stamp_ns=self._stamp_ns,
            force=self._force,
            force_variance=self.config.force_noise_std**2,
            state=z,
            covariance=p,
            reference=self._reference,
            offset=self._offsets.offset,
            friction=self._offsets.friction,
            offset_covariance=self._offsets.covariance,
            explained=self._explained,
            friction_dominant=self._rate_noise.is_friction_dominant(self._friction),
            reason=self._reason(),
            reset_count=self._reset_count,
            reset_reason=self._reset_reason,
        )

    def _reason(self) -> str:
        """Why the estimate is degraded; empty if it is not."""
        if self._rate_noise.is_friction_dominant(self._friction):
            return (
                f"Coulomb friction of {self._friction:.2f} N disturbs the force rate at each reversal; "
                "use formulation force"
            )
        return "" if self._explained else "the model does not explain the force rate; use formulation force"

    @property
    def _friction(self) -> float:
        """Coulomb friction as estimated [N], at least as configured: otherwise a reversal biases the damping."""
        return max(self._offsets.friction, self.config.initial.coulomb_friction)

    @property
    def _explained(self) -> bool:
        return self._nis_mean < NIS_THRESHOLD and self._offsets.nis_mean < NIS_THRESHOLD

    def _deflection_std(self, samples: int) -> float:
        return self.config.deflection_std / math.sqrt(samples)
