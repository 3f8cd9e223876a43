# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motions of the faulty and of the healthy recordings."""

import numpy as np
from vsa_bench.mismatch.cases import MOTIONS
from vsa_simulator.rig.motion import Motion, Tone, dwells, tones

FAULT_MOTIONS = ("mix", "steps", "rest")
HEALTHY_MOTIONS = ("mix", "fast", "steps", "dwells", "pushes", "rests")

STEP_RANGE_M = (0.005, 0.017)
STEP_MOVE_S = (0.2, 0.3)
STEP_REST_S = (2.0, 10.0)
MIN_STEP_M = 0.002
REST_FROM_S = 27.0  # motion "rest": at rest from here on
PUSH_M = (2e-4, 8e-4)  # amplitude of the deflection by a push
PUSH_HZ = (1.0, 4.0)
PUSH_PERIOD_S = 7.0


def motion(name: str, duration: float, seed: int) -> Motion:
    """The named motion for `duration` [s]; steps and pushes are drawn by `seed`."""
    random = np.random.default_rng([seed, 2])
    if name == "steps":
        return steps(duration, random)
    if name == "pushes":
        return pushes(duration, random)
    if name == "rests":
        return dwells((0.009, 0.013, 0.006, 0.0115, 0.0075, 0.014, 0.005), move=1.5, rest=20.0)
    if name == "rest":
        parts = (Tone(0.0032, 0.07), Tone(0.00025, 0.6, 1.1), Tone(0.0001, 1.2, 2.2))
        return tones(0.0095, *(one._replace(end=REST_FROM_S) for one in parts))
    return MOTIONS[name]


def steps(duration: float, random: np.random.Generator) -> Motion:
    """Moves within STEP_MOVE_S over MIN_STEP_M or more, as a stiffness controller commands, with rests of STEP_REST_S.

    All moves of a motion take the same time; a rest is a repeated position.
    """
    move = float(random.uniform(*STEP_MOVE_S))
    positions = [float(random.uniform(*STEP_RANGE_M))]
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
    return tones(0.0095, *parts, fade_in=0.5)
