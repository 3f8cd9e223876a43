# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Update of the filter by a deflection: gate, onset of motion, encoder step, discontinuity of the motion."""

import math
from enum import Enum, auto

from vsa_common.types import Array
from vsa_estimator.fault_detection.encoder_step import OffsetHypothesis
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import Z
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.tuning.supervisor import PAUSE_PERIODS, POSITION_RESET_TIMEOUT, TIMING_SUSPECT_NS


class PositionUpdate(Enum):
    """Result of an update by a deflection."""

    ACCEPTED = auto()
    REJECTED = auto()
    RESET_DUE = auto()  # rejected, and the position has to be reset to the encoder's


class PositionMonitor:
    """Rejected deflections of one transmission, and the times at which its stamps are suspect."""

    def __init__(self) -> None:
        """No deflection yet."""
        self._offsets = OffsetHypothesis()
        self._accepted_ns = 0
        self._accepted: tuple[Array, float] | None = None  # motion (3,) and force [N] at the last accepted deflection
        self._timing_suspect_ns = 0
        self._increments = math.nan, math.nan  # greatest and least change between samples of the last block [m]

    def restart(self, instant_ns: int) -> None:
        """Begin anew at a position that is accepted at `instant_ns` [ns]."""
        self._accepted_ns, self._accepted = instant_ns, None
        self._offsets.clear()

    def mark_timing_suspect(self, instant_ns: int) -> None:
        """Samples in a burst or an encoder fault at `instant_ns` [ns]: a clock or the encoder may have stood still."""
        self._timing_suspect_ns = instant_ns

    def is_discontinuous(self, tracker: Tracker, block: Decimated, variance: float, pause: bool) -> bool:
        """Whether a deflection is an outlier where timing is suspect, or after a `pause`: no encoder step then."""
        suspect = pause or 0 <= block.stamp_ns - self._timing_suspect_ns < TIMING_SUSPECT_NS
        return suspect and tracker.is_outlier(block.deflection, variance)

    def update(
        self, tracker: Tracker, jerk: JerkDensity, block: Decimated, variance: float, initialized: bool
    ) -> PositionUpdate:
        """Update the filter by the deflection of a block with this noise `variance` [m^2]."""
        discontinuity = self._discontinuity(block)
        offset = block.deflection - tracker.position
        repeated = initialized and self._offsets.is_repeated(offset)
        if not repeated and tracker.update_deflection(block.deflection, variance):
            return self._accept(tracker, block)
        self._offsets.reject(block.deflection, offset, self._change_of_residual(tracker, block), discontinuity)
        since = (block.stamp_ns - self._accepted_ns) * 1e-9
        onset = self._offsets.is_motion_onset or (repeated and not self._offsets.is_discontinuous)
        if onset:
            jerk.detect_manoeuvre(tracker.deflection_nis)
            tracker.inflate_for_acceleration(offset, since)
        moved = onset or (repeated and not self._is_step(tracker))
        if moved and tracker.update_deflection(block.deflection, variance):
            return self._accept(tracker, block)
        confirmed = repeated and self._offsets.is_confirmed
        if since > POSITION_RESET_TIMEOUT or (confirmed and tracker.position_uncertain(offset, variance)):
            return PositionUpdate.RESET_DUE
        return PositionUpdate.REJECTED

    def encoder_step(self, tracker: Tracker) -> bool:
        """Whether the rejected deflections are an encoder step, and agree on its size."""
        return self._offsets.is_confirmed and self._is_step(tracker)

    @property
    def step_size(self) -> float:
        """Median of the rejected offsets [m]."""
        return self._offsets.size

    @property
    def step_variance(self) -> float:
        """Variance of the rejected offsets [m^2]."""
        return self._offsets.variance

    def _accept(self, tracker: Tracker, block: Decimated) -> PositionUpdate:
        self.restart(block.stamp_ns)
        self._accepted = tracker.z[:3].copy(), block.force if block.forces else math.nan
        return PositionUpdate.ACCEPTED

    def _change_of_residual(self, tracker: Tracker, block: Decimated) -> float:
        """Force residual at the predicted state less that at the last accepted deflection [N]; NaN for no force.

        What both have in common is no effect of a motion between them: stiction, or a bias of the force.
        """
        if not block.forces:
            return math.nan
        residual = block.force - tracker.predicted_force(tracker.z)
        if self._accepted is None or math.isnan(self._accepted[1]):
            return residual
        z, (motion, force) = tracker.z.copy(), self._accepted
        z[:3] = motion
        return residual - (force - tracker.predicted_force(z))

    def _discontinuity(self, block: Decimated) -> float:
        """Range of the changes between samples, of a block and the one before [m]; NaN for the first block.

        A step is within one change, which exceeds the others by its size; a motion is spread over all of them.
        """
        before, self._increments = self._increments, (block.max_increment, block.min_increment)
        return max(before[0], block.max_increment) - min(before[1], block.min_increment)

    def _is_step(self, tracker: Tracker) -> bool:
        """Whether the encoder has stepped: within one sample, and the force agrees with the predicted position."""
        if not self._offsets.is_discontinuous:
            return False
        moved = tracker.z.copy()
        moved[Z.X] += self._offsets.size
        return self._offsets.supported_by_force(tracker.predicted_force(moved) - tracker.predicted_force(tracker.z))


def is_pause(dt: float, period: float) -> bool:
    """Whether a step of dt [s] is a pause for a stream of this `period` [s]."""
    return dt > PAUSE_PERIODS * period
