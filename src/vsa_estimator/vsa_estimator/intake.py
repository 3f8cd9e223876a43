"""What may reach the filter: finite numbers with stamps that go forward. All else is counted."""

from enum import Enum

LATE_NS = 1_000_000_000  # a stamp further back than this is a clock that was set back, not a late sample
LATE_RUN = 50  # and so is a run of this many late samples


class Verdict(Enum):
    """What to do with a sample."""

    TAKE = "take"
    DROP = "drop"
    JUMP = "jump"  # time went back: start again with this sample


class Intake:
    """Judges samples one by one; counts what it drops."""

    def __init__(self, force_bound: float, deflection_bound: float) -> None:
        """Magnitudes beyond the bounds [N, m] are no measurements at all."""
        self._force_bound = force_bound
        self._deflection_bound = deflection_bound
        self.dropped = 0
        self._last_ns = 0
        self._late = 0

    def judge(self, stamp_ns: int, force: float, deflection: float) -> Verdict:
        """TAKE, DROP (counted) or JUMP for a sample."""
        plausible = abs(force) < self._force_bound and abs(deflection) < self._deflection_bound
        if stamp_ns <= 0 or not plausible:  # a NaN is not plausible either
            self.dropped += 1
            return Verdict.DROP
        if stamp_ns > self._last_ns:
            self._last_ns = stamp_ns
            self._late = 0
            return Verdict.TAKE
        self._late += stamp_ns < self._last_ns
        if self._last_ns - stamp_ns > LATE_NS or self._late >= LATE_RUN:
            self._last_ns = stamp_ns
            self._late = 0
            return Verdict.JUMP
        self.dropped += 1
        return Verdict.DROP
