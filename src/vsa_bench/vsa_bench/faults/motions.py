# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motions of the faulty and of the healthy recordings, and recordings of a transmission in them."""

from typing import NamedTuple

import numpy as np
from vsa_bench.mismatch.cases import MOTIONS
from vsa_bench.mismatch.run import start_parameters
from vsa_common.types import Array
from vsa_simulator.rig.motion import Motion, Tone, dwells, tones
from vsa_simulator.rig.recording import Recording, Simulation, TransmissionVariant

FAULT_MOTIONS = ("mix", "steps", "rest")
HEALTHY_MOTIONS = ("mix", "fast", "steps", "dwells", "pushes", "rests")

CENTRE_M = 0.0095
INTRODUCED = ("steps", "rest", "rests")  # an introduction comes first: from wrong start values they identify no law
INTRODUCTION_S, INTRODUCTION_END_S = 26.0, 25.0  # its length, and from when on it is at rest
STEP_RANGE_M = (0.005, 0.017)
STEP_MOVE_S = (0.2, 0.3)
STEP_REST_S = (2.0, 10.0)
MIN_STEP_M = 0.002
PUSH_M = (2e-4, 8e-4)  # amplitude of the deflection by a push
PUSH_HZ = (1.0, 4.0)
PUSH_PERIOD_S = 7.0


class Simulated(NamedTuple):
    """A recording, the true stiffness [N/m] at its samples, and wrong start values of the estimator."""

    recording: Recording
    stiffness: Array
    start: dict[str, float]


def simulate(variant: TransmissionVariant, name: str, duration: float, rate_hz: int, seed: int) -> Simulated:
    """A recording of `duration` [s] of the named motion, with its introduction where it has one."""
    parts = [motion(name, duration, seed)]
    lengths = [duration]
    if name in INTRODUCED:
        parts, lengths = [introduction(), *parts], [INTRODUCTION_S, duration - INTRODUCTION_S]
    made = [Simulation(variant, *part, rate_hz) for part in zip(parts, lengths, strict=True)]
    recordings = [one.recording(seed + k) for k, one in enumerate(made)]
    begins_ns = np.concatenate(([0], np.cumsum(np.round(1e9 * np.array(lengths)))))[:-1].astype(np.int64)
    recording = Recording(
        np.concatenate([one.stamp_ns + begin for one, begin in zip(recordings, begins_ns, strict=True)]),
        np.concatenate([one.force for one in recordings]),
        np.concatenate([one.deflection for one in recordings]),
    )
    stiffness = np.concatenate([one.stiffness for one in made])
    return Simulated(recording, stiffness, start_parameters(made[0], seed))


def introduction() -> Motion:
    """The motion `mix` that ends at rest in its centre."""
    parts = (Tone(0.0032, 0.07), Tone(0.00025, 0.6, 1.1), Tone(0.0001, 1.2, 2.2))
    return tones(CENTRE_M, *(one._replace(end=INTRODUCTION_END_S) for one in parts))


def motion(name: str, duration: float, seed: int) -> Motion:
    """The named motion for `duration` [s], without introduction; steps and pushes are drawn by `seed`."""
    random = np.random.default_rng([seed, 2])
    if name == "steps":
        return steps(duration, random)
    if name == "pushes":
        return pushes(duration, random)
    if name == "rests":
        return dwells((CENTRE_M, 0.013, 0.006, 0.0115, 0.0075, 0.014, 0.005), move=1.5, rest=20.0)
    return tones(CENTRE_M) if name == "rest" else MOTIONS[name]


def steps(duration: float, random: np.random.Generator) -> Motion:
    """Moves within STEP_MOVE_S over MIN_STEP_M or more, as a stiffness controller commands, with rests of STEP_REST_S.

    All moves of a motion take the same time; a rest is a repeated position.
    """
    move = float(random.uniform(*STEP_MOVE_S))
    positions = [CENTRE_M]
    while len(positions) * 2.0 * move < duration:
        target = float(random.uniform(*STEP_RANGE_M))
        if abs(target - positions[-1]) >= MIN_STEP_M:
            positions += [target] * max(1, round(float(random.uniform(*STEP_REST_S)) / (2.0 * move)))
    return dwells(tuple(positions), move=move, rest=move)


def pushes(duration: float, random: np.random.Generator) -> Motion:
    """A slow motion with pushes: a few oscillations of PUSH_M at PUSH_HZ, one each PUSH_PERIOD_S."""
    parts = [Tone(0.003, 0.06), Tone(0.0002, 0.5, 1.1)]
    for begin in np.arange(5.0, duration, PUSH_PERIOD_S):
        first, frequency = float(begin + random.uniform(0.0, 3.0)), float(random.uniform(*PUSH_HZ))
        parts.append(Tone(float(random.uniform(*PUSH_M)), frequency, 0.0, first, first + 3.0 / frequency))
    return tones(CENTRE_M, *parts, fade_in=0.5)
