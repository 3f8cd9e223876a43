"""The paper's formulation, live: eqs. (14) to (17) corrected. Force rate in, deflection measured.

It is offered because the paper is the suite's mission; `force` is the better estimator. Coulomb friction does not drop
out of the force rate, as section V has it: each reversal is a step of 2 d0 in the force, a kick of 2 d0 / tau in the
filtered rate. The kick is allowed for in the noise, and named in `reason` where it drowns the rest.
"""

import math

import numpy as np
from vsa_common.types import Array, Integers, ResetReason, Status
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.records import Record
from vsa_estimator.force_rate.ekf import SIZE, ForceRateFilter, OffsetFilter, R
from vsa_estimator.force_rate.rate_filter import RATE_FILTER, RateFilter
from vsa_estimator.output.estimate import Estimate, State, empty_rows, row_of
from vsa_estimator.preprocessing.decimator import Decimated, add_sample, finished_blocks, initial_decimator
from vsa_estimator.preprocessing.validation import DROP, TIME_RESET, initial_validation, validate
from vsa_estimator.settings import EstimatorConfig

START_STD = np.array([2e-3, 5e-3, 2e-2, 1.0])  # of v, a, j in SI, and of the filtered rate [N/s]
REVERSAL_SPEED = 0.3e-3  # [m/s]
OFFSET_PERIOD = 0.1  # the slower filter takes one sample in this time [s]
REFRESH = 0.5  # of the jerk density [s]
BANDWIDTH = 20.0  # jerk changes no faster than this [rad/s]
GAP = 1.0  # longer silence starts a new motion [s]
STALE, INVALID = 0.05, 0.1  # silence [s]
STIFFNESS, DAMPING, INERTIA, CUBIC, K2_KNOWN = 0.1, 0.15, 0.2, 0.25, 0.05  # greatest relative std of what is valid
SPOILT = 10.0  # a reversal's kick above this many standard deviations of the rate is named
WATCH = 200  # steps over which innovations are watched
SUSPICION = 3.0  # mean normalised innovation squared above which the filter no longer explains the rate


class ForceRateEstimator:
    """The live estimator of one transmission, formulation `force_rate`."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Ready for the first sample."""
        self.config = config
        self._validation = initial_validation(config.force_limit, config.deflection_limit)
        self._dropped = 0
        self._reset_count, self._reset_reason = 0, ResetReason.NONE
        self._fused = self._stamp_ns = 0
        self._begin()

    def add(self, stamp_ns: int, force: float, deflection: float) -> Estimate | None:
        """Estimate at a sample of rod force [N] and deflection [m]; None for one that was dropped and counted."""
        verdict = validate(self._validation[0], stamp_ns, force, deflection)
        if verdict == DROP:
            self._dropped += 1
            return None
        if verdict == TIME_RESET:
            self.reset(ResetReason.TIME_JUMP)
            return self.add(stamp_ns, force, deflection)
        if self._filter is not None and stamp_ns - self._stamp_ns > GAP * 1e9:
            self.reset(ResetReason.GAP)
        if self._filter is None:
            self._start(stamp_ns, force, deflection)
        decimator = self._decimator[0]
        finished = add_sample(decimator, stamp_ns, deflection, force, True, True)
        for block in finished_blocks(decimator, finished):
            self._step(block)
        self._fused += 1
        self._force, self._stamp_ns = force, stamp_ns
        return self._report(stamp_ns)

    def add_many(self, stamp_ns: Integers, force: Array, deflection: Array) -> Record:
        """`add` each sample of arrays (n,): (n,) ROW, NaN for dropped samples."""
        rows = empty_rows(len(stamp_ns))
        samples = zip(stamp_ns.tolist(), force.tolist(), deflection.tolist(), strict=True)
        for i, sample in enumerate(samples):
            rows[i] = row_of(self.add(*sample))
        return rows

    def finish_pending(self) -> bool:
        """Nothing is ever left to do."""
        return False

    def predict_to(self, stamp_ns: int) -> Estimate | None:
        """The last estimate, stale and then invalid; None before the first sample."""
        if self._filter is None or stamp_ns <= self._stamp_ns:
            return None
        return self._report(stamp_ns)

    def reset(self, reason: ResetReason = ResetReason.REQUESTED) -> None:
        """Forget everything but the counters."""
        self._begin()
        self._reset_count += 1
        self._reset_reason = reason

    def state(self) -> State:
        """What the estimator knows now."""
        estimate = self._report(self._stamp_ns) if self._filter is not None else None
        z, p = self._motion_and_impedance()
        c, cov = self._coefficients(z, p)
        var = np.diag(cov)
        known = [math.sqrt(v) < share * abs(x) for x, v, share in zip(
            c[1:5], var[1:5], (K2_KNOWN, DAMPING, CUBIC, INERTIA), strict=True)]  # fmt: skip
        stiffness_valid = estimate is not None and estimate.stiffness_valid
        status = Status.INITIALIZING if estimate is None else estimate.status
        reason = "no sample yet" if estimate is None else self._complaint()
        if not reason and not stiffness_valid:
            reason = "stiffness: not yet known within 10 %; move slowly over several millimetres"
        flags = (
            ("stiffness", stiffness_valid),
            ("k2", known[0]),
            ("d1", known[1]),
            ("d2", known[2]),
            ("inertia", known[3]),
        )
        lines = tuple(f"{name}: not known from this motion" for name, valid in flags if not valid)
        heard = estimate is not None
        nis, rejected = (self._filter.nis, self._filter.rejected) if self._filter is not None else (0.0, [0, 0])
        return State(
            self._stamp_ns, status, reason, self._reset_count, self._reset_reason,
            z[0], p[0, 0], heard, z[1], p[1, 1], heard, z[2], p[2, 2], heard,
            self._reference, c[0], var[0], stiffness_valid, c[1], var[1], known[0], c[2], var[2], known[1],
            c[3], var[3], known[2], c[4], var[4], known[3],
            c[5], var[5], math.sqrt(var[5]) < 1.0, c[6], var[6], math.sqrt(var[6]) < 0.2,
            tuple(cov.ravel().tolist()), lines,
            self._innovation, self._innovation_variance, 0.0, self._deflection_std(1) ** 2,
            nis, self.config.force_noise_std, self._deflection_std(1),
            self._jerk.density, self._fused, self._dropped,
            rejected[1], rejected[0], 0,
        )  # fmt: skip

    def _begin(self) -> None:
        initial = self.config.initial
        self._filter: ForceRateFilter | None = None
        self._offsets = OffsetFilter(
            initial.force_offset, initial.force_offset_std, initial.coulomb_friction, initial.coulomb_friction_std
        )
        self._rate = RateFilter()
        self._jerk = JerkDensity()
        self._decimator = initial_decimator(self.config.filter_rate)
        self._stamp_ns = 0
        self._step_ns = self._refreshed_ns = self._offset_ns = 0
        self._reversed_ns, self._direction = 0, 0.0
        self._force = self._reference = self._innovation = 0.0
        self._innovation_variance = 1.0
        self._nis_mean = 1.0

    def _start(self, stamp_ns: int, force: float, deflection: float) -> None:
        initial = self.config.initial
        elastic = max(force - initial.force_offset, 0.2 * initial.force_offset_std, 1e-2)
        sigma = initial.k2 * elastic
        share = math.hypot(initial.force_offset_std / elastic, initial.k2_std / initial.k2)
        z, std = np.zeros(SIZE), np.ones(SIZE)
        z[[R.X, R.SIGMA, R.D, R.M, R.K2, R.D2]] = deflection, sigma, initial.d1, initial.inertia, initial.k2, initial.d2
        std[R.X] = self._deflection_std(1)
        std[R.V : R.SIGMA] = START_STD
        std[R.SIGMA :] = (
            min(share, 1.0) * sigma, initial.d1_std, initial.inertia_std, initial.k2_std, initial.d2_std,
        )  # fmt: skip
        self._filter = ForceRateFilter(z, std)
        self._reference = deflection
        self._step_ns = self._refreshed_ns = self._offset_ns = stamp_ns

    def _step(self, block: Decimated) -> None:
        assert self._filter is not None
        dt = (block.stamp_ns - self._step_ns) * 1e-9
        self._step_ns = block.stamp_ns
        rate = self._rate.add(block.force, dt)
        deflection_std = self._deflection_std(block.samples)
        if dt > 0.0:
            self._jerk.add(block.deflection, deflection_std**2, dt)
            density = self._jerk.density
            bandwidth = min((density / (deflection_std**2 * dt)) ** (1.0 / 6.0), BANDWIDTH)
            self._filter.advance(dt, density * bandwidth**2)
        self._innovation = rate - float(self._filter.x[R.RATE, 0])
        rate_std = self._rate_std(block)
        self._innovation_variance = float(self._filter.P[R.RATE, R.RATE]) + rate_std**2
        self._filter.correct(block.deflection, rate, deflection_std, rate_std)
        self._nis_mean += (min(self._filter.nis, 100.0) - self._nis_mean) / WATCH
        if block.stamp_ns - self._refreshed_ns >= REFRESH * 1e9:
            self._refreshed_ns = block.stamp_ns
            self._jerk.refresh()
        self._learn_offset(block)

    def _rate_std(self, block: Decimated) -> float:
        """Noise of the filtered force rate [N/s]: the sensor's, and what is left of the last reversal's kick."""
        assert self._filter is not None
        speed = float(self._filter.state[R.V])
        direction = math.copysign(1.0, speed)
        if abs(speed) < REVERSAL_SPEED or direction != self._direction:
            self._reversed_ns, self._direction = block.stamp_ns, direction
        age = (block.stamp_ns - self._reversed_ns) * 1e-9
        kick = 2.0 * self._friction / RATE_FILTER * math.exp(-age / RATE_FILTER)
        return math.hypot(self._white_rate_std() / math.sqrt(block.samples), kick)

    def _learn_offset(self, block: Decimated) -> None:
        """The slower, parallel filter of section V-A."""
        assert self._filter is not None
        z, p = self._filter.state, self._filter.covariance
        elapsed = (block.stamp_ns - self._offset_ns) * 1e-9
        if elapsed < OFFSET_PERIOD or abs(z[R.V]) < REVERSAL_SPEED:
            return
        self._offset_ns = block.stamp_ns
        v, a, sigma, damping, mass, k2, d2 = z[[R.V, R.A, R.SIGMA, R.D, R.M, R.K2, R.D2]]
        impedance = sigma / k2 + damping * v - 2.0 * d2 * v**3 + mass * a
        by = np.zeros(SIZE)
        by[[R.V, R.A, R.SIGMA, R.D, R.M, R.K2, R.D2]] = (
            damping - 6.0 * d2 * v**2, mass, 1.0 / k2, v, a, -sigma / k2**2, -2.0 * v**3,
        )  # fmt: skip
        variance = self.config.force_noise_std**2 + float(by @ p @ by)
        # The impedance force errs for long in the same way: its error must not be averaged away.
        self._offsets.add(block.force - impedance, math.copysign(1.0, v), variance / OFFSET_PERIOD, elapsed)

    def _report(self, stamp_ns: int) -> Estimate:
        z, p = self._motion_and_impedance()
        silence = (stamp_ns - self._stamp_ns) * 1e-9
        heard = silence <= INVALID
        sigma, damping, mass, k2, d2 = z[[R.SIGMA, R.D, R.M, R.K2, R.D2]]
        std = np.sqrt(np.maximum(np.diag(p), 0.0))
        explained = self._explained
        clean = explained and not self._spoilt
        d1 = damping - 3.0 * d2 * z[R.V] ** 2
        stiffness_valid = bool(heard and explained and std[R.SIGMA] < STIFFNESS * sigma)
        damping_valid = bool(
            heard and clean and std[R.D] < DAMPING * max(abs(damping), 0.2 * d1) and damping > 0.2 * d1
        )
        inertia_valid = bool(heard and clean and std[R.M] < INERTIA * mass)
        if silence > STALE:
            status = Status.STALE
        elif not stiffness_valid:
            status = Status.CONVERGING
        else:
            status = Status.DEGRADED if self._complaint() else Status.VALID
        return Estimate(
            stamp_ns, self._force, self.config.force_noise_std**2, heard, *_triple(z, p, R.X, heard),
            *_triple(z, p, R.V, heard), *_triple(z, p, R.A, heard), *_triple(z, p, R.SIGMA, stiffness_valid),
            *_triple(z, p, R.D, damping_valid), *_triple(z, p, R.M, inertia_valid),
            float(p[R.SIGMA, R.D]), float(p[R.SIGMA, R.M]), float(p[R.D, R.M]), status, self._reset_count,
            self._reset_reason, float(k2), float(p[R.K2, R.K2]), float(d2), float(p[R.D2, R.D2]),
            self._offsets.offset, self._offsets.friction,
        )  # fmt: skip

    def _motion_and_impedance(self) -> tuple[Array, Array]:
        if self._filter is None:
            return np.where(np.arange(SIZE) == R.K2, self.config.initial.k2, 1e-9), np.eye(SIZE)
        return self._filter.state, self._filter.covariance

    def _coefficients(self, z: Array, p: Array) -> tuple[Array, Array]:
        """[ln sigma at the reference, k2, d1, d2, M, F0, d0] with covariance, SI."""
        back = self._reference - z[R.X]
        ln_sigma = math.log(max(z[R.SIGMA], 1e-9)) + z[R.K2] * back
        c = np.array([ln_sigma, z[R.K2], z[R.D] - 3.0 * z[R.D2] * z[R.V] ** 2, z[R.D2], z[R.M],
                      self._offsets.offset, self._offsets.friction])  # fmt: skip
        g = np.zeros((5, SIZE))
        g[0, [R.X, R.SIGMA, R.K2]] = -z[R.K2], 1.0 / max(z[R.SIGMA], 1e-9), back
        g[1, R.K2] = g[3, R.D2] = g[4, R.M] = 1.0
        g[2, [R.V, R.D, R.D2]] = -6.0 * z[R.D2] * z[R.V], 1.0, -3.0 * z[R.V] ** 2
        covariance = np.zeros((7, 7))
        covariance[:5, :5] = g @ p @ g.T
        covariance[5:, 5:] = self._offsets.covariance
        return c, covariance

    def _complaint(self) -> str:
        if self._spoilt:
            return (
                f"Coulomb friction of {self._friction:.2f} N kicks the force rate at each reversal; "
                "use formulation force"
            )
        return "" if self._explained else "the filter does not explain the force rate; use formulation force"

    @property
    def _friction(self) -> float:
        """As found, and no less than expected: a kick not allowed for is taken for damping, and hides the friction."""
        return max(self._offsets.friction, self.config.initial.coulomb_friction)

    @property
    def _spoilt(self) -> bool:
        return 2.0 * self._friction / RATE_FILTER > SPOILT * self._white_rate_std()

    @property
    def _explained(self) -> bool:
        return self._nis_mean < SUSPICION and self._offsets.nis_mean < SUSPICION

    def _white_rate_std(self) -> float:
        return self.config.force_noise_std / RATE_FILTER

    def _deflection_std(self, samples: int) -> float:
        return self.config.deflection_std / math.sqrt(samples)


def _triple(z: Array, p: Array, place: int, valid: bool) -> tuple[float, float, bool]:
    return float(z[place]), float(p[place, place]), valid
