"""When each sample was taken, from stamps that may be late.

A busy sender stamps a sample when it gets to it: stamps then bunch up behind the instants at which the sensor, paced by
its own clock, was read. The least delayed stamps show that pace (the lower envelope, as in one-way clock
synchronisation). Whether the sensor is paced at all is asked of the motion itself: the deflection runs smoothly over
the true instants, and over no others.
"""

import math

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


# What `pace` remembers, in an array.
PERIOD, INSTANT, LAST, SPREAD, INTERVALS, ODD, BEHIND, HURRIED_FOR, AWAY, RETURNED = range(10)
STEPS = 10  # from here on, while the period is not known


@compiled
def begin(memory: Array, stamp_ns: int) -> None:
    """Be in step with this stamp."""
    memory[INSTANT] = stamp_ns
    memory[BEHIND] = memory[HURRIED_FOR] = memory[ODD] = 0.0


@compiled
def measure(memory: Array, step: float) -> None:
    """The period is the mean of the regular intervals."""
    period, spread = memory[PERIOD], memory[SPREAD]
    off = step - period
    if abs(off) < min(4.0 * spread, REGULAR * period):
        memory[ODD] = max(0.0, memory[ODD] - 1.0)
        memory[INTERVALS] = min(memory[INTERVALS] + 1.0, WORTH)
        memory[PERIOD] += off / memory[INTERVALS]
        memory[SPREAD] += (max(abs(off), LEAST * memory[PERIOD]) - spread) / memory[INTERVALS]
    else:
        memory[ODD] += 1.0
        memory[SPREAD] += min(spread, REGULAR * period) / WORTH


@compiled
def periods(memory: Array, stamp_ns: int, step: float) -> float:
    """How many passed since the sample before: one, but for samples lost or wrongly taken for lost."""
    period = memory[PERIOD]
    gap = (stamp_ns - memory[INSTANT]) / period
    whole = np.rint(gap)
    if step < HURRY * period:
        memory[HURRIED_FOR] = HURRIED
    elif memory[HURRIED_FOR] > 0.0:
        memory[HURRIED_FOR] -= 1.0
    elif step > 1.5 * period and abs(gap - whole) < min(WHOLE, 4.0 * memory[SPREAD] / period):
        memory[BEHIND] = 0.0
        return float(whole)
    memory[BEHIND] = memory[BEHIND] + 1.0 if gap > 1.5 and step > HURRY * period else 0.0
    if memory[BEHIND] < CONSECUTIVE:
        return float(min(np.floor(gap + 0.3), 1.0))  # earlier than possible
    memory[BEHIND] = 0.0
    return float(whole)


@compiled
def return_from(memory: Array, delay: float) -> None:
    """Samples that come too late, and then, closer together, come back to the pace: that is how lateness looks."""
    if delay > 1.5 * memory[PERIOD]:
        memory[AWAY] = 1.0
    elif memory[AWAY] > 0.0 and delay < 0.5 * memory[PERIOD]:
        memory[AWAY] = 0.0
        if memory[HURRIED_FOR] == HURRIED and memory[SPREAD] < SHARP * memory[PERIOD]:
            memory[RETURNED] += 1.0


@compiled
def pace(memory: Array, stamp_ns: int) -> float:
    """Instant [ns] of the sample with this stamp by the sensor's own clock, never later than the stamp.

    That clock is the mean of its regular intervals, in step with its least delayed stamps.
    """
    step = stamp_ns - memory[LAST]
    memory[LAST] = stamp_ns
    if not 0.0 <= step <= PAUSE_NS or memory[ODD] > ANOTHER:
        memory[PERIOD], memory[INTERVALS] = np.inf, 0.0
        begin(memory, stamp_ns)
    elif memory[PERIOD] == np.inf:
        memory[STEPS + int(memory[INTERVALS])] = step
        memory[INTERVALS] += 1.0
        if memory[INTERVALS] == FIRST:
            memory[PERIOD] = np.median(memory[STEPS:])
            memory[SPREAD] = REGULAR * memory[PERIOD]
        begin(memory, stamp_ns)
    else:
        measure(memory, step)
        passed = periods(memory, stamp_ns, step)
        expected = memory[INSTANT] + passed * memory[PERIOD]
        delay = stamp_ns - expected
        memory[INSTANT] = expected + min(delay, LEAK * memory[PERIOD])
        return_from(memory, delay)
    return float(memory[INSTANT])


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
def compare(clock: Array, stamped: Array, paced: Array, stamp_ns: int, deflection: float) -> tuple[float, float]:
    """Instant [ns] by the pace, and by how much these instants explain the deflection better than the stamps [m^2].

    Stamps and instants are counted from the first sample.
    """
    instant_ns = pace(clock, stamp_ns)
    gain = follow(stamped, stamp_ns, deflection) ** 2 - follow(paced, instant_ns, deflection) ** 2
    return instant_ns, float(gain)


class SampleClock:
    """Instants of samples: their stamps, or the pace behind them where the motion bears it out."""

    def __init__(self) -> None:
        """Stamps are believed at first."""
        self._clock = np.zeros(STEPS + FIRST)
        self._clock[PERIOD], self._clock[LAST] = math.inf, -math.inf
        self._stamped, self._paced = np.zeros(3), np.zeros(3)
        self._worth = self._gain = self._spread = 0.0  # leaky sums of what the pace explains better, and of its square
        self._origin_ns = self._instant_ns = 0
        self.paced = False
        self._proven = False  # by the motion, one way or the other

    def add(self, stamp_ns: int, deflection: float) -> int:
        """Instant [ns] of a sample of deflection [m]; strictly increasing as the stamps do."""
        if not self._origin_ns:
            self._origin_ns = stamp_ns
        instant_ns, gain = compare(self._clock, self._stamped, self._paced, stamp_ns - self._origin_ns, deflection)
        self._weigh(gain)
        chosen = self._origin_ns + round(instant_ns) if self.paced else stamp_ns
        self._instant_ns = max(chosen, self._instant_ns + 1) if stamp_ns > self._instant_ns else stamp_ns
        return self._instant_ns

    def _weigh(self, gain: float) -> None:
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
            self.paced = self._clock[RETURNED] >= RETURNS
