"""When each sample was taken, from stamps that may be late.

A busy sender stamps a sample when it gets to it: stamps then bunch up behind the instants at which the sensor, paced by
its own clock, was read. The least delayed stamps show that pace (the lower envelope, as in one-way clock
synchronisation). Whether the sensor is paced at all is asked of the motion itself: the deflection runs smoothly over
the true instants, and over no others.
"""

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array

FIRST = 32  # intervals whose median is the first idea of the period
REGULAR = 0.3  # of a period: how far off a regular interval is at most
SHARP = 0.15  # of a period: scatter of regular intervals that is small enough to recognise a return to the pace
LEAST = 1e-3  # of a period: scatter of regular intervals at least
WORTH = 500.0  # intervals over which it is averaged
PAUSE_NS = 250e6  # after a longer silence the pace is learnt anew ...
ANOTHER = 100  # ... and after so many more samples that do not follow in it than half of those that do
SHORTEST, LONGEST = 16.0, 256.0  # samples of which the least delayed corrects the pace: few at first
SETTLED = 0.2  # of a period: drift over half of them, below which they become more
CORRECTION = 0.5  # share of the drift by which the period is corrected then; all of it before
MISTAKEN = 0.1  # of a period: a sample this much too early comes of a wrong count, not of a wrong period
WHOLE = 0.15  # of a period: a gap this close to a whole number of them is samples that were lost
ALIKE, RAGGED = 2.0, 14.0  # samples in turn behind by a whole number of periods: lost; more if stamps are ragged ...
PATIENCE_NS = 200e6  # ... or samples that stay behind for so long ...
FAR_NS = 40e6  # ... or by so much, and do not hurry; all the sooner, the more often it was loss
EPISODES = 16.0  # of being behind, over which that is learnt
RISE = 1.25  # a sample, of what is thought lost at least while more is lost
HURRY = 0.5  # of a period, below which samples are catching up ...
HURRIED = 1000  # ... and for so many more a gap is thought to be lateness
RETURNS = 2  # to the pace, after which it is believed where the motion does not tell
EVIDENCE = 4.0  # standard deviations of evidence at which the pace is believed, or the stamps again
FORGET = 5e-4  # of the evidence, with each sample
FOLLOW = 0.03  # [s]
BOLDEST = 10.0  # no sample says more, in standard deviations


# What `pace` remembers, in an array.
PERIOD, INSTANT, LAST, SPREAD, INTERVALS, ODD, HURRIED_FOR, AWAY, RETURNED = range(9)
BEHIND, BEHIND_BY, SAME, NEAREST = range(9, 13)  # samples in turn, periods at least, in turn by the same whole number
OFF_PACE, LOSSY = 13, 14  # shares: of samples; of the times behind, those by loss
COUNT, OF, EARLY, WRONG, DELAY = range(15, 20)  # of the samples that correct the pace; DELAY of either half
STEPS = 21  # from here on, while the period is not known

# What `instant` remembers in whole numbers [ns].
ORIGIN, LAST_INSTANT = range(2)
STAMPS = 2

# What `weigh` remembers: leaky sums of samples, of what the pace explains better, of its square; and who has proven it.
WORTH_OF, GAIN, SQUARES, PROVEN = range(4)


def no_instant() -> Array:
    """What `believed` remembers before the first stamp."""
    return np.concatenate([np.zeros(10), no_pace()])


def no_pace() -> Array:
    """What `pace` remembers before the first stamp."""
    memory = np.zeros(STEPS + FIRST)
    memory[PERIOD], memory[LAST] = np.inf, -np.inf
    return memory


@compiled
def begin(memory: Array, stamp_ns: int) -> None:
    """Be in step with this stamp."""
    memory[INSTANT] = stamp_ns
    memory[HURRIED_FOR] = memory[ODD] = 0.0
    memory[OF] = SHORTEST
    follow_up(memory)
    relock(memory)


@compiled
def relock(memory: Array) -> None:
    """Nothing is behind."""
    memory[BEHIND] = memory[SAME] = 0.0
    memory[BEHIND_BY] = np.inf


@compiled
def follow_up(memory: Array) -> None:
    """Look at the next samples."""
    memory[COUNT] = memory[EARLY] = memory[WRONG] = 0.0
    memory[DELAY] = memory[DELAY + 1] = np.inf


@compiled
def measure(memory: Array, step: float) -> None:
    """How regular the intervals are."""
    period, spread = memory[PERIOD], memory[SPREAD]
    off = abs(step - period)
    if off < min(4.0 * spread, REGULAR * period):
        memory[INTERVALS] = min(memory[INTERVALS] + 1.0, WORTH)
        memory[SPREAD] += (max(off, LEAST * period) - spread) / memory[INTERVALS]
    else:
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
        relock(memory)
        return float(whole)
    passed = min(np.floor(gap + 0.3), 1.0)  # earlier than possible: fewer
    behind = gap - passed
    nearest = np.rint(behind)
    on_pace = abs(behind - nearest) < WHOLE and (nearest == 0.0 or nearest == memory[NEAREST])
    memory[OFF_PACE] += ((0.0 if on_pace else 1.0) - memory[OFF_PACE]) / LONGEST
    if behind < 0.5:
        if memory[BEHIND] > 0.0 or passed < 1.0:
            memory[LOSSY] -= memory[LOSSY] / EPISODES
        relock(memory)
        return float(passed)
    memory[SAME] = memory[SAME] + 1.0 if on_pace else 0.0
    return float(passed + missed(memory, behind, step))


@compiled
def missed(memory: Array, behind: float, step: float) -> float:
    """How many samples were lost before one `behind` the pace [periods]: late ones catch up, lost ones do not."""
    period = memory[PERIOD]
    memory[NEAREST] = np.rint(behind)
    memory[BEHIND] += 1.0
    memory[BEHIND_BY] = min(RISE * memory[BEHIND_BY], behind)
    patience = (1.0 - memory[LOSSY]) ** 6
    lost = 0.0
    if memory[SAME] >= ALIKE + RAGGED * memory[OFF_PACE] * patience:
        lost = memory[NEAREST]
    elif step > HURRY * period and (
        memory[BEHIND] * period > PATIENCE_NS * patience
        or (memory[BEHIND] > ALIKE and memory[BEHIND_BY] * period > FAR_NS * patience)
    ):
        lost = np.rint(memory[BEHIND_BY])
    if lost > 0.0:
        memory[LOSSY] += (1.0 - memory[LOSSY]) / EPISODES
        relock(memory)
    return float(lost)


@compiled
def correct(memory: Array, delay: float) -> None:
    """In step with the least delayed stamps: a phase-locked loop on those of either half of some samples."""
    half = 0 if memory[COUNT] < 0.5 * memory[OF] else 1
    if delay < -MISTAKEN * memory[PERIOD]:
        memory[WRONG] = 1.0
    memory[DELAY + half] = min(memory[DELAY + half], delay - memory[EARLY])
    memory[EARLY] += max(-delay, 0.0)
    memory[COUNT] += 1.0
    if memory[COUNT] < memory[OF]:
        return
    drift = memory[DELAY + 1] - memory[DELAY]
    settled = abs(drift) < SETTLED * memory[PERIOD]
    if memory[WRONG] == 0.0 or memory[OF] == SHORTEST:
        memory[INSTANT] += max(0.0, memory[DELAY + 1] + memory[EARLY])
        period = memory[PERIOD] + (CORRECTION if settled else 1.0) * drift / (0.5 * memory[OF])
        memory[PERIOD] = max(period, 0.5 * memory[PERIOD])
    memory[OF] = min(2.0 * memory[OF], LONGEST) if settled else max(0.5 * memory[OF], SHORTEST)
    follow_up(memory)


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

    That clock is in step with its least delayed stamps.
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
        memory[ODD] = max(0.0, memory[ODD] - 0.5) if passed == 1.0 else memory[ODD] + 1.0
        expected = memory[INSTANT] + passed * memory[PERIOD]
        delay = stamp_ns - expected
        memory[INSTANT] = min(expected, stamp_ns)
        return_from(memory, delay)
        correct(memory, delay)
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
def weigh(evidence: Array, gain: float, returned: float) -> bool:
    """Whether to believe the pace, after a sample that it explains better than its stamp by `gain` [m^2]."""
    if gain != 0.0:
        if evidence[WORTH_OF] > BOLDEST:
            limit = BOLDEST * np.sqrt(evidence[SQUARES] / evidence[WORTH_OF])
            gain = max(-limit, min(limit, gain))
        evidence[:PROVEN] *= 1.0 - FORGET
        evidence[WORTH_OF] += 1.0
        evidence[GAIN] += gain
        evidence[SQUARES] += gain * gain
        if evidence[GAIN] * evidence[GAIN] > EVIDENCE * EVIDENCE * evidence[SQUARES]:
            evidence[PROVEN] = np.sign(evidence[GAIN])
    return bool(evidence[PROVEN] > 0.0 or (evidence[PROVEN] == 0.0 and returned >= RETURNS))


@compiled
def believed(memory: Array, stamp_ns: int, deflection: float) -> int:
    """Instant [ns] of a sample of `deflection` [m]: its stamp, or the pace behind it where the motion bears it out.

    Both are counted from the first sample. memory: of `weigh`, of `follow` for stamps and for the pace, of `pace`.
    """
    instant_ns = pace(memory[10:], stamp_ns)
    gain = follow(memory[4:7], stamp_ns, deflection) ** 2 - follow(memory[7:10], instant_ns, deflection) ** 2
    return round(instant_ns) if weigh(memory[:4], gain, memory[10 + RETURNED]) else stamp_ns


@compiled
def instant(memory: Array, stamps: NDArray[np.int64], stamp_ns: int, deflection: float) -> int:
    """Instant [ns] of a sample of deflection [m]; strictly increasing as the stamps do.

    memory: of `believed`; stamps: the first one, the last instant.
    """
    if not stamps[ORIGIN]:
        stamps[ORIGIN] = stamp_ns
    found = stamps[ORIGIN] + believed(memory, stamp_ns - stamps[ORIGIN], deflection)
    if stamp_ns <= stamps[LAST_INSTANT]:
        found = stamp_ns
    elif found <= stamps[LAST_INSTANT]:
        found = stamps[LAST_INSTANT] + 1
    stamps[LAST_INSTANT] = found
    return int(found)
