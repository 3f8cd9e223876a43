"""Learns start values from the moving part of the last seconds, a slice of work at a time."""

import numpy as np
from vsa_common.types import Array
from vsa_estimator.initialization.regression import Fit, Regression
from vsa_estimator.initialization.windows import Rows, Slices, smooth
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import MIN_STROKE

KEPT = 40.0  # moving data remembered [s]
LEAST_TIME = 1.0  # no attempt before [s]
LEAST_SAMPLES = 40
SLICE_RATE = 300.0  # [1/s]: evenly until the next refresh, so that no samples wait for a burst
MOST_SLICES = 10.0  # at once
SURE_DAMPING = 0.1  # relative standard deviation of d1: one sweep of the stroke does not part damper and spring


class Initializer:
    """Buffer of moving data and the regression over it."""

    def __init__(self, initial: Initial, rate: float) -> None:
        """`rate` of the filter [Hz]."""
        self._regression = Regression(initial)
        self._buffer = np.zeros((int(KEPT * rate), 3))
        self._count = 0
        self._work: Slices[Fit | None] | None = None
        self._audit = False
        self._before: Fit | None = None
        self._confident = False  # of the last fit
        self._due = 0.0
        self._range = (0.0, 0.0)
        self._greatest_force = 0.0
        self._duration = 0.0

    def clear(self) -> None:
        """Forget all data."""
        self._count = 0
        self._work = None
        self._before = None
        self._confident = False

    def add(self, time: float, deflection: float, force: float) -> None:
        """Take a sample of a stretch that moves [s, m, N]."""
        self._buffer[self._count % len(self._buffer)] = time, deflection, force
        self._count += 1

    def begin(
        self,
        period: float,
        reference: float,
        force_noise_std: float,
        deflection_noise_std: float,
        jerk_density: float,
        audit: bool,
    ) -> None:
        """Start on what has been collected, unless an earlier start is still at work.

        An `audit` is to find fault with what is known: it takes no rows that smoothing has bent.
        """
        if self._work is not None or self._count < LEAST_SAMPLES:
            return
        time, deflection, force = self._ordered()
        period = max(period, float(np.median(np.diff(time))))  # blocks hold whole samples, so that they may take longer
        self._range = float(deflection.max()), float(deflection.min())
        self._greatest_force = float(force.max())
        self._duration = time.size * period
        self._audit = audit
        self._work = self._slices(
            smooth(time, deflection, force, period, deflection_noise_std, force_noise_std, jerk_density),
            reference, force_noise_std, deflection_noise_std, audit,
        )  # fmt: skip

    @property
    def is_running(self) -> bool:
        """Whether a start is at work."""
        return self._work is not None

    def advance(self, period: float) -> Fit | None:
        """As many slices as are due `period` [s] after the last call; the fit where one was the last."""
        if self._work is None:
            return None
        self._due = min(self._due + SLICE_RATE * period, MOST_SLICES)
        try:
            while self._due >= 1.0:
                self._due -= 1.0
                next(self._work)
        except StopIteration as finished:
            self._work = None
            fit: Fit | None = finished.value
            if fit is not None and not self._audit:
                fit = self._before = fit.after(self._before)
            return fit
        return None

    def _slices(
        self, smoothing: Slices[Rows | None], reference: float, force_std: float, deflection_std: float, audit: bool
    ) -> Slices[Fit | None]:
        rows = yield from smoothing
        if rows is None:
            return None
        rows = rows.part(rows.described) if audit else rows
        return (yield from self._regression.work(rows, reference, force_std, deflection_std))

    def ready_to_hand_over(self, fit: Fit, force_noise_std: float) -> bool:
        """Whether a filter that starts from this fit errs less by its linearisation than by noise.

        And could so half a second ago: a fit that is sure for once is not. An audit stands by itself. To be asked of
        each fit, once.
        """
        bent = fit.stroke * fit.mean[1]
        elastic = max(self._greatest_force - fit.mean[5], 1.0)
        error = (fit.ln_k2_std * bent) ** 2 / 8.0 * elastic
        tolerated = 0.06 * force_noise_std * max(1.0, self._duration / 20.0) ** 2
        known = fit.ln_k2_std < 0.1 and fit.covariance[0, 0] < 0.01
        known &= fit.covariance[2, 2] < (SURE_DAMPING * fit.mean[2]) ** 2
        enough = bool(error < tolerated and known and bent > MIN_STROKE)
        confirmed, self._confident = self._confident or self._audit, enough
        return enough and confirmed

    @property
    def range(self) -> tuple[float, float]:
        """Greatest and least deflection of the data learnt from [m]."""
        return self._range

    def _ordered(self) -> tuple[Array, Array, Array]:
        size = len(self._buffer)
        if self._count <= size:
            data = self._buffer[: self._count].copy()
        else:
            data = np.roll(self._buffer, -(self._count % size), axis=0)
        return data[:, 0], data[:, 1], data[:, 2]
