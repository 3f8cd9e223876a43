"""When each sample was taken, from stamps that may be late.

A busy sender stamps a sample when it gets to it: stamps then bunch up behind the instants at which the sensor, paced by
its own clock, was read. The least delayed stamps show that pace (the lower envelope, as in one-way clock
synchronisation). Whether the sensor is paced at all is asked of the motion itself: the deflection runs smoothly over
the true instants, and over no others.
"""

import math
import statistics

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.model import Array

FIRST = 32  # intervals whose median is the first idea of the period
REGULAR = 0.3  # of a period: how far off a regular interval is at most
SHARP = 0.15  # of a period: scatter of regular intervals that is small enough to recognise a return to the pace
LEAST = 1e-3  # of a period: scatter of regular intervals at least
WORTH = 500.0  # intervals over which they are averaged
LEAK = 2e-3  # of a period: how far the pace may be off
PAUSE_NS = 250e6  # after a longer silence the pace is learnt anew ...
ANOTHER = 100  # ... and after so many more irregular intervals than regular ones
WHOLE = 0.15  # of a period: a gap this close to a whole number of them is samples that were lost
CONSECUTIVE = 2  # samples later than half a period and not catching up: some were lost
HURRY = 0.5  # of a period, below which samples are catching up ...
HURRIED = 1000  # ... and for so many more a gap is thought to be lateness
RETURNS = 2  # to the pace, after which it is believed where the motion does not tell
EVIDENCE = 4.0  # standard deviations of evidence at which the pace is believed, or the stamps again
FORGET = 5e-4  # of the evidence, with each sample
FOLLOW = 0.03  # [s]
BOLDEST = 10.0  # no sample says more, in standard deviations


class Pace:
    """The sensor's own clock: the mean of its regular intervals, in step with its least delayed stamps."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self.period_ns = math.inf
        self.returns = 0
        self._away = False
        self._steps: list[int] = []
        self._last_ns = 0
        self._instant_ns = 0.0
        self._behind = self._hurried = self._odd = 0

    def add(self, stamp_ns: int) -> float:
        """Instant [ns] of the sample with this stamp, never later than that."""
        step, self._last_ns = stamp_ns - self._last_ns, stamp_ns
        if not 0 <= step <= PAUSE_NS or self._odd > ANOTHER:
            self.period_ns = math.inf
            self._steps.clear()
            self._begin(stamp_ns)
        elif self.period_ns == math.inf:
            self._steps.append(step)
            if len(self._steps) == FIRST:
                self.period_ns = float(statistics.median(self._steps))
                self._spread = REGULAR * self.period_ns
                self._worth = float(FIRST)
            self._begin(stamp_ns)
        else:
            self._measure(step)
            periods = self._periods(stamp_ns, step)
            expected = self._instant_ns + periods * self.period_ns
            delay = stamp_ns - expected
            self._instant_ns = expected + min(delay, LEAK * self.period_ns)
            self._judge(delay)
        return self._instant_ns

    def _begin(self, stamp_ns: int) -> None:
        self._instant_ns = float(stamp_ns)
        self._behind = self._hurried = self._odd = 0

    def _judge(self, delay: float) -> None:
        """Samples that come too late, and then, closer together, come back to the pace: that is how lateness looks."""
        if delay > 1.5 * self.period_ns:
            self._away = True
        elif self._away and delay < 0.5 * self.period_ns:
            self._away = False
            self.returns += self._hurried == HURRIED and self._spread < SHARP * self.period_ns

    def _measure(self, step: int) -> None:
        off = step - self.period_ns
        regular = abs(off) < min(4.0 * self._spread, REGULAR * self.period_ns)
        self._odd = max(0, self._odd + (-1 if regular else 1))
        if regular:
            self._worth = min(self._worth + 1.0, WORTH)
            self.period_ns += off / self._worth
            self._spread += (max(abs(off), LEAST * self.period_ns) - self._spread) / self._worth
        else:
            self._spread += min(self._spread, REGULAR * self.period_ns) / WORTH

    def _periods(self, stamp_ns: int, step: float) -> int:
        """How many passed since the sample before: one, but for samples lost or wrongly taken for lost."""
        period = self.period_ns
        gap = (stamp_ns - self._instant_ns) / period
        whole = round(gap)
        if step < HURRY * period:
            self._hurried = HURRIED
        elif self._hurried:
            self._hurried -= 1
        elif step > 1.5 * period and abs(gap - whole) < min(WHOLE, 4.0 * self._spread / period):
            self._behind = 0
            return whole
        self._behind = self._behind + 1 if gap > 1.5 and step > HURRY * period else 0
        if self._behind < CONSECUTIVE:
            return min(math.floor(gap + 0.3), 1)  # earlier than possible
        self._behind = 0
        return whole


@compiled
def follow(state: Array, instant_ns: float, deflection: float) -> float:
    """How far a sample is from where constant speed lets it be expected [m]: an alpha-beta filter over one choice of
    instants. state: last instant [ns], place [m], speed [m/s]."""
    dt = (instant_ns - state[0]) * 1e-9
    state[0] = instant_ns
    if not 0.0 <= dt < 5.0 * FOLLOW:
        state[1] = deflection
        state[2] = 0.0
        return 0.0
    off = deflection - (state[1] + state[2] * dt)
    kept = np.exp(-dt / FOLLOW)
    state[1] = deflection - kept * kept * off
    state[2] += (1.0 - kept) * (1.0 - kept) / max(dt, 1e-4) * off
    return float(off)


@compiled
def compare(stamped: Array, paced: Array, stamp_ns: float, instant_ns: float, deflection: float) -> float:
    """By how much the instants explain the deflection better than the stamps do [m^2]."""
    return float(follow(stamped, stamp_ns, deflection) ** 2 - follow(paced, instant_ns, deflection) ** 2)


class SampleClock:
    """Instants of samples: their stamps, or the pace behind them where the motion bears it out."""

    def __init__(self) -> None:
        """Stamps are believed at first."""
        self._pace = Pace()
        self._stamped, self._paced = np.zeros(3), np.zeros(3)
        self._worth = self._gain = self._spread = 0.0  # leaky sums of what the pace explains better, and of its square
        self._origin_ns = self._instant_ns = 0
        self.paced = False
        self._proven = False  # by the motion, one way or the other

    def add(self, stamp_ns: int, deflection: float) -> int:
        """Instant [ns] of a sample of deflection [m]; strictly increasing as the stamps do."""
        if not self._origin_ns:
            self._origin_ns = stamp_ns
        instant_ns = self._pace.add(stamp_ns)
        self._weigh(stamp_ns, instant_ns, deflection)
        chosen = round(instant_ns) if self.paced else stamp_ns
        self._instant_ns = max(chosen, self._instant_ns + 1) if stamp_ns > self._instant_ns else stamp_ns
        return self._instant_ns

    def _weigh(self, stamp_ns: int, instant_ns: float, deflection: float) -> None:
        since, origin_ns = float(stamp_ns - self._origin_ns), self._origin_ns
        gain = compare(self._stamped, self._paced, since, instant_ns - origin_ns, deflection)
        kept = 1.0 - FORGET
        if gain == 0.0:
            return
        if self._worth > BOLDEST:
            limit = BOLDEST * math.sqrt(self._spread / self._worth)
            gain = max(-limit, min(limit, gain))
        self._worth = kept * self._worth + 1.0
        self._gain = kept * self._gain + gain
        self._spread = kept * self._spread + gain * gain
        if self._gain * self._gain > EVIDENCE * EVIDENCE * self._spread:
            self.paced, self._proven = self._gain > 0.0, True
        elif not self._proven:
            self.paced = self._pace.returns >= RETURNS
