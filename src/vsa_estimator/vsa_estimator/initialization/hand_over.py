# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""When the filter takes coefficients from a regression: until hand-over, at hand-over, and at a failed cross-check."""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.types import Array
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import C
from vsa_estimator.initialization.cross_check import CrossCheckSchedule
from vsa_estimator.initialization.posterior import Fit
from vsa_estimator.initialization.scheduler import Initializer
from vsa_estimator.modes import Event, ModeMachine
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.initialization import MIN_D1_STD, MIN_D2_STD, MIN_K2_RELATIVE_STD, MIN_LN_STIFFNESS_STD


class StepNoise(NamedTuple):
    """Noise of one filter step, and the density of the white jerk."""

    force_std: float  # [N]
    deflection_std: float  # [m]
    jerk_density: float  # [m^2/s^5]


class NewCoefficients(NamedTuple):
    """Coefficients for the filter [s k2 d1 d2 M F0 d0] (7,), their covariance (7, 7), and the event that they make."""

    mean: Array
    covariance: Array
    event: Event | None  # None: before hand-over
    stroke: tuple[float, float]  # greatest and least deflection of the data [m]


class HandOver:
    """Regressions of the recent motion, and what the filter takes from them."""

    def __init__(self, initial: Initial, rate: float) -> None:
        """`rate` of the filter [Hz]."""
        self._initializer = Initializer(initial, rate)
        self._cross_checks = CrossCheckSchedule()
        self.has_fit = False  # whether a regression has given coefficients since the last restart

    @property
    def is_running(self) -> bool:
        """Whether a regression is running."""
        return self._initializer.is_running

    def add(self, time: float, deflection: float, force: float) -> None:
        """Add a sample of moving data [s, m, N]."""
        self._initializer.add(time, deflection, force)

    def clear(self) -> None:
        """Discard the data: their position is no longer valid."""
        self._initializer.clear()

    def restart(self) -> None:
        """Discard data and fits: the coefficients are the initial ones."""
        self._initializer.clear()
        self.has_fit = False

    def is_due(self, modes: ModeMachine, now_ns: int) -> bool:
        """Whether a regression is due: before hand-over always, then for a cross-check while the mode is TRACKING."""
        return not modes.initialized or (not modes.suspended and self._cross_checks.is_due(now_ns))

    def begin(self, modes: ModeMachine, period: float, reference: float, noise: StepNoise) -> None:
        """Begin a regression of steps with this `period` [s] about a `reference` [m]."""
        self._initializer.begin(
            period, reference, noise.force_std, noise.deflection_std, noise.jerk_density, cross_check=modes.initialized
        )

    def advance(
        self, tracker: Tracker, modes: ModeMachine, now_ns: int, period: float, force_std: float, samples: int
    ) -> NewCoefficients | None:
        """Do the part of a regression that is due `period` [s] after the last call; new coefficients, or None.

        `force_std` [N] is the noise of one of the `samples` of a step. A failed cross-check keeps the filter's mean:
        the difference to the regression, which may be biased, goes into the covariance, and the next forces decide.
        """
        fit = self._initializer.advance(period)
        if fit is None:
            return None
        self._initializer.evaluate(fit, force_std / math.sqrt(samples))
        ready = self._initializer.ready_to_hand_over
        event = None
        if modes.initialized:
            self._cross_checks.postpone(now_ns)
            failed = tracker.cross_check_failed(fit.mean, fit.covariance, fit.acceleration, force_std)
            if modes.suspended or not ready or not failed:
                return None
            return _less_certain(tracker, fit, self._initializer.range)
        if ready:
            self._cross_checks.restart(now_ns)
            event = Event.HAND_OVER
        self.has_fit = True
        return NewCoefficients(fit.mean, _with_floor(fit), event, self._initializer.range)


def _less_certain(tracker: Tracker, fit: Fit, stroke: tuple[float, float]) -> NewCoefficients:
    """The filter's coefficients with their difference to those of a fit, and its covariance, in their own.

    The mass stays as it is: the cross-check does not compare it.
    """
    difference, uncertainty = fit.mean - tracker.z[3:], fit.covariance.copy()
    difference[C.M] = uncertainty[C.M] = uncertainty[:, C.M] = 0.0
    covariance = tracker.p[3:, 3:] + uncertainty + np.outer(difference, difference)
    return NewCoefficients(tracker.z[3:].copy(), covariance, None, stroke)


def _with_floor(fit: Fit) -> Array:
    """Covariance of a fit with a least standard deviation of each coefficient that the filter may not exceed."""
    k2_std = MIN_K2_RELATIVE_STD * fit.mean[C.K2]
    floor = np.array([MIN_LN_STIFFNESS_STD**2, k2_std**2, MIN_D1_STD**2, MIN_D2_STD**2, 0.0, 0.0, 0.0])
    return np.asarray(fit.covariance + np.diag(floor))
