# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings with faults of stamps and sensors: delays, bursts, losses, stuck, noisy and stepping sensors, bad values."""

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
    """Stamps of a busy host: an exponential delay of each, and stalls of 4 to 250 ms after which the queue follows."""
    stamps_ns = healthy.stamps_ns + _exponential(random, len(healthy.stamps_ns), 0.1)
    for begin, stall_ms in zip(_places(stamps_ns, 15), np.geomspace(4.0, 250.0, 15), strict=True):
        end_ns = stamps_ns[begin] + round(stall_ms * MILLISECOND)
        queued = slice(begin, int(np.searchsorted(stamps_ns, end_ns)))
        stamps_ns[queued] = end_ns + QUEUED_NS * np.arange(queued.stop - begin)
    return replace(healthy, stamps_ns=_ordered(stamps_ns))


def with_jitter(healthy: Recording, random: np.random.Generator) -> Recording:
    """Delays of half a period with single losses: the stamps are off the grid of the sample clock."""
    period_ms = float(np.median(np.diff(healthy.stamps_ns))) / MILLISECOND
    late_ns = _exponential(random, len(healthy.stamps_ns), 0.5 * period_ms)
    jittered = replace(healthy, stamps_ns=_ordered(healthy.stamps_ns + late_ns))
    return jittered.selected(random.random(len(late_ns)) > 0.02)


def with_losses(healthy: Recording, random: np.random.Generator) -> Recording:
    """Single losses, runs of 2 to 120 lost samples, and every second sample lost in the last quarter."""
    count = len(healthy.force)
    received = random.random(count) > 0.01
    for begin, length in zip(_places(healthy.stamps_ns, 10), np.geomspace(2, 120, 10).astype(int), strict=True):
        received[begin : begin + length] = False
    received[3 * count // 4 :: 2] = False
    late_ns = _exponential(random, count, 0.02)
    return replace(healthy, stamps_ns=_ordered(healthy.stamps_ns + late_ns)).selected(received)


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
    """No numbers, impossible values, outliers, saturation, late samples, repeated stamps, silences, a clock set back."""
    stamps_ns, force, deflection = healthy.stamps_ns.copy(), healthy.force.copy(), healthy.deflection.copy()
    places = _places(stamps_ns, 18)
    force[places[0]], deflection[places[1]] = np.nan, np.inf
    force[places[2]], deflection[places[3]] = 1e4, 1.0
    for length, begin in enumerate(places[4:8], 1):  # outliers in a row
        force[begin : begin + length] += 0.3 * length
    for length, begin in enumerate(places[8:12], 1):
        deflection[begin : begin + length] += 2e-4 * length
    stamps_ns[places[12]] = 0
    stamps_ns[places[13] : places[13] + 60] -= 200 * MILLISECOND
    for begin, silence_ms in zip(places[14:17], (120, 400, 1500), strict=True):
        stamps_ns[begin:] += silence_ms * MILLISECOND
    stamps_ns[places[17] :] -= 5_000 * MILLISECOND
    return replace(healthy, stamps_ns=stamps_ns + 10_000 * MILLISECOND, force=force, deflection=deflection)


DISTURBANCES: dict[str, tuple[Disturbance, str, int, float]] = {  # motion, rate [Hz], seconds
    "delays": (with_delays, "multisine", 500, 6.0),
    "jitter": (with_jitter, "fast", 500, 4.0),
    "losses": (with_losses, "multisine", 500, 6.0),
    "bursts": (with_bursts, "multisine", 500, 5.0),
    "stuck sensors": (with_stuck_sensors, "multisine", 200, 9.0),
    "noise": (with_noise, "fast", 200, 8.0),
    "steps": (with_steps, "multisine", 100, 12.0),
    "bad values": (with_bad_values, "multisine", 500, 6.0),
}


def disturbed(seconds: float | None = None) -> Iterator[Recording]:
    """One recording for each of DISTURBANCES, of its own length or of `seconds` [s]."""
    for name, (disturb, motion, rate_hz, usual) in DISTURBANCES.items():
        healthy = simulated(case(motion=motion, rate_hz=rate_hz, start="good"), "force", seconds or usual)
        yield replace(disturb(healthy, np.random.default_rng(SEED)), name=name)


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
