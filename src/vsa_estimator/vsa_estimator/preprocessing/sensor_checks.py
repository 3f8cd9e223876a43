"""Signs that a sensor is in trouble, looked for in every raw sample; what they remember lies in arrays."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array

STUCK_FORCE_TIME = 0.3  # a force that repeats itself for this long while the rod moves is stuck [s]
STUCK_ENCODER_TIME = 0.5  # an encoder that does so while the force changes [s]
QUIET_ENCODER_TIME = 0.15  # an encoder that repeats itself for this long is at rest or stuck [s]
FROZEN_TIME = 0.03  # a flickering encoder that repeats itself for this long, and against all odds, is stuck [s]
ODDS = 25.0  # natural logarithm of those odds
FLICKER = 0.1  # share of samples at which a flickering encoder turns round
MEMORY = 500.0  # samples over which flicker is looked for

WORTH = 20.0  # samples over which noise is looked at
LOUD = 9.0  # variance, in units of the usual one, that counts as louder
RINGING = 4.0  # times the steepest slope of late, from sample to sample
FADED = 0.25  # of the slope from which on a rod may ring, below which it no longer does
SHARE = 0.35  # of loud samples from which on the noise is
MUCH = 30.0  # times its usual noise, from which on an encoder is not believed at all
MOST = 1e6  # that one sample says of the variance, in units of the usual one

HURRY = 0.3  # of the usual interval, below which a sample belongs to a burst
BURST_WORTH = 50.0  # samples
LONGEST = 45e6  # samples of this time may come at once; a busy sender catches up [ns]
FEWEST = 12
CLOSE = 20e6  # of samples close together are told, for what they may hide [ns]
SHORT_PERIOD = 2e6  # slopes from which on a rod may ring are those a sample; where it takes longer, so long [ns]

FORCE_REPEATED, FORCE_STUCK, ENCODER_QUIET, ENCODER_STUCK, ENCODER_FROZEN = 1, 2, 4, 8, 16
FORCE_NOISY, ENCODER_NOISY, BURST, FORCE_SATURATED, DEFLECTION_SATURATED, DEAFENING = 32, 64, 128, 256, 512, 1024
BLINDED = 2048  # the encoder is not to be believed
HURRIED = 16384  # samples come close together
BLINDING = ENCODER_FROZEN | ENCODER_STUCK | DEFLECTION_SATURATED | DEAFENING | BURST
BURST_NS = 50e6  # nor for so long after a burst of samples

# What is usual of the sensors, in the array that `examine` takes.
FORCE_STD, DEFLECTION_STD = 0, 1  # of the white noise [N, m]
BRISK_FORCE, BRISK_DEFLECTION = 2, 3  # slopes from which on a rod may ring [N, m a sample]
FORCE_TRAVEL, DEFLECTION_TRAVEL = 4, 5  # more than a stuck other sensor explains [N, m]
FORCE_LIMIT, DEFLECTION_LIMIT = 6, 7  # [N, m]
LIMITS = 8


def nothing_seen() -> Array:
    """Memory of `examine` before the first sample: of both constancies, both noises, the pace; until when the encoder
    is not to be believed [ns], and the noises of force and deflection, 1 for usual."""
    return np.concatenate([no_value(), no_value(), no_noise(), no_noise(), np.zeros(4), [0.0, 1.0, 1.0]])


def no_value() -> Array:
    """Memory of `constancy`: value, since when [ns], least and greatest of the other meanwhile, how often it has been
    repeated, leaky shares of samples that repeat the one before and that take the last change back, whether it rose."""
    return np.array([math.nan, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])


def no_noise() -> Array:
    """Memory of `noisiness`: last value, the one before, second difference, slope a sample (leaky mean), the steepest
    of late, whether the rod rings, leaky share of loud samples, variance in units of the usual one."""
    return np.array([math.nan, math.nan, math.nan, 0.0, 0.0, 0.0, 0.0, 1.0])


@compiled
def constancy(memory: Array, stamp_ns: int, value: float, other: float) -> bool:
    """Take one sample of a value and another; whether the value repeats itself."""
    repeated = value == memory[0]
    memory[4] = memory[4] + 1.0 if repeated else 0.0
    memory[5] += ((1.0 if repeated else 0.0) - memory[5]) / MEMORY
    turned = 0.0
    if not repeated and memory[0] == memory[0]:
        rose = 1.0 if value > memory[0] else 0.0
        turned = 1.0 if rose != memory[7] else 0.0
        memory[7] = rose
    memory[6] += (turned - memory[6]) / MEMORY
    if not repeated:
        memory[0], memory[1], memory[2], memory[3] = value, stamp_ns, other, other
    elif other < memory[2]:
        memory[2] = other
    elif other > memory[3]:
        memory[3] = other
    return bool(repeated)


@compiled
def frozen(memory: Array, stamp_ns: int) -> bool:
    """Whether a value that used to flicker at rest, too, has ceased to."""
    return bool(
        memory[6] > FLICKER
        and memory[4] * -np.log(min(memory[5], 0.999)) > ODDS
        and stamp_ns - memory[1] > FROZEN_TIME * 1e9
    )


@compiled
def noisiness(memory: Array, value: float, std: float, brisk: float, undamped: bool) -> float:
    """How much louder a sensor's white noise is than its standard deviation `std`, within a few samples; 1: not.

    Second differences of white noise take each other back, those of a motion do not: their products tell them apart.
    Beyond v* nothing damps a rod: after a motion of slope `brisk` a sample, or while it is known to be `undamped`, it
    rings with its tendon. That is not held against the sensor.
    """
    last, steepest = memory[0], memory[4]
    difference = value - 2.0 * last + memory[1]
    rings = undamped or steepest > (FADED if memory[5] > 0.0 else 1.0) * brisk
    ringing = RINGING * max(steepest, brisk if undamped else 0.0) if rings else 0.0
    product = -difference * memory[2] / (4.0 * (std * std + ringing * ringing))
    memory[0], memory[1], memory[2], memory[5] = value, last, difference, 1.0 if rings else 0.0
    if product != product:
        return 1.0
    memory[3] += (value - last - memory[3]) / WORTH
    memory[4] = max(abs(memory[3]), steepest * (1.0 - 0.05 / WORTH))
    memory[6] += ((1.0 if product > LOUD else 0.0) - memory[6]) / WORTH
    memory[7] += (min(max(product, 0.0), MOST) - memory[7]) / WORTH
    return float(np.sqrt(max(memory[7], 1.0))) if memory[6] > SHARE else 1.0


@compiled
def burst(memory: Array, stamp_ns: int) -> int:
    """HURRIED once in a run of samples that come at once; BURST where it is too long: they queued up on their way.

    memory: last stamp [ns], usual interval [ns], stamps seen, run.
    """
    step = stamp_ns - memory[0]
    memory[0] = stamp_ns
    memory[2] += 1.0
    if memory[2] < 3.0:
        memory[1] = step
        return 0
    memory[3] = memory[3] + 1.0 if step < HURRY * memory[1] else 0.0
    worth = min(memory[2], BURST_WORTH) * (10.0 if memory[3] > 0.0 else 1.0)
    memory[1] += (min(step, 2.0 * memory[1]) - memory[1]) / worth
    if memory[3] >= FEWEST and memory[3] * memory[1] > LONGEST:
        return BURST
    return HURRIED if memory[3] == max(3.0, np.floor(CLOSE / memory[1]) + 1.0) else 0


@compiled
def examine(
    memory: Array, limits: Array, stamp_ns: int, force: float, deflection: float, undamped: bool, period_ns: float
) -> int:
    """Signs that one raw sample shows, added up; they come every `period_ns`."""
    brisk = max(1.0, period_ns / SHORT_PERIOD)
    forces, places, signs = memory[0:8], memory[8:16], 0
    if constancy(forces, stamp_ns, force, deflection):
        signs |= FORCE_REPEATED
        if stamp_ns - forces[1] > STUCK_FORCE_TIME * 1e9 and forces[3] - forces[2] > limits[DEFLECTION_TRAVEL]:
            signs |= FORCE_STUCK
    if constancy(places, stamp_ns, deflection, force):
        silence = stamp_ns - places[1]
        if silence > QUIET_ENCODER_TIME * 1e9:
            signs |= ENCODER_QUIET
        if silence > STUCK_ENCODER_TIME * 1e9 and places[3] - places[2] > limits[FORCE_TRAVEL]:
            signs |= ENCODER_STUCK
        if frozen(places, stamp_ns):
            signs |= ENCODER_FROZEN
    memory[-2] = noisiness(memory[16:24], force, limits[FORCE_STD], brisk * limits[BRISK_FORCE], undamped)
    memory[-1] = noisiness(memory[24:32], deflection, limits[DEFLECTION_STD], brisk * limits[BRISK_DEFLECTION], False)
    if memory[-2] > 1.0:
        signs |= FORCE_NOISY
    if memory[-1] > 1.0:
        signs |= ENCODER_NOISY
    if memory[-1] > MUCH:
        signs |= DEAFENING
    hurry = burst(memory[32:36], stamp_ns)
    signs |= hurry
    if hurry == BURST:
        memory[-3] = stamp_ns + BURST_NS
    if abs(force) >= limits[FORCE_LIMIT]:
        signs |= FORCE_SATURATED
    if abs(deflection) >= limits[DEFLECTION_LIMIT]:
        signs |= DEFLECTION_SATURATED
    if signs & BLINDING or stamp_ns < memory[-3]:
        signs |= BLINDED
    return signs
