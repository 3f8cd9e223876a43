# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Isolation of an encoder step (bias jump) among deflections that the gate rejects one after another."""

import math
from typing import NamedTuple

import numpy as np
from vsa_estimator.tuning.fault_detection import (
    DISCONTINUITY_SHARE,
    FORCE_SUPPORT_SHARE,
    MAX_SCATTER,
    MIN_COUNT,
    ONSET_GROWTH,
    REPEAT_SHARE,
)


class Rejection(NamedTuple):
    """A deflection that the gate has rejected."""

    offset: float  # from the predicted position [m]
    force_residual: float  # change of the residual at the predicted position [N]; NaN for no force
    deflection: float  # [m]
    discontinuity: float  # range of its changes between samples [m]


class OffsetHypothesis:
    """Rejected deflections since the last accepted one, and the evidence for a constant encoder offset."""

    def __init__(self) -> None:
        """No rejection."""
        self._rejected: list[Rejection] = []

    def reject(self, deflection: float, offset: float, force_residual: float, discontinuity: float) -> None:
        """Add a rejected deflection [m] with the values of `Rejection`."""
        self._rejected.append(Rejection(offset, force_residual, deflection, discontinuity))

    def clear(self) -> None:
        """Drop all rejections: a deflection was accepted, or the motion has a gap."""
        self._rejected.clear()

    def is_repeated(self, offset: float) -> bool:
        """Whether a deflection with this offset [m] repeats the rejected ones; elapsed time alone is no evidence."""
        return bool(self._rejected) and abs(offset) > REPEAT_SHARE * abs(self.size)

    @property
    def is_motion_onset(self) -> bool:
        """Whether the last three offsets grow: the rod starts to move, and no step has occurred."""
        if len(self._rejected) < 3:
            return False
        first, second, third = (one.offset for one in self._rejected[-3:])
        return second / first > ONSET_GROWTH and third / second > ONSET_GROWTH

    @property
    def is_confirmed(self) -> bool:
        """Whether MIN_COUNT offsets agree while the encoder moves on: those of a noisy or stuck encoder do not."""
        offsets = [one.offset for one in self._rejected[:MIN_COUNT]]
        if len(offsets) < MIN_COUNT:
            return False
        scatter = MAX_SCATTER * abs(self.size)
        if offsets[0] * self.size < 0.0 or float(np.std(offsets[1:])) > scatter:
            return False
        first, last = self._rejected[1], self._rejected[-1]
        return abs(last.offset - first.offset) < max(abs(last.deflection - first.deflection), scatter)

    @property
    def is_discontinuous(self) -> bool:
        """Whether one change between samples at the first rejection explains the last offset: a step, no motion.

        A motion is spread over several changes, and its offset outgrows the noise of one.
        """
        if not self._rejected:
            return False
        return self._rejected[0].discontinuity > DISCONTINUITY_SHARE * abs(self._rejected[-1].offset)

    @property
    def size(self) -> float:
        """Median of the offsets [m]."""
        return float(np.median([one.offset for one in self._representative]))

    @property
    def variance(self) -> float:
        """Variance of the offsets [m^2]."""
        return float(np.var([one.offset for one in self._representative]))

    def supported_by_force(self, elastic_force: float) -> bool:
        """Whether the force agrees with the predicted position; a motion would change it by `elastic_force` [N].

        The more likely of both by the change of the force. An absent force is no evidence against the hypothesis.
        """
        residuals = [one.force_residual for one in self._representative if not math.isnan(one.force_residual)]
        return not residuals or residuals[0] / elastic_force < FORCE_SUPPORT_SHARE

    @property
    def _representative(self) -> list[Rejection]:
        # The first mean may span both positions, and the prediction degrades with time.
        return self._rejected[1:4] or self._rejected
