# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Analytical redundancy of force and encoder: are both consistent with coefficients of some seconds ago?

The filter follows its sensors sample by sample, so it would adapt to a slow fault of either. Here the measured force is
compared with the force of checkpointed coefficients on the motion of the encoder alone. The noise of the velocity
telescopes: its mean over a window is the noise of two positions over the window's length.
"""

import math
from collections import deque

import numpy as np
from vsa_common.types import Array
from vsa_estimator.fault_detection.fault_size import FaultSize
from vsa_estimator.fault_detection.held_law import Law
from vsa_estimator.fault_detection.isolation import Residuals, SensorShift, isolate_recent
from vsa_estimator.fault_detection.residual import DECISION_WINDOW
from vsa_estimator.fault_detection.residual_scale import ResidualScale
from vsa_estimator.fault_detection.row_buffer import RowBuffer
from vsa_estimator.fault_detection.travel import EVERYWHERE, Travel
from vsa_estimator.tuning.fault_detection import (
    CONSISTENT_SHARE,
    EVALUATION_PERIOD,
    INSENSITIVE_RATIO,
    MAX_BASELINE,
    MAX_RIPPLE,
    MAX_SCALE,
    MIN_BASELINE,
    MIN_ROWS,
    MOVING_SPEED,
    THRESHOLDS,
    VELOCITY_STD,
    WINDOWS,
)

PASSAGE = round(WINDOWS[DECISION_WINDOW] / EVALUATION_PERIOD)  # evaluations in the decision window


class ParityCheck:
    """Checkpointed coefficients, and the mean parity residuals of the recent steps against them."""

    def __init__(self, rate: float, peak_speed: float) -> None:
        """`rate` of the filter [Hz]; initial v* [m/s], up to which a damper without a peak counts as known."""
        self._peak_speed = peak_speed
        self._checkpoints: deque[Law] = deque(maxlen=2)
        self._rows = RowBuffer(int(WINDOWS[-1] * rate) + 1)
        self._scale = ResidualScale()
        self._baseline = MAX_BASELINE  # of the velocity difference [s]
        self._evaluated_at = 0.0
        self._windows = np.zeros((4, len(WINDOWS)))  # see evaluate_windows
        self._travel = Travel()  # in which sensors and checkpoint were consistent
        self.interrupt()
        self.begin_fault()

    def reset(self) -> None:
        """Drop checkpoints and steps."""
        self._checkpoints.clear()
        self._travel = Travel()
        self.interrupt()

    def interrupt(self) -> None:
        """Drop the steps: the motion has a gap."""
        self._rows.clear()
        self._windows[0] = np.nan

    def keep(self, law: Law) -> None:
        """Add a checkpoint; the sensors are compared with the older one of two."""
        self._checkpoints.append(law)
        if self._travel.is_empty and self._rows.deflection.size:
            self.extend_travel()

    def replace(self, law: Law) -> None:
        """Make this law the only checkpoint."""
        if self._checkpoints:
            self._travel.shift(law.reference - self._checkpoints[0].reference)
        self._checkpoints.clear()
        self.keep(law)

    @property
    def checkpoint(self) -> Law | None:
        """Law that the sensors are compared with."""
        return self._checkpoints[0] if self._checkpoints else None

    def add(self, step: tuple[float, float, float], deflection_variance: float, after_rejection: bool) -> bool:
        """Add a step [s, m, N] with this variance [m^2], NaN for no force; whether the residuals were evaluated anew.

        `after_rejection` of deflections no velocity difference is accurate: an acceleration, or a step, is within it.
        """
        time = step[0]
        self._rows.append(*step, after_rejection)
        if not self._checkpoints or time - self._evaluated_at < EVALUATION_PERIOD:
            return False
        self._evaluated_at = time
        self._windows[0] = np.nan
        if self._rows.view.shape[1] >= MIN_ROWS:
            self._baseline = min(max(math.sqrt(2.0 * deflection_variance) / VELOCITY_STD, MIN_BASELINE), MAX_BASELINE)
            for law in self._checkpoints:
                law.follow(self._rows.view, self._baseline, self._peak_speed)
            law = self._checkpoints[0]
            self._evaluate(law, EVERYWHERE if self.extrapolates else law.travel(self._travel))
        return True

    @property
    def is_uncertain(self) -> bool:
        """Whether the checkpoint is too uncertain to expose a fault."""
        model_std = float(self._windows[1, DECISION_WINDOW])
        return model_std > INSENSITIVE_RATIO * self._scale.std(DECISION_WINDOW)

    @property
    def has_expired(self) -> bool:
        """Whether the checkpoint has become too uncertain to expose a fault, by its age alone."""
        return self._checkpoints[0].ages and self.is_uncertain and not self.no_evidence

    @property
    def is_insensitive(self) -> bool:
        """Whether the usual residuals are too large to expose a fault."""
        return self._scale.std(DECISION_WINDOW) > MAX_SCALE

    @property
    def fit(self) -> tuple[Array, Residuals]:
        """Column of the decision window in `evaluate_windows` (4,), and its residuals."""
        return self._windows[:, DECISION_WINDOW].copy(), self._residuals(self._recent)

    @property
    def extrapolates(self) -> bool:
        """Whether the position is beyond the travel: there the covariance does not contain the error of the law."""
        low, high = self._checkpoints[0].travel(self._travel)
        return not low < float(self._rows.deflection[-1]) < high

    @property
    def no_evidence(self) -> bool:
        """Whether the motion allows no residual in the decision window."""
        return math.isnan(self._windows[0, DECISION_WINDOW])

    @property
    def moves(self) -> bool:
        """Whether the deflection has moved within the decision window."""
        return bool(np.ptp(self._recent[1]) > MOVING_SPEED * WINDOWS[DECISION_WINDOW])

    @property
    def exceeded(self) -> list[int]:
        """Indices in WINDOWS of those whose mean residual exceeds its threshold."""
        return [index for index in range(len(WINDOWS)) if self._normalized(index) > 1.0]

    def choose_law(self) -> bool:
        """Choose another law of the checkpoint that explains the recent steps, in all windows; whether there is one."""
        before = self._windows.copy()
        for law in self._checkpoints[0].others():
            law.follow(self._rows.view, self._baseline, self._peak_speed)
            self._evaluate(law, EVERYWHERE)
            if not self.exceeded and not np.isnan(self._windows[0, ~np.isnan(before[0])]).any():
                self._checkpoints[0] = law
                return True
        self._windows = before
        return False

    @property
    def is_consistent(self) -> bool:
        """Whether the mean residuals up to the decision window are all small."""
        return all(self._normalized(index) < CONSISTENT_SHARE for index in range(DECISION_WINDOW + 1))

    @property
    def is_inconsistent(self) -> bool:
        """Whether the mean residual of the decision window is not small."""
        return self._normalized(DECISION_WINDOW) > CONSISTENT_SHARE

    def begin_fault(self) -> None:
        """Drop what is known of the last fault."""
        self._fault = FaultSize(PASSAGE)

    @property
    def fault_size(self) -> tuple[float, float]:
        """Size of the present fault, if it shifts the force [N], the encoder [m]; 0: unknown."""
        return self._fault.shift

    def measure_fault(self) -> None:
        """Take the size of the present fault, and where its residual becomes small, from the mean residuals."""
        mean, normalized = float(self._windows[0, DECISION_WINDOW]), self._normalized(DECISION_WINDOW)
        rejected = bool(self._rows.view[3].any())
        self._fault.add(mean, float(self._recent[1].mean()), normalized, self._stiffness, rejected)

    def fault_would_show(self, of_encoder: bool = True) -> bool:
        """Whether a shift of the force sensor, and `of_encoder` also of the encoder, of the fault's size would show.

        It would not at rest, where stiction can balance it and hide as much again, and that of the encoder not where
        the spring is soft. True for a fault without a size.
        """
        force, by_encoder = self.fault_size[0], self.fault_size[1] * self._stiffness
        residual = (min(force, by_encoder) if of_encoder else force) - 2.0 * float(self._windows[2, DECISION_WINDOW])
        return force == 0.0 or residual > CONSISTENT_SHARE * self._threshold(DECISION_WINDOW)

    def hidden_change(self) -> float:
        """Relative error of the stiffness by another law without a residual at the present deflections, or 0."""
        _, values, *_, motion, _ = self._residuals(self._recent)
        limit = CONSISTENT_SHARE * self._threshold(DECISION_WINDOW)
        slope = self._fault.hidden_slope(self._stiffness, motion[0], values, limit)
        return slope / self._checkpoints[0].stiffness(self._fault.deflection) if slope else 0.0

    @property
    def _recent(self) -> Array:
        """The steps (4, n) of the decision window."""
        view = self._rows.view
        return view[:, int(np.searchsorted(view[0], view[0, -1] - WINDOWS[DECISION_WINDOW])) :]

    @property
    def _stiffness(self) -> float:
        """Stiffness of the checkpoint at the last deflection [N/m]."""
        return self._checkpoints[0].stiffness(float(self._rows.deflection[-1]))

    @property
    def growth(self) -> float:
        """Slope of ln stiffness of the checkpoint at the last deflection [1/m]."""
        return self._checkpoints[0].growth(float(self._rows.deflection[-1]))

    def accept(self) -> None:
        """Adapt the residual scales to the present means, which are those of consistent sensors."""
        self.extend_travel()
        self._scale.adapt(self._windows[0], self._windows[3])

    def extend_travel(self) -> None:
        """Extend the travel by the recent deflections, where the sensors are consistent."""
        self._travel.extend(self._recent[1].tolist())

    def end_fault(self) -> None:
        """Drop the steps of a fault that has ended."""
        self._rows.drop_before(self._evaluated_at - WINDOWS[DECISION_WINDOW])

    def isolate_fault(self) -> SensorShift | None:
        """The constant shift of one sensor that explains the last seconds, if the other's does not."""
        if not self._checkpoints or self._rows.view.shape[1] < MIN_ROWS:
            return None
        limit = MAX_RIPPLE * self._scale.std(DECISION_WINDOW)
        return isolate_recent(self._residuals(self._rows.view), self.growth, limit)

    def _residuals(self, rows: Array) -> Residuals:
        """Residuals of rows (4, n) at any deflection."""
        return self._checkpoints[0].residuals(rows, self._baseline, (*EVERYWHERE, self._peak_speed))

    def _evaluate(self, law: Law, travel: tuple[float, float]) -> None:
        """Evaluate the windows against a law, by the deflections within `travel` [m]."""
        law.evaluate(self._rows.view, self._baseline, (*travel, self._peak_speed), self._windows)

    def _normalized(self, index: int) -> float:
        """Mean residual of a window, less the stiction that it may hide, over its threshold; NaN for too few rows."""
        mean, _, hidden, _ = self._windows[:, index].tolist()
        return max(abs(mean) - hidden, 0.0) / self._threshold(index)

    def _threshold(self, index: int) -> float:
        """Threshold of the mean residual of a window [N]."""
        return THRESHOLDS[index] * math.hypot(self._scale.std(index), float(self._windows[1, index]))
