# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Comparison of two estimates of the same impedance: that of the filter and that of the bank of laws.

Both have the same data, so that their errors under a right law are correlated and the difference is smaller than the
sum of the variances. A larger one is an error of the law of one of them: it refutes the filter, whose law is the more
special one, or widens its interval. Track-to-track association; Bar-Shalom, Li and Kirubarajan (2001), ch. 10.
"""

import math

from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.records import Record
from vsa_estimator.tuning.general import (
    COMPARISON_CAP,
    COMPARISON_TIME,
    DAMPER_SHAPE_STD,
    DAMPING_BIAS,
    DAMPING_DISCREPANCY_STD,
    DIFFERENCE_THRESHOLD,
    LAW_DISCREPANCY_STD,
    SHAPE_STD,
    STIFFNESS_BIAS,
)  # fmt: skip
from vsa_estimator.tuning.output import (
    MAX_BEYOND_PEAK,
    MAX_DAMPING_STD,
    MAX_SPEED_SHARE,
    MAX_STIFFNESS_STD,
    MIN_DAMPING_SCALE,
)


@compiled
def differences(filtered: Record, impedance: Record) -> tuple[bool, tuple[float, float], tuple[float, float]]:
    """Differences of ln stiffness and of damping [N s/m] of a (1,) PREDICTION from a (1,) IMPEDANCE, at its motion.

    Returns whether the filter's stiffness is accurate, and both differences with the sums of the variances; a variance
    of 0 where the bank's stiffness, or one of the dampings, is not accurate or beyond v*.
    """
    one, other = filtered[0], impedance[0]
    x, v = other["motion"][0], other["motion"][1]
    stiffness, damping = (0.0, 0.0), (0.0, 0.0)
    if other["ln_stiffness_variance"] < MAX_STIFFNESS_STD**2:
        change = math.log(one["stiffness"]) - other["ln_stiffness"] - other["slope"] * (one["deflection"] - x)
        stiffness = (change, one["ln_stiffness_variance"] + other["ln_stiffness_variance"])
    scale = max(abs(other["damping"]), MIN_DAMPING_SCALE * abs(other["rest_damping"]))
    accurate = max(one["damping_variance"], other["damping_variance"]) < (MAX_DAMPING_STD * scale) ** 2
    slow = abs(one["velocity"]) <= MAX_SPEED_SHARE * one["peak_speed"] and other["beyond_peak"] <= MAX_BEYOND_PEAK
    if accurate and slow:
        change = one["damping"] - other["damping"] - other["damping_slope"] * (one["velocity"] - v)
        damping = (change, one["damping_variance"] + other["damping_variance"])
    return one["ln_stiffness_variance"] < MAX_STIFFNESS_STD**2, stiffness, damping


@compiled
def move_to(filtered: Record, covariance: Array, impedance: Record) -> None:
    """Move a (1,) IMPEDANCE to the motion of the filter, (1,) PREDICTION with this covariance (3, 3).

    The filter follows the onset of a motion first. The variances grow by what is less certain of its motion.
    """
    one, other = filtered[0], impedance[0]
    dx, dv = one["deflection"] - other["motion"][0], one["velocity"] - other["motion"][1]
    slope, by_speed, before = other["slope"], other["damping_slope"], other["motion_covariance"]
    other["ln_stiffness"] += slope * dx
    other["ln_stiffness_variance"] += other["slope_variance"] * dx * dx
    other["ln_stiffness_variance"] += slope * slope * max(covariance[0, 0] - before[0, 0], 0.0)
    other["damping"] += by_speed * dv
    other["damping_variance"] += by_speed * by_speed * max(covariance[1, 1] - before[1, 1], 0.0)
    other["motion"][0], other["motion"][1], other["motion"][2] = (
        one["deflection"], one["velocity"], one["acceleration"],
    )  # fmt: skip
    other["motion_covariance"][:, :] = covariance


class Difference:
    """Running mean squares of the difference of one quantity."""

    def __init__(self) -> None:
        """No difference yet."""
        self._weighted_nis = 0.0  # mean as `nis`, by the probability of another law
        self._precision = 0.0  # mean inverse variance [1/unit^2]
        self.excess = 0.0  # last difference squared beyond the threshold [unit^2]
        self.nis = 1.0  # mean of the difference squared over the sum of the two variances

    def restart_test(self) -> None:
        """One of the two estimates is new: the next difference decides. The widening by small ones stays."""
        self.nis = min(self.nis, DIFFERENCE_THRESHOLD * DIFFERENCE_THRESHOLD)

    def add(self, gain: float, difference: float, variance: float, weight: float) -> None:
        """Update by a difference with the sum of the two variances; `weight` is the probability of another law."""
        square = difference * difference
        nis = min(square / variance, COMPARISON_CAP)
        self.nis += gain * (nis - self.nis)
        self.excess = max(square - DIFFERENCE_THRESHOLD * DIFFERENCE_THRESHOLD * variance, 0.0)
        self._weighted_nis += gain * (weight * nis - self._weighted_nis)
        self._precision += gain * (1.0 / variance - self._precision)

    def widening(self, prior: float) -> float:
        """Last excess or, where larger, the mean square by precision and probability of another law [unit^2].

        An excess above the `prior` variance of an error by a wrong law is one of the other estimate.
        """
        mean = self._weighted_nis / self._precision if self._precision > 0.0 else 0.0
        return max(min(self.excess, prior), mean)


class LawComparison:
    """Differences of stiffness and damping between filter and bank."""

    def __init__(self) -> None:
        """Before the first step."""
        self.restart()

    def restart(self) -> None:
        """Drop the differences."""
        self._stiffness, self._damping = Difference(), Difference()
        self.filter_valid = False  # whether the filter's stiffness is accurate enough to be compared

    def add(self, dt: float, filtered: Record, impedance: Record, weight: float) -> None:
        """Compare a (1,) PREDICTION of the filter with the (1,) IMPEDANCE of the bank, dt [s] after the step before.

        At the motion of the filter: that of the bank is another one at an onset. `weight` is the probability of another
        law than the exponential.
        """
        gain = dt / COMPARISON_TIME
        self.filter_valid, stiffness, damping = differences(filtered, impedance)
        if stiffness[1] > 0.0:
            self._stiffness.add(gain, *stiffness, weight)
        if damping[1] > 0.0:
            self._damping.add(gain, *damping, weight)

    @property
    def exceeds_threshold(self) -> bool:
        """Whether stiffness or damping of the filter differs from the bank's by more than both intervals permit."""
        return max(self._stiffness.nis, self._damping.nis) > DIFFERENCE_THRESHOLD * DIFFERENCE_THRESHOLD

    def restart_test(self) -> None:
        """One of the two estimates is new: the next differences decide."""
        self._stiffness.restart_test()
        self._damping.restart_test()

    def discrepancies(self, impedance: Record, weight: float, improbable: bool) -> tuple[float, float]:
        """Variances of ln stiffness and of the damping that the choice of the law leaves open in the filter.

        By the present difference beyond both intervals, by the mean difference, and by an error that the (1,) IMPEDANCE
        of the bank is too uncertain to show: its prior variance is that under another law times `weight`, the
        probability of one; where the filter's law is `improbable`, the variance of the shapes of laws. The bank's
        variance, that of a mixture, is weighted already; its systematic error belongs to no law.
        """
        of_bank = impedance[0]
        rest = float(of_bank["rest_damping"])
        scale = max(rest, abs(float(of_bank["damping"])))
        stiffness = float(of_bank["ln_stiffness_variance"]) - STIFFNESS_BIAS**2
        damping = float(of_bank["damping_variance"]) - (DAMPING_BIAS * rest) ** 2
        stds = (SHAPE_STD, DAMPER_SHAPE_STD) if improbable else (LAW_DISCREPANCY_STD, DAMPING_DISCREPANCY_STD)
        priors = stds[0] ** 2, (stds[1] * scale) ** 2
        return (
            self._stiffness.widening(priors[0]) + _posterior(weight * priors[0], stiffness),
            self._damping.widening(priors[1]) + _posterior(weight * priors[1], damping),
        )


def _posterior(prior: float, variance: float) -> float:
    """Variance of an error of this prior variance, after a comparison with an estimate of this variance."""
    return prior * variance / (prior + variance) if variance > 0.0 else 0.0
