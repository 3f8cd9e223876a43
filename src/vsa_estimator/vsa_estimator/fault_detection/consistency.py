"""Whether to rely on what was learnt, and what to do when the sensors contradict it.

In doubt nothing is learnt: the coefficients go back to what they were before the contradiction, and stiffness is not
valid until the sensors agree with them again. A contradiction that stays is explained by a shift of one sensor, or
makes the estimator forget.
"""

import math

from vsa_common.types import ResetReason
from vsa_estimator.fault_detection.parity_check import SHIFT_TIME, Coefficients, ParityCheck
from vsa_estimator.fault_detection.residual import PERIOD
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.preprocessing.decimator import Decimated

KEEP = 4.0  # between two memories of what was known [s]
PROBATION = 7.0  # without contradiction, before what was learnt counts for more than what is measured [s]
GIVE_UP = 6.0  # of contradiction, by sensors that are otherwise well, before all is forgotten [s]

INCONSISTENT = "force and encoder contradict what was learnt: a sensor drifts, or the transmission has changed"
AFTER_GAP = "looking whether all is as before the silence"


class ConsistencyMonitor:
    """Takes every step of the filter and says whether its coefficients are to be relied on."""

    def __init__(self, rate: float) -> None:
        """`rate` of the filter [Hz]."""
        self.reason = ""  # of the doubt; empty when there is none
        self._parity = ParityCheck(rate)
        self._kept = -math.inf
        self._time_in_fault = 0.0
        self._proven = 0.0  # [s]

    def reset(self) -> None:
        """Nothing is known that could be doubted."""
        self.reason = ""
        self._proven = 0.0
        self._parity.reset()

    def interrupt(self) -> None:
        """The motion has a gap."""
        self._parity.interrupt()

    @property
    def is_consistent(self) -> bool:
        """Whether both sensors tell what was learnt: what the filter does not explain then is its own lag."""
        return self._parity.checkpoint is not None and not self._parity.is_insensitive and self._parity.is_consistent

    def suspend(self, tracker: Tracker, reason: str, broken: bool = False) -> bool:
        """Go back to what was known before, and wait; False where nothing was.

        Where the motion has `broken` off, also with coefficients that are not proven: they are what is known.
        """
        kept = self._parity.checkpoint
        proven = self._proven >= PROBATION
        if not tracker.initialized or kept is None or not (proven or broken):
            return False
        if not self.reason:
            self._time_in_fault = 0.0
            if proven:
                _recall(tracker, kept)
            else:
                self._parity.replace(_known(tracker))
        self.reason = reason
        return True

    def move(self, tracker: Tracker, shift: float, variance: float) -> None:
        """The encoder reads `shift` [m] more than it did; how uncertain that is goes into the stiffness."""
        kept = self._parity.checkpoint or _known(tracker)
        covariance = kept.covariance.copy()
        covariance[0, 0] += kept.mean[1] ** 2 * variance
        self._adopt(tracker, kept._replace(covariance=covariance, reference=kept.reference + shift))

    def evaluate(self, tracker: Tracker, time: float, block: Decimated, blind: bool) -> ResetReason:
        """Take a step at `time` [s]; `blind` when the encoder is not to be believed. What has to be reset, or NONE."""
        news = self._parity.add(time, block.deflection, block.force if block.forces else math.nan)
        if not tracker.initialized:
            return ResetReason.NONE
        if self._parity.checkpoint is None:
            self._keep(tracker, time)
        if blind:
            self.suspend(tracker, INCONSISTENT)
            self._time_in_fault = 0.0
        elif news and not self.reason:
            self._nominal(tracker, time)
        elif news:
            return self._suspended(tracker)
        return ResetReason.NONE

    def _nominal(self, tracker: Tracker, time: float) -> None:
        if self._parity.is_insensitive:  # nothing to hold against the sensors yet: let the filter learn
            self._parity.replace(_known(tracker))
            return
        if self._parity.exceeds_threshold:
            if not self.suspend(tracker, INCONSISTENT):
                self._proven = 0.0
                self._parity.replace(_known(tracker))
            return
        if self._parity.no_evidence:
            return
        self._proven += PERIOD
        self._parity.accept()
        if time - self._kept > KEEP:
            self._keep(tracker, time)

    def _suspended(self, tracker: Tracker) -> ResetReason:
        if self._parity.is_consistent:
            self.reason = ""
            self._parity.settle()
            return ResetReason.NONE
        if self._parity.no_evidence:  # motion too brisk to tell is no contradiction that stays
            return ResetReason.NONE
        self._time_in_fault += PERIOD
        if self._time_in_fault > SHIFT_TIME:
            shift = self._parity.isolate_fault()
            if shift is not None and shift.deflection:
                self.move(tracker, shift.deflection, shift.std**2)
                return ResetReason.DEFLECTION
            if shift is not None:
                self._offset(tracker, shift.force, shift.std**2)
                return ResetReason.INNOVATION
        if self._time_in_fault > GIVE_UP:
            self.reset()
            tracker.initialized = False
            return ResetReason.INNOVATION
        return ResetReason.NONE

    def _offset(self, tracker: Tracker, shift: float, variance: float) -> None:
        kept = self._parity.checkpoint or _known(tracker)
        mean, covariance = kept.mean.copy(), kept.covariance.copy()
        mean[5] += shift
        covariance[5, 5] += variance
        self._adopt(tracker, kept._replace(mean=mean, covariance=covariance))

    def _adopt(self, tracker: Tracker, coefficients: Coefficients) -> None:
        self._time_in_fault = 0.0
        self._parity.replace(coefficients)
        _recall(tracker, coefficients)

    def _keep(self, tracker: Tracker, time: float) -> None:
        self._kept = time
        self._parity.keep(_known(tracker))


def _known(tracker: Tracker) -> Coefficients:
    return Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference)


def _recall(tracker: Tracker, known: Coefficients) -> None:
    tracker.set_coefficients(known.mean, known.covariance)
    tracker.reference = known.reference
