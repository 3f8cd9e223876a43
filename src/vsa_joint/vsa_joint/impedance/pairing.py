"""Which samples of both sides belong together.

Sides pair by stamp, as close as half the sampling period and `max_skew` allow. Where the older samples of both are
further apart, one side lacks a sample or the other one's frame was held up. The next samples tell, and are waited for:
the first ones that are as far apart as usual show which belong together. So a lost sample costs one pair and never
shifts the pairing, and a late frame costs none. A measured sample is never paired with an earlier prediction through
silence of the other side.
"""

from collections import deque
from typing import NamedTuple

from vsa_common.types import Status
from vsa_joint.impedance.propagation import ImpedanceEstimate

QUEUE = 1000  # samples that wait for their partner
PERIOD_GAIN = 1.0 / 64.0
GAP = 10.0  # periods that a longer step counts for: a silence says little of the period
ALIKE = 1.5  # ratio of the sides' periods up to which a sample of one side belongs to each of the other
AHEAD = 8  # samples that are waited for at most where it is open which ones belong together
TIGHT = 3.0  # median deviations of the skew within which it is as usual
SPREAD_NS, SPREAD_START_NS = 1e4, 1e5  # that deviation, at least, and at first
TIME_JUMP_NS = 500_000_000  # a stamp that far back is a clock or a bag that started over


class TransmissionEstimate(NamedTuple):
    """One transmission at one instant, named as in TransmissionImpedance.msg (SI)."""

    stamp_ns: int
    force: float
    force_variance: float
    force_valid: bool
    rod: ImpedanceEstimate
    stiffness_valid: bool
    damping_valid: bool
    inertia_valid: bool
    status: int
    reset_count: int = 0
    reset_reason: int = 0


class Pairing:
    """Samples of both sides in, pairs out; never further apart than `max_skew_ns`."""

    def __init__(self, max_skew_ns: float) -> None:
        self.pairs = 0  # that went out
        self.unpaired = 0  # without a partner
        self._max_skew_ns = max_skew_ns
        self._queues: tuple[deque[TransmissionEstimate], deque[TransmissionEstimate]] = (
            deque(maxlen=QUEUE),
            deque(maxlen=QUEUE),
        )
        self._newest_ns: list[int | None] = [None, None]
        self._period_ns = [0.0, 0.0]
        self._skew_ns, self._spread_ns = 0.0, SPREAD_START_NS  # of the first side's stamps behind the second's

    @property
    def period_ns(self) -> float:
        """Time between samples of the slower side."""
        return max(self._period_ns)

    def take(self, side: int, sample: TransmissionEstimate) -> bool:
        """A sample of side 0 or 1; False where it is a duplicate or late, and not taken."""
        if not self._in_order(side, sample.stamp_ns):
            return False
        self._newest_ns[side] = sample.stamp_ns
        queue = self._queues[side]
        if len(queue) == QUEUE:
            self.unpaired += 1
        queue.append(sample)
        return True

    def next(self) -> tuple[TransmissionEstimate, TransmissionEstimate] | None:
        """The oldest pair, where there is one; call it once for each sample taken."""
        first, second = self._queues
        limit = self._skew_limit_ns()
        while first and second:
            skew = first[0].stamp_ns - second[0].stamp_ns
            later, earlier = (first, second) if skew > 0 else (second, first)
            if _predicted(earlier[0]) and not _predicted(later[0]):
                if len(earlier) == 1:
                    return None  # its own sample may be on its way
                earlier.popleft()
                continue
            together = abs(skew) <= limit
            if not together and self._in_step():
                held_up = self._held_up(later, earlier)
                if held_up is None:
                    return None  # the next samples tell
                if held_up:
                    together = abs(skew) <= self._max_skew_ns
                    if not together:
                        self._drop(later)
            if together:
                self._learn_skew(skew)
                self.pairs += 1
                return first.popleft(), second.popleft()
            self._drop(earlier)
        return None

    def _in_order(self, side: int, stamp_ns: int) -> bool:
        previous_ns = self._newest_ns[side]
        if previous_ns is None:
            return True
        step = stamp_ns - previous_ns
        if step > 0:
            period = self._period_ns[side]
            self._period_ns[side] = period + PERIOD_GAIN * (min(step, GAP * period) - period) if period else float(step)
            return True
        if step < -TIME_JUMP_NS:
            self._forget_after(stamp_ns + TIME_JUMP_NS)
            return True
        return False

    def _forget_after(self, stamp_ns: int) -> None:
        for queue in self._queues:
            while queue and queue[-1].stamp_ns > stamp_ns:
                queue.pop()
                self.unpaired += 1

    def _drop(self, queue: deque[TransmissionEstimate]) -> None:
        queue.popleft()
        self.unpaired += 1

    def _skew_limit_ns(self) -> float:
        first, second = self._period_ns
        return min(self._max_skew_ns, 0.5 * min(first, second)) if first and second else self._max_skew_ns

    def _in_step(self) -> bool:
        """Whether there was a pair, of sides whose samples come as often."""
        low, high = sorted(self._period_ns)
        return self.pairs > 0 and high <= ALIKE * low

    def _held_up(self, later: deque[TransmissionEstimate], earlier: deque[TransmissionEstimate]) -> bool | None:
        """Whether the oldest samples belong together, and the later one came late; None while that is open.

        Open until two samples are as far apart as usual, or AHEAD of them have come.
        """
        usual = self._skew_ns if later is self._queues[0] else -self._skew_ns
        kept = shifted = 0.0
        for j in range(1, min(len(later), len(earlier))):
            stamp_ns = earlier[j].stamp_ns
            off = abs(later[j].stamp_ns - stamp_ns - usual)
            off_shifted = abs(later[j - 1].stamp_ns - stamp_ns - usual)
            if min(off, off_shifted) <= TIGHT * self._spread_ns:
                return off < off_shifted
            kept, shifted = kept + off, shifted + off_shifted
            if j == AHEAD:
                return kept < shifted
        return None

    def _learn_skew(self, skew_ns: float) -> None:
        """Median of the sides' skew, and of its deviation, each followed step by step."""
        off = skew_ns - self._skew_ns
        spread = max(self._spread_ns, SPREAD_NS)
        self._spread_ns = spread * (1.0 + PERIOD_GAIN if abs(off) > spread else 1.0 - PERIOD_GAIN)
        self._skew_ns += PERIOD_GAIN * min(max(off, -spread), spread)


def _predicted(sample: TransmissionEstimate) -> bool:
    """Whether there was no measurement: its sensors were silent."""
    return sample.status == Status.STALE
