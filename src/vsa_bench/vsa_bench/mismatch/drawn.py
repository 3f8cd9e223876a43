# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases drawn at random: several laws and sensors that differ from the paper's at once, in motions of their own."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from vsa_bench.mismatch.cases import DRAWN_GROUP, Row
from vsa_common.types import Array
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.dampers import CUBIC, DAMPERS, DamperConfig
from vsa_simulator.laws.friction import FRICTIONS, FrictionConfig
from vsa_simulator.laws.internal import HysteresisConfig, ViscoelasticConfig
from vsa_simulator.laws.springs import EXPONENTIAL, SPRINGS, SpringConfig
from vsa_simulator.rig.config import SensorErrorConfig
from vsa_simulator.rig.motion import Motion, Tone, dwells, tones
from vsa_simulator.rig.recording import TransmissionVariant

# Ranges of the error of a sensor, in SI; two of them at most.
ERRORS = {
    "force_delay": (1e-3, 10e-3),
    "force_lowpass": (15.0, 60.0),
    "encoder_cyclic": (3e-6, 20e-6),
    "force_hysteresis": (0.02, 0.15),
    "force_drift": (-0.3, 0.3),
    "crosstalk": (5e-3, 2e-2),
}
MAX_ERRORS = 2
# Ranges of the parameters of the laws, in SI, logarithmic.
SPRING = {
    "initial_slope": (0.05, 0.3),
    "sinh_rate": (3.0, 6.0),
    "stop_ratio": (1.07, 1.3),
    "softening_rate": (0.7, 2.5),
}
DAMPER = {"rest_ratio": (0.1, 0.5)}
FRICTION = {
    "smoothing_speed": (1e-5, 1e-4), "dip": (0.3, 1.5), "dip_speed": (0.1e-3, 1e-3),
    "bristle_stiffness": (3e5, 3e6), "static_ratio": (1.1, 2.0), "stribeck_speed": (0.05e-3, 0.5e-3),
}  # fmt: skip
VISCOELASTIC = {"share": (0.05, 0.3), "time_constant": (0.2, 10.0)}
HYSTERESIS = {"amplitude": (0.1, 1.0), "travel": (0.1e-3, 2e-3)}
MEMORY_SHARE = 0.1  # of the cases that have a viscoelastic branch, and of those with hysteresis
JITTER, JITTER_SHARE = 1e-3, 0.2  # of the stamps [s], and the share of the cases that have it
CENTRE, STROKE = (0.006, 0.014), (0.002, 0.018)  # centre of a motion, and its limits [m]
PEAK_SPEED = (0.5e-3, 6e-3)  # sum of the amplitudes of the velocity [m/s], logarithmic
FREQUENCY, TONE_FREQUENCY = (0.04, 2.5), (0.04, 0.3)  # [Hz], logarithmic; of a single tone
STOPS, MOVE, REST = (4, 8), (0.5, 3.0), (0.3, 4.0)  # stops of dwells; duration of a move and of a rest [s]


@dataclass(frozen=True, kw_only=True)
class DrawnCase(Row):
    """A random case; `motion` describes laws, sensors and motion."""

    variant: TransmissionVariant
    profile: Motion
    group: str = DRAWN_GROUP


def draw(base: int, number: int, rates_hz: Sequence[int], elastic_law: str) -> DrawnCase:
    """Case `number` of the series `base`, at one of the rates [Hz]."""
    random = np.random.default_rng([base, number])
    profile, motion = _motion(random)
    spring, damper, friction = (
        str(random.choice(kinds)) for kinds in ((EXPONENTIAL, *SPRINGS), (CUBIC, *DAMPERS), tuple(FRICTIONS))
    )
    names = random.choice(list(ERRORS), random.integers(0, MAX_ERRORS + 1), replace=False).tolist()
    errors = {name: float(random.uniform(*ERRORS[name])) for name in names}
    jitter = JITTER if random.random() < JITTER_SHARE else 0.0
    laws, memory = _laws(np.random.default_rng([base, number, 1]), spring, damper, friction)
    variant = TransmissionVariant(laws=laws, sensor_errors=SensorErrorConfig(**errors), stamp_jitter=jitter)
    sensors = [f"{name} {value:.2g}" for name, value in errors.items()] + ["stamp_jitter"] * bool(jitter)
    words = f"{' '.join([spring, damper, friction, *memory, *sensors])}; {motion}"
    rate_hz = int(random.choice(list(rates_hz)))
    return DrawnCase(f"drawn {number}", words, rate_hz, elastic_law, variant=variant, profile=profile)


def _laws(random: np.random.Generator, spring: str, damper: str, friction: str) -> tuple[ForceLaws, list[str]]:
    """Laws of these kinds with parameters of their own, and the names of those with memory."""
    of_spring, of_damper, of_friction, branch, loop = (
        _parameters(random, ranges) for ranges in (SPRING, DAMPER, FRICTION, VISCOELASTIC, HYSTERESIS)
    )
    viscoelastic, hysteresis = random.random(2) < MEMORY_SHARE
    laws = ForceLaws(
        spring=SpringConfig(spring, **of_spring),
        damper=DamperConfig(damper, **of_damper),
        friction=FrictionConfig(friction, **of_friction),
        viscoelastic=ViscoelasticConfig(**branch) if viscoelastic else ViscoelasticConfig(),
        hysteresis=HysteresisConfig(**loop) if hysteresis else HysteresisConfig(),
    )
    return laws, ["viscoelastic"] * bool(viscoelastic) + ["hysteresis"] * bool(hysteresis)


def _parameters(random: np.random.Generator, ranges: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
    return {name: float(_logarithmic(random, limits, 1)[0]) for name, limits in ranges.items()}


def _motion(random: np.random.Generator) -> tuple[Motion, str]:
    """A motion of several tones, one tone, or dwells, and its description."""
    kind = random.choice(["tones", "tones", "tones", "tone", "dwells"])
    if kind == "dwells":
        stops = random.uniform(*STROKE, random.integers(STOPS[0], STOPS[1] + 1))
        move, rest = random.uniform(*MOVE), random.uniform(*REST)
        return dwells(tuple(stops.tolist()), float(move), float(rest)), f"dwells {move:.1f} s, {rest:.1f} s"
    count = 1 if kind == "tone" else int(random.integers(2, 5))
    centre = float(random.uniform(*CENTRE))
    frequencies = np.sort(_logarithmic(random, TONE_FREQUENCY if count == 1 else FREQUENCY, count))
    amplitudes = random.uniform(0.3, 1.0, count) / frequencies
    amplitudes *= _logarithmic(random, PEAK_SPEED, 1) / np.sum(2.0 * np.pi * frequencies * amplitudes)
    amplitudes *= min(1.0, min(centre - STROKE[0], STROKE[1] - centre) / amplitudes.sum())
    phases = random.uniform(0.0, 2.0 * np.pi, count)
    parts = [Tone(*one) for one in np.stack([amplitudes, frequencies, phases], axis=1).tolist()]
    words = ", ".join(f"{1e3 * one.amplitude:.2f} mm {one.frequency:.2f} Hz" for one in parts)
    return tones(centre, *parts), words


def _logarithmic(random: np.random.Generator, limits: tuple[float, float], count: int) -> Array:
    """Values (count,) between the limits whose logarithms are uniform."""
    low, high = math.log(limits[0]), math.log(limits[1])
    return np.exp(random.uniform(low, high, count))
