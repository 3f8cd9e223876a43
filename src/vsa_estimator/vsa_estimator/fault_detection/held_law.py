# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parity residuals of a checkpoint of the bank of laws: measured force less that of its most probable member.

The member is predicted without corrections, on the motion of the encoder: its relaxation and hysteresis follow the
deflection, and its covariance grows by the noise of its model. Each row is evaluated once.
"""

from collections.abc import Iterator

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array, Integers
from vsa_estimator.fault_detection.isolation import Residuals, SensorShift
from vsa_estimator.fault_detection.residual import (
    Coefficients,
    differences,
    exclude_neighbours,
    half_baseline,
    mean_period,
    mean_residual,
)
from vsa_estimator.fault_detection.row_buffer import is_confirmed, vibrates
from vsa_estimator.fault_detection.travel import EVERYWHERE, Limits, Travel
from vsa_estimator.force_law.damper import known_speed
from vsa_estimator.general.basis import extrapolation
from vsa_estimator.general.law import LAW, general_force
from vsa_estimator.general.models import MODELS
from vsa_estimator.general.prediction import advance_memory, predict_level, spring_stiffness
from vsa_estimator.general.records import D0, D1, D2, MOTION, SIZE, SPRING, STRIBECK, STRIBECK_SIZE, B, Record
from vsa_estimator.law_selection import LawSelection
from vsa_estimator.tuning.fault_detection import (
    MAX_DAMPER_ERROR,
    MEAN_SPEED_ERROR,
    MIN_ROWS,
    MOVING_SPEED,
    STICTION_RATIO,
    WINDOWS,
)
from vsa_estimator.tuning.force_law import COULOMB_SPEED

ROW = np.dtype([
    ("time", "f8"), ("residual", "f8"), ("stiffness", "f8"), ("motion", "f8", (3,)),  # [s, N, N/m], x, v, a
    ("error", "f8"),  # greatest error of the damper force by the acceleration within the baseline [N]
    ("gradient", "f8", (SIZE,)),  # of the force by the coefficients
    ("usable", "?"), ("excluded", "?"), ("moving", "?"),
], align=True)  # fmt: skip


class HeldLaw:
    """The bank of laws at a checkpoint, and the residuals of the steps since then."""

    ages = True  # whether the covariance grows with time: by the noise of the member's model

    def __init__(self, laws: LawSelection, choice: int = 0) -> None:
        """`laws`: a copy, after its first step; `choice` among the plausible members of its bank."""
        self.laws, self._choice, self._plausible = laws, choice, laws.bank.plausible()
        self._member, self._geometry = laws.bank.member(self._plausible[choice])
        hold(self._member)
        self._time = laws.time  # of the last row [s]
        self._rows: Record = np.zeros(0, ROW)

    def others(self) -> "Iterator[HeldLaw]":
        """The checkpoint with each other plausible member, the more probable first."""
        return (HeldLaw(self.laws, choice) for choice in range(len(self._plausible)) if choice != self._choice)

    @property
    def explains_slow_faults(self) -> bool:
        """Whether the law has a level with a rate, or relaxation: both explain a slow fault, too."""
        model = MODELS[self._plausible[self._choice]]
        return model.rate_density > 0.0 or model.relaxation

    @property
    def reference(self) -> float:
        """Position to which the law refers [m]."""
        return float(self._geometry["reference"][0])

    def stiffness(self, deflection: float) -> float:
        """Stiffness at a deflection [m] in N/m."""
        return max(float(spring_stiffness(self._member[0]["mean"][SPRING:], self._geometry, deflection)), 1.0)

    def growth(self, deflection: float) -> float:
        """Slope of ln stiffness at a deflection [m] in 1/m: over a tenth of 1 / k2 of the prior."""
        step = 0.05 * float(self._geometry["unit"][0])
        return float(np.log(self.stiffness(deflection + step) / self.stiffness(deflection - step))) / (2.0 * step)

    def travel(self, _known: Travel) -> tuple[float, float]:
        """Everywhere: where the law is not known, its covariance has that."""
        return EVERYWHERE

    def follow(self, rows: Array, baseline: float, peak_speed: float) -> None:
        """Evaluate the new ones of the recent rows (4, n) of a RowBuffer, and drop older ones than these.

        The last ones of half a `baseline` [s] wait for the acceleration over twice the baseline. The cubic damper is
        known up to `peak_speed` [m/s] at most.
        """
        new = np.zeros(rows.shape[1] - int(np.searchsorted(rows[0], self._time)), ROW)
        count = follow_rows(self._member, self._geometry, rows, baseline, peak_speed, self._time, new)
        if count:
            self._time = float(new["time"][count - 1])
        kept = self._rows[int(np.searchsorted(self._rows["time"], rows[0, 0])) :]
        self._rows = np.concatenate((kept, new[:count]))

    def residuals(self, rows: Array, baseline: float, limits: Limits) -> Residuals:
        """As `residual.residuals`, of those rows that have been followed."""
        first = int(np.searchsorted(self._rows["time"], rows[0, 0]))
        kept, finite = usable_rows(self._rows[first:], limits, _lag(rows, baseline))
        chosen = self._rows[first:][kept]
        return (
            chosen["time"], chosen["residual"], chosen["stiffness"], chosen["moving"], chosen["motion"].T, finite
        )  # fmt: skip

    def evaluate(self, rows: Array, baseline: float, limits: Limits, windows: Array) -> None:
        """As `residual.evaluate_windows`, of the rows that have been followed."""
        held_windows(self._rows, self._member, limits, _lag(rows, baseline), mean_period(rows[0]), windows)

    def widened(self, ln_stiffness_variance: float) -> "HeldLaw":
        """The law with a greater variance of ln stiffness."""
        laws = self.laws.copied()
        laws.bank.widen(ln_stiffness_variance)
        return HeldLaw(laws)

    def shifted(self, shift: SensorShift) -> "HeldLaw":
        """The law for sensors that read this much more."""
        laws = self.laws.copied()
        laws.shift(shift.deflection, shift.force, shift.variances)
        return HeldLaw(laws)


Law = Coefficients | HeldLaw


def _lag(rows: Array, baseline: float) -> int:
    """Rows in a baseline [s]."""
    return 2 * half_baseline(rows[0], max(baseline, 2.0 * mean_period(rows[0])))


@compiled
def hold(member: Record) -> None:
    """Let the force of a member depend on coefficients alone; its disturbance over the travel is one, of no motion."""
    one = member[0]
    for i in range(MOTION + 1):
        one["covariance"][i, :] = 0.0
        one["covariance"][:, i] = 0.0
    one["covariance"][B, B] = one["model"]["travel_std"] ** 2
    one["mean"][: MOTION + 1] = 0.0


@compiled
def set_motion(member: Record, geometry: Record, motion: Array, dt: float) -> None:
    """Predict a held member by dt [s], to a motion x, v, a (3,)."""
    one = member[0]
    predict_level(member, geometry, dt)
    advance_memory(member, geometry, motion[0], dt)
    one["mean"][:3], one["mean"][3] = motion, 0.0
    one["linear"][:] = one["mean"]


@compiled
def follow_rows(
    member: Record, geometry: Record, rows: Array, baseline: float, peak_limit: float, since: float, out: Record
) -> int:
    """Write the rows later than `since` [s] into `out`, (n,) ROW; their count."""
    time, deflection, force, after_rejection = rows
    baseline = max(baseline, 2.0 * mean_period(time))
    half = half_baseline(time, baseline)
    count, written, law = time.size - 2 * half, 0, np.empty(1, LAW)
    coefficients = member[0]["mean"]
    speed_limit = np.inf
    if not member[0]["model"]["spline_damper"]:
        speed_limit = known_speed(coefficients[D1], coefficients[D2], member[0]["covariance"][D2, D2], peak_limit)
    for i in range(count - half):
        if time[i + half] <= since:
            continue
        row = out[written]
        x, v, a, least_a, span = differences(time, deflection, i, half, count)
        row["time"], row["moving"] = time[i + half], abs(v) > MOVING_SPEED
        row["motion"][0], row["motion"][1], row["motion"][2] = x, v, a
        set_motion(member, geometry, row["motion"], time[i + half] - since)
        row["residual"] = force[i + half] - general_force(member, geometry, COULOMB_SPEED, 0.0, row["gradient"], law)
        row["stiffness"] = law[0]["stiffness"]
        if member[0]["model"]["encoder"]:
            row["gradient"][B] = law[0]["stiffness"]
        speed_error = 0.25 * baseline * least_a
        row["excluded"] = abs(v) + speed_error >= speed_limit
        row["error"] = speed_error * abs(law[0]["damper_slope"])
        row["excluded"] |= row["error"] > MAX_DAMPER_ERROR
        row["excluded"] |= after_rejection[i : i + 2 * half + 1].any() or extrapolation(geometry, x) > 0.0
        row["usable"] = np.isfinite(row["residual"]) and span < 2.0 * baseline and is_confirmed(force, i + half)
        row["excluded"] |= vibrates(force, i + half, 2 * half)
        since = time[i + half]
        written += 1
    return written


@compiled
def usable_rows(rows: Record, limits: Limits, lag: int) -> tuple[Integers, Array]:
    """Indices of the usable rows, and the times of all finite ones, of (n,) ROW."""
    usable, excluded = np.empty(rows.size, np.bool_), np.empty(rows.size, np.bool_)
    time = np.empty(rows.size)
    for i in range(rows.size):
        usable[i], time[i] = rows[i]["usable"], rows[i]["time"]
        excluded[i] = rows[i]["excluded"] or not limits[0] < rows[i]["motion"][0] < limits[1]
    finite = time[usable]
    exclude_neighbours(usable, excluded, lag)
    return np.flatnonzero(usable), finite


@compiled
def held_windows(rows: Record, member: Record, limits: Limits, lag: int, period: float, windows: Array) -> None:
    """Write into `windows` (4, 3) what `residual.evaluate_windows` does; zeros beside a mean of NaN.

    A law of which too few rows are followed is not uncertain. What the acceleration may hide counts as stiction does.
    """
    kept, finite = usable_rows(rows, limits, lag)
    time, residual, moving = np.empty(kept.size), np.empty(kept.size), np.empty(kept.size, np.bool_)
    error = np.empty(kept.size)
    for k in range(kept.size):
        row = rows[kept[k]]
        time[k], residual[k], moving[k], error[k] = row["time"], row["residual"], row["moving"], row["error"]
    coefficients = member[0]["mean"]
    friction = coefficients[D0]
    for k in range(STRIBECK_SIZE):
        friction += coefficients[STRIBECK + k]
    end = rows[rows.size - 1]["time"] if rows.size else 0.0
    for index in range(len(WINDOWS)):
        span = max(WINDOWS[index], MIN_ROWS * period), end
        first, average, weight, in_motion = mean_residual(time, residual, moving, finite, span, lag)
        windows[:, index] = np.nan, 0.0, 0.0, 0.0
        if first >= 0:
            std = held_force_std(rows, kept[first:], member[0]["covariance"])
            hidden = weight * (1.0 - in_motion) * STICTION_RATIO * max(friction, 0.0)
            hidden += weight * float(np.mean(error[first:])) * MEAN_SPEED_ERROR
            windows[:, index] = average, std, hidden, in_motion


@compiled
def held_force_std(rows: Record, kept: Integers, covariance: Array) -> float:
    """Standard deviation [N] of the mean model force of the `kept` rows by the covariance of the coefficients."""
    gradient = np.zeros(SIZE)
    for k in range(kept.size):
        gradient += rows[kept[k]]["gradient"]
    gradient[:MOTION] = 0.0
    gradient /= kept.size
    return float(np.sqrt(max(float(gradient @ covariance @ gradient), 0.0)))
