# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion profiles: rod deflection over time, for configuration files and for the integrator."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.config.configuration import ConfigurationError, choice, quantities, quantity

Table = NDArray[np.float64]

TONES, CHIRP, RAMP, DWELLS = range(4)
NO_END = 1e12  # end of an unlimited tone [s]


class Tone(NamedTuple):
    """amplitude [m] times sin(2 pi frequency [Hz] t + phase [rad]), from `start` to `end` [s]."""

    amplitude: float
    frequency: float
    phase: float = 0.0
    start: float = 0.0
    end: float = NO_END


class Motion(NamedTuple):
    """Rod deflection about `centre` [m]: tones, or another kind; the columns of `table` depend on the kind."""

    centre: float
    kind: int
    table: Table
    fade_in: float


def tones(centre: float, *parts: Tone, fade_in: float = 8.0) -> Motion:
    """Sum of tones about `centre` [m]; each fades in over `fade_in` [s] and out over half of it."""
    return Motion(centre, TONES, np.array(parts, float).reshape(-1, len(Tone._fields)), fade_in)


def chirp(centre: float, amplitude: float, low: float, high: float, sweep: float, fade_in: float = 8.0) -> Motion:
    """Sine of `amplitude` [m], its frequency swept from `low` to `high` [Hz] within `sweep` [s], and back."""
    return Motion(centre, CHIRP, np.array([[amplitude, low, high, sweep]]), fade_in)


def ramp(centre: float, amplitude: float, frequency: float, fade_in: float = 8.0) -> Motion:
    """Triangle wave of `frequency` [Hz] between centre -+ amplitude [m]."""
    return Motion(centre, RAMP, np.array([[amplitude, frequency]]), fade_in)


def dwells(positions: tuple[float, ...], move: float = 4.0, rest: float = 11.0) -> Motion:
    """Minimum-jerk moves of `move` [s] between positions [m], `rest` [s] at each, repeated without end."""
    rows = [(one, move, rest) for one in positions]
    return Motion(positions[0], DWELLS, np.array(rows, float), 0.0)


@compiled
def position(time: float, motion: Motion) -> float:
    """Deflection [m] at `time` [s]."""
    table = motion.table
    if motion.kind == DWELLS:
        return minimum_jerk(time, table)
    if motion.kind == CHIRP:
        wave = table[0, 0] * math.sin(2.0 * math.pi * chirp_cycles(time, table[0, 1], table[0, 2], table[0, 3]))
        return motion.centre + fade(time, motion.fade_in) * wave
    if motion.kind == RAMP:
        phase = (time * table[0, 1] + 0.25) % 1.0
        return motion.centre + fade(time, motion.fade_in) * table[0, 0] * (1.0 - 4.0 * abs(phase - 0.5))
    deflection = motion.centre
    for i in range(table.shape[0]):
        envelope = fade(time - table[i, 3], motion.fade_in) * fade(table[i, 4] - time, 0.5 * motion.fade_in)
        deflection += envelope * table[i, 0] * math.sin(2.0 * math.pi * table[i, 1] * time + table[i, 2])
    return deflection


@compiled
def chirp_cycles(time: float, low: float, high: float, sweep: float) -> float:
    """Phase [cycles] since time 0 of a sine swept from `low` to `high` [Hz] within `sweep` [s], and back."""
    whole = max(time, 0.0) // (2.0 * sweep)
    part = max(time, 0.0) - whole * 2.0 * sweep
    cycles = whole * (low + high) * sweep
    if part <= sweep:
        return cycles + low * part + (high - low) * part * part / (2.0 * sweep)
    back = 2.0 * sweep - part
    return cycles + (low + high) * sweep - low * back - (high - low) * back * back / (2.0 * sweep)


@compiled
def minimum_jerk(time: float, table: Table) -> float:
    """Deflection [m] at `time` [s] of the moves between the positions in `table`."""
    period = table[0, 1] + table[0, 2]
    index = int(max(time, 0.0) // period)
    begin, end = table[index % table.shape[0], 0], table[(index + 1) % table.shape[0], 0]
    part = min((max(time, 0.0) - period * index) / table[0, 1], 1.0)
    return begin + (end - begin) * part**3 * (10.0 - 15.0 * part + 6.0 * part * part)


@compiled
def fade(time: float, duration: float) -> float:
    """Envelope: 0 before time 0, 1 after `duration`, a cubic between."""
    if duration <= 0.0:
        return 1.0 if time >= 0.0 else 0.0
    part = min(max(time / duration, 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


@dataclass(frozen=True)
class ProfileConfig:
    """Commanded deflection of rod 1; that of rod 2 follows from the balance of forces at a constant joint angle."""

    kind: str = choice(
        "multisine", ("hold", "sine", "multisine", "chirp", "ramp", "dwells"), "motion of rod 1 without commands"
    )
    centre: float = quantity(0.0105, "m", 0.001, 0.019, "centre of the motion; the position of `hold`")
    amplitudes: tuple[float, ...] = quantities(
        (0.004, 0.00016, 0.00008), "m", 0.0, 0.01, "one a tone; the first is also that of sine, chirp and ramp"
    )
    frequencies: tuple[float, ...] = quantities(
        (0.05, 0.7, 1.7), "Hz", 1e-4, 50.0, "one a tone; chirp sweeps from the first to the last"
    )
    phases: tuple[float, ...] = quantities((0.0, 1.3, 2.6), "rad", -7.0, 7.0, "one a tone")
    sweep: float = quantity(20.0, "s", 0.1, 3600.0, "time in which chirp reaches its last frequency")
    places: tuple[float, ...] = quantities(
        (0.010, 0.013, 0.007, 0.012, 0.008), "m", 0.001, 0.019, "deflections of dwells in their order"
    )
    move_time: float = quantity(4.0, "s", 0.1, 100.0, "time of one move of dwells")
    rest_time: float = quantity(11.0, "s", 0.0, 1000.0, "rest after each move of dwells")
    fade_in: float = quantity(2.0, "s", 0.0, 100.0, "time in which the motion grows to its amplitude")


def motion_from(config: ProfileConfig) -> Motion:
    """The motion of a profile. Raises ConfigurationError for lists of different lengths."""
    amplitude, centre, fade_in = config.amplitudes[0], config.centre, config.fade_in
    if config.kind == "hold":
        return tones(centre)
    if config.kind == "sine":
        return tones(centre, Tone(amplitude, config.frequencies[0], config.phases[0]), fade_in=fade_in)
    if config.kind == "chirp":
        return chirp(centre, amplitude, config.frequencies[0], config.frequencies[-1], config.sweep, fade_in)
    if config.kind == "ramp":
        return ramp(centre, amplitude, config.frequencies[0], fade_in)
    if config.kind == "dwells":
        return dwells(config.places, config.move_time, config.rest_time)
    if not len(config.amplitudes) == len(config.frequencies) == len(config.phases):
        raise ConfigurationError(
            f"profile.amplitudes, frequencies and phases: {len(config.amplitudes)}, {len(config.frequencies)} and "
            f"{len(config.phases)} values, expected as many of each"
        )
    parts = zip(config.amplitudes, config.frequencies, config.phases, strict=True)
    return tones(centre, *(Tone(*part) for part in parts), fade_in=fade_in)
