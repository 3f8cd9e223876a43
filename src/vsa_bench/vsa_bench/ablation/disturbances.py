# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings with rare conditions: faults of stamps and sensors, a heavy rod, the force_rate formulation after them."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from vsa_bench.ablation.recordings import SEED, Recording, simulated
from vsa_bench.estimation.cases import case
from vsa_bench.estimation.recordings import RESOLUTION

Disturbance = Callable[[Recording, np.random.Generator], Recording]
MILLISECOND = 1_000_000  # [ns]
QUEUED_NS = 40_000  # between queued samples that are delivered together


def with_delays(healthy: Recording, random: np.random.Generator) -> Recording:
    """Stamps of a busy host: an exponential delay of each; 8 stalls a second, of 8 ms in the mean, the first of 250 ms.

    The samples of a stall follow together after it.
    """
    stamps_ns = healthy.stamps_ns + _exponential(random, len(healthy.stamps_ns), 0.1)
    count = round(8.0 * healthy.time[-1])
    stalls_ns = _exponential(random, count, 8.0)
    stalls_ns[0] = 250 * MILLISECOND
    for begin, stall_ns in zip(_places(stamps_ns, count), stalls_ns, strict=True):
        end_ns = stamps_ns[begin] + stall_ns
        queued = slice(begin, int(np.searchsorted(stamps_ns, end_ns)))
        stamps_ns[queued] = end_ns + QUEUED_NS * np.arange(queued.stop - begin)
    return replace(healthy, stamps_ns=_ordered(stamps_ns))


def with_jitter(healthy: Recording, random: np.random.Generator) -> Recording:
    """Delays of half a period with single losses, off the grid of the clock; from the middle on half the rate."""
    period_ms = float(np.median(np.diff(healthy.stamps_ns))) / MILLISECOND
    late_ns = _exponential(random, len(healthy.stamps_ns), 0.5 * period_ms)
    jittered = replace(healthy, stamps_ns=_ordered(healthy.stamps_ns + late_ns))
    received = random.random(len(late_ns)) > 0.02
    received[len(received) // 2 :: 2] = False
    return jittered.selected(received)


def with_losses(healthy: Recording, random: np.random.Generator) -> Recording:
    """Delays as those of `with_delays`, single losses, and runs of 2 to 120 lost samples."""
    received = random.random(len(healthy.force)) > 0.01
    for begin, length in zip(_places(healthy.stamps_ns, 10), np.geomspace(2, 120, 10).astype(int), strict=True):
        received[begin : begin + length] = False
    return with_delays(healthy, random).selected(received)


def with_bursts(healthy: Recording, random: np.random.Generator) -> Recording:
    """Stamps on reception: queues of 6 to 120 ms are delivered with the stamps of their delivery."""
    stamps_ns = healthy.stamps_ns.copy()
    for begin, length_ms in zip(_places(stamps_ns, 8), np.geomspace(6.0, 120.0, 8), strict=True):
        end = int(np.searchsorted(stamps_ns, stamps_ns[begin] + round(length_ms * MILLISECOND)))
        stamps_ns[begin:end] = stamps_ns[end] - QUEUED_NS * np.arange(end - begin, 0, -1)
    return replace(healthy, stamps_ns=stamps_ns)


def with_stuck_sensors(healthy: Recording, random: np.random.Generator) -> Recording:
    """Each sensor repeats a value for 0.06, 0.3 and 1 s."""
    force, deflection = healthy.force.copy(), healthy.deflection.copy()
    places = _places(healthy.stamps_ns, 6)
    for number, (begin, seconds) in enumerate(zip(places, (0.06, 0.06, 0.3, 0.3, 1.0, 1.0), strict=True)):
        signal = (force, deflection)[number % 2]
        signal[_window(healthy, begin, seconds)] = signal[begin]
    return replace(healthy, force=force, deflection=deflection)


def with_noise(healthy: Recording, random: np.random.Generator) -> Recording:
    """Noise of 5, 20 and 100 times the usual for 0.5 s, of each sensor in turn."""
    force, deflection = healthy.force.copy(), healthy.deflection.copy()
    for number, (begin, factor) in enumerate(
        zip(_places(healthy.stamps_ns, 6), (5.0, 5.0, 20.0, 20.0, 100.0, 100.0), strict=True)
    ):
        signal, std = ((force, 0.017), (deflection, RESOLUTION))[number % 2]
        noisy = signal[_window(healthy, begin, 0.5)]
        noisy += factor * std * random.standard_normal(noisy.size)
    return replace(healthy, force=force, deflection=np.round(deflection / RESOLUTION) * RESOLUTION)


def with_steps(healthy: Recording, random: np.random.Generator) -> Recording:
    """The encoder steps by 0.1 to 2 mm, to both sides; the last step is taken back after 0.3 s."""
    deflection = healthy.deflection.copy()
    for begin, step in zip(_places(healthy.stamps_ns, 5), (1e-4, -3e-4, 1e-3, -2e-3, 5e-4), strict=True):
        deflection[begin:] += step
    deflection[_window(healthy, begin, 0.3).stop :] -= step
    return replace(healthy, deflection=deflection)


def with_bad_values(healthy: Recording, random: np.random.Generator) -> Recording:
    """No numbers, impossible values, outliers, late samples, a stamp of zero, silences, a clock set back by 5 s."""
    stamps_ns, force, deflection = healthy.stamps_ns.copy(), healthy.force.copy(), healthy.deflection.copy()
    places = _places(stamps_ns, 18)
    force[places[0]], deflection[places[1]] = np.nan, np.inf
    force[places[2]], deflection[places[3]] = 1e4, 1.0
    for length, begin in enumerate(places[4:8], 1):  # outliers in a row
        force[begin : begin + length] += 0.3 * length
    for length, begin in enumerate(places[8:12], 1):
        deflection[begin : begin + length] += 2e-4 * length
    for begin, silence_ms in zip(places[12:15], (120, 400, 1500), strict=True):
        stamps_ns[begin:] += silence_ms * MILLISECOND
    stamps_ns[places[15] :] -= 5_000 * MILLISECOND
    instants_ns = stamps_ns = stamps_ns + 10_000 * MILLISECOND
    stamps_ns = stamps_ns.copy()
    stamps_ns[places[16]] = 0
    stamps_ns[places[17] : places[17] + 60] -= 200 * MILLISECOND
    return replace(healthy, stamps_ns=stamps_ns, instants_ns=instants_ns, force=force, deflection=deflection)


def with_force_errors(healthy: Recording, random: np.random.Generator) -> Recording:
    """An outlier, a shift of 3 N that lasts, and a silence of 1.5 s."""
    force, count = healthy.force.copy(), len(healthy.force)
    force[count // 3] += 30.0
    force[count // 2 :] += 3.0
    silence_ns = 1500 * MILLISECOND * (np.arange(count) > 3 * count // 4)
    return replace(healthy, force=force, stamps_ns=healthy.stamps_ns + silence_ns)


DISTURBANCES: dict[str, tuple[Disturbance, str, int]] = {  # motion and rate [Hz]
    "delays": (with_delays, "multisine", 500),
    "jitter": (with_jitter, "fast", 500),
    "losses": (with_losses, "multisine", 500),
    "bursts": (with_bursts, "multisine", 500),
    "stuck sensors": (with_stuck_sensors, "multisine", 200),
    "noise": (with_noise, "fast", 200),
    "steps": (with_steps, "multisine", 100),
    "bad values": (with_bad_values, "multisine", 500),
}
ESTIMATED = ("bursts", "stuck sensors", "noise", "steps", "bad values")  # those for the whole estimator
SECONDS = 8.0


HEAVY = case(motion="multisine", mass="heavy", start="good")
FRICTIONLESS = case(motion="slow", coulomb_friction_n=0.0, start="good")  # force_rate requires it


def disturbed(name: str, seconds: float) -> Recording:
    """The recording of one of DISTURBANCES."""
    disturb, motion, rate_hz = DISTURBANCES[name]
    healthy = simulated(case(motion=motion, rate_hz=rate_hz, start="good"), "force", seconds)
    return replace(disturb(healthy, np.random.default_rng(SEED)), name=name)


def rare_conditions(seconds: float | None = None) -> Iterator[Recording]:
    """Recordings for the whole estimator: ESTIMATED, HEAVY and FRICTIONLESS, of `seconds` [s]."""
    for name in ESTIMATED:
        yield disturbed(name, seconds or SECONDS)
    yield replace(simulated(HEAVY, "force", seconds or SECONDS), name="heavy rod")
    healthy = simulated(FRICTIONLESS, "force_rate", seconds or SECONDS)
    yield replace(with_force_errors(healthy, np.random.default_rng(SEED)), name="force_rate")


def _exponential(random: np.random.Generator, count: int, mean_ms: float) -> NDArray[np.int64]:
    return np.asarray((mean_ms * MILLISECOND * random.standard_exponential(count)).astype(np.int64))


def _ordered(stamps_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Stamps of samples that are delivered in order, QUEUED_NS apart at least."""
    queued = QUEUED_NS * np.arange(len(stamps_ns))
    return np.asarray(np.maximum.accumulate(stamps_ns - queued) + queued)


def _places(stamps_ns: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """First samples of `count` faults, evenly over what follows the first fifth of a recording."""
    return np.asarray(np.linspace(0.2, 0.95, count + 1)[:-1] * len(stamps_ns), np.int64)


def _window(recording: Recording, begin: int, seconds: float) -> slice:
    return slice(begin, int(np.searchsorted(recording.stamps_ns, recording.stamps_ns[begin] + seconds * 1e9)))
