# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Initializer: buffer of moving data, regressions over it in slices, and readiness for hand-over to the filter."""

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_law.state import C
from vsa_estimator.initialization.posterior import Fit, Prior
from vsa_estimator.initialization.regression import regress
from vsa_estimator.initialization.windows import Rows, Slices, smooth
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import EXCITATION_TIME_CONSTANT, MIN_STROKE
from vsa_estimator.tuning.initialization import (
    HANDOVER_STD,
    LINEARISATION_TIME,
    MAX_LINEARISATION_ERROR,
    MAX_SLICES,
    MIN_SAMPLES,
    SLICE_RATE,
)


class Initializer:
    """Buffer of moving data and the regression over it."""

    def __init__(self, initial: Initial, rate: float) -> None:
        """`rate` of the filter [Hz]."""
        self._prior = Prior.of(initial)
        # Two periods of the slowest excitation: time [s], deflection [m], force [N].
        self._buffer = np.zeros((int(2.0 * EXCITATION_TIME_CONSTANT * rate), 3))
        self._count = 0  # samples added
        self._slices: Slices[Fit | None] | None = None
        self._due_slices = 0.0
        self._is_cross_check = False
        self._previous_fit: Fit | None = None
        self._is_sufficient = False  # the last fit
        self._is_ready = False
        # Of the data of the last regression:
        self._range = (0.0, 0.0)  # [m]
        self._max_force = 0.0  # [N]
        self._duration = 0.0  # [s]

    def clear(self) -> None:
        """Discard the data and the fits."""
        self._count = 0
        self._slices = None
        self._previous_fit = None
        self._is_sufficient = self._is_ready = False

    def add(self, time: float, deflection: float, force: float) -> None:
        """Add a sample of moving data [s, m, N]."""
        self._buffer[self._count % len(self._buffer)] = time, deflection, force
        self._count += 1

    def begin(
        self,
        period: float,
        reference: float,
        force_noise_std: float,
        deflection_noise_std: float,
        jerk_density: float,
        cross_check: bool,
    ) -> None:
        """Begin a regression over the buffer, unless one is running or the samples are too few.

        A `cross_check` of a running filter excludes the rows that smoothing biases.
        """
        if self._slices is not None or self._count < MIN_SAMPLES:
            return
        time, deflection, force = self._ordered()
        period = max(period, float(np.median(np.diff(time))))  # a block can last longer
        self._range = float(deflection.max()), float(deflection.min())
        self._max_force = float(force.max())
        self._duration = time.size * period
        self._is_cross_check = cross_check
        self._slices = self._regress(
            smooth(time, deflection, force, period, deflection_noise_std, force_noise_std, jerk_density),
            reference, force_noise_std, deflection_noise_std,
        )  # fmt: skip

    def advance(self, period: float) -> Fit | None:
        """Execute the slices due `period` [s] after the last call; the fit where the regression ended."""
        if self._slices is None:
            return None
        self._due_slices = min(self._due_slices + SLICE_RATE * period, MAX_SLICES)
        try:
            while self._due_slices >= 1.0:
                self._due_slices -= 1.0
                next(self._slices)
        except StopIteration as finished:
            self._slices = None
            fit: Fit | None = finished.value
            if fit is not None and not self._is_cross_check:
                fit = self._previous_fit = fit.fuse_with_previous(self._previous_fit)
            return fit
        return None

    def evaluate(self, fit: Fit, force_noise_std: float) -> None:
        """Update the readiness for hand-over by a fit from `advance`; call once for each fit.

        It requires two successive sufficient fits; a cross-check requires one.
        """
        was_sufficient, self._is_sufficient = self._is_sufficient, self._suffices(fit, force_noise_std)
        self._is_ready = self._is_sufficient and (was_sufficient or self._is_cross_check)

    @property
    def ready_to_hand_over(self) -> bool:
        """A filter can start from the last evaluated fit."""
        return self._is_ready

    @property
    def is_running(self) -> bool:
        """A regression is running."""
        return self._slices is not None

    @property
    def range(self) -> tuple[float, float]:
        """Greatest and least deflection of the data of the last regression [m]."""
        return self._range

    def _suffices(self, fit: Fit, force_noise_std: float) -> bool:
        """The linearisation error of a filter that starts from `fit` is small beside the force noise [N]."""
        exponent = fit.stroke * fit.mean[C.K2]
        elastic = max(self._max_force - fit.mean[C.F0], 1.0)
        error = (fit.ln_k2_std * exponent) ** 2 / 8.0 * elastic
        tolerance = MAX_LINEARISATION_ERROR * force_noise_std * max(1.0, self._duration / LINEARISATION_TIME) ** 2
        return bool(
            error < tolerance
            and fit.ln_k2_std < HANDOVER_STD
            and fit.covariance[C.S, C.S] < HANDOVER_STD**2
            and fit.covariance[C.D1, C.D1] < (HANDOVER_STD * fit.mean[C.D1]) ** 2
            and exponent > MIN_STROKE
        )

    def _regress(
        self, smoothing: Slices[Rows | None], reference: float, force_noise_std: float, deflection_noise_std: float
    ) -> Slices[Fit | None]:
        rows = yield from smoothing
        if rows is None:
            return None
        rows = rows.select(rows.is_well_fitted) if self._is_cross_check else rows
        return (yield from regress(self._prior, rows, reference, force_noise_std, deflection_noise_std))

    def _ordered(self) -> tuple[Array, Array, Array]:
        """Time, deflection and force of the buffer, oldest first."""
        size = len(self._buffer)
        if self._count <= size:
            data = self._buffer[: self._count].copy()
        else:
            data = np.roll(self._buffer, -(self._count % size), axis=0)
        time, deflection, force = data.T
        return time, deflection, force
