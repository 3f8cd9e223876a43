"""Counters that wrap: an encoder's count made continuous, a frame's rolling counter checked for gaps."""

import math
import statistics
from collections import deque

COUNTED = ("lost", "duplicates", "late", "restarts", "implausible", "delayed")  # by a RollingCounter

_DELAYED_NS = 20e6  # behind the pace of the numbers by so much, and by five periods, a sample counts as delayed ...
_PAUSE_NS = 500e6  # ... unless the device paused
_FORGIVEN = 1e-2  # of the delay, with each sample
_STRETCH = 64  # samples whose mean interval is one vote on the pace
_SKIP = 64  # so many numbers may be missing at once without a second frame that bears it out
_LATE = 16  # a frame that comes up to so many numbers late is out of order, not a restarted device


class Unwrapped:
    """A value that wraps with a period, made continuous both ways.

    One that gets further from `centre` than `reach` and half a period has lost count, by garbage on its way: it starts
    again nearest to the centre.

    >>> count = Unwrapped(period=65536, centre=1000)
    >>> [count.add(raw) for raw in (65530, 65535, 4, 65534)]
    [-6.0, -1.0, 4.0, -2.0]
    """

    def __init__(self, period: float, centre: float, reach: float = math.inf) -> None:
        self._period = period
        self._centre = centre
        self._furthest = reach + 0.5 * period
        self._last = centre  # the first value is taken where it is nearest to this

    def add(self, value: float) -> float:
        """`value` plus the number of periods that brings it nearest to the last one."""
        self._last += math.remainder(value - self._last, self._period)
        if abs(self._last - self._centre) > self._furthest:
            self._last = self._centre + math.remainder(value - self._centre, self._period)
        return self._last


class RollingCounter:
    """The number of a sample from a counter of few bits; counts what the numbers say went wrong.

    Elapsed time tells a wrap during a long silence from a short gap, and a restarted device from a gap.
    """

    def __init__(self, bits: int) -> None:
        self.lost = 0  # samples that were sent and did not arrive
        self.duplicates = 0
        self.late = 0
        self.restarts = 0
        self.implausible = 0  # numbers out of the blue that the next frame did not bear out, or the first that it did
        self._modulus = 1 << bits
        self._late = min(_LATE, self._modulus // 8)
        self._number: int | None = None
        self.delayed = 0  # samples that came late, all of them, after a pause that their numbers do not know of
        self._behind_ns = self._pace_ns = 0.0
        self._stretch = (0.0, 0)  # time [ns] and samples of the present one
        self._votes: deque[float] = deque(maxlen=5)  # mean intervals [ns]
        self._suspect: int | None = None
        self._stamp_ns = 0
        self._period_ns = math.inf  # of a sample; not known yet
        self._intervals = 0

    def add(self, raw: int, stamp_ns: int) -> int | None:
        """Number of the sample, continuous; None for one that came twice or late."""
        if self._number is None:
            return self._accept(raw, stamp_ns)
        step = (raw - self._number) % self._modulus
        elapsed = (stamp_ns - self._stamp_ns) / self._period_ns  # in samples
        if step > 1 and elapsed > self._modulus // 2:  # the very next number is a device that paused
            step += self._modulus * max(0, round((elapsed - step) / self._modulus))
        if step == 0:
            self.duplicates += 1
            return None
        if self._modulus - self._late <= step < self._modulus and elapsed < step / 2:
            self.late += 1
            return None
        if step > _SKIP + 1.2 * elapsed and not self._borne_out(raw):
            self.implausible += 1
            return None
        if self._restarted(step, elapsed):
            self.restarts += 1
            return self._accept(raw, stamp_ns)
        self.lost += step - 1
        self._measure(stamp_ns - self._stamp_ns, step)
        self._learn((stamp_ns - self._stamp_ns) / step)
        return self._accept(self._number + step, stamp_ns)

    def _borne_out(self, raw: int) -> bool:
        """Whether the frame before was of the same unlikely place."""
        before, self._suspect = self._suspect, raw
        return before is not None and 0 < (raw - before) % self._modulus <= self._late

    def _restarted(self, step: int, elapsed: float) -> bool:
        # more numbers passed than time allows; bursts of a stalled adapter get an eighth of the counter
        return step > self._modulus // 8 + 1.2 * elapsed

    def _accept(self, number: int, stamp_ns: int) -> int:
        self._number, self._stamp_ns, self._suspect = number, stamp_ns, None
        return number

    def _measure(self, elapsed_ns: float, step: int) -> None:
        if elapsed_ns > _PAUSE_NS or self._intervals < 100:
            self._behind_ns, self._stretch = 0.0, (0.0, 0)
            return
        self._stretch = self._stretch[0] + elapsed_ns, self._stretch[1] + step
        if self._stretch[1] >= _STRETCH:
            self._votes.append(self._stretch[0] / self._stretch[1])
            self._stretch = 0.0, 0
            self._pace_ns = statistics.median(self._votes)
        if len(self._votes) < 3:
            return
        gained = elapsed_ns - step * self._pace_ns
        self._behind_ns = max(0.0, (1.0 - _FORGIVEN) ** step * self._behind_ns + gained)
        self.delayed += self._behind_ns > max(_DELAYED_NS, 5.0 * self._period_ns)

    def _learn(self, interval_ns: float) -> None:
        self._intervals += 1
        if math.isinf(self._period_ns):
            self._period_ns = max(interval_ns, 1.0)
        else:
            self._period_ns += (max(interval_ns, 1.0) - self._period_ns) * max(0.01, 1.0 / self._intervals)
