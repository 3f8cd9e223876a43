# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Acceptance of the stiffness steps: which commands are reached, how long the motors are held."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from vsa_common.types import Array
from vsa_tools.scenarios.stiffness_plan import PUSH_SETTLE_S, SETTLING_BAND, Command, push_commands, step_commands

MAX_HOLD_S = 1.0  # [s] requirement: a longer hold of the motors ends the demo with an error
MAX_STEP_S = 1.0  # [s] requirement on a step; a later one is reported, and is no error
DWELL_S = 0.5  # [s] within the band that count as reached: longer than a passage through it


class ControlMode(NamedTuple):
    """A mode of the controller from `time` [s] on, with its reason."""

    time: float
    mode: str
    reason: str


def commands() -> list[Command]:
    """All commands with the time within which each has to be reached: the steps, and the approach of each push."""
    pushed = [Command(c.time, c.time + PUSH_SETTLE_S, c.stiffness) for c in push_commands()]
    return [*step_commands(), *pushed]


def reached(time: Array, stiffness: Array, begins: Sequence[float]) -> list[dict[str, Any]]:
    """When the true `stiffness` [N m/rad] at `time` [s] is within 5 % of each command for DWELL_S.

    `begins` are the times of the commands [s]; `reached_s` counts from there and is None for a command not reached.
    `end_error` is relative, at the end of the command.
    """
    found = []
    for command, begin in zip(commands(), begins, strict=True):
        chosen = (time >= begin) & (time < begin + command.end - command.time)
        t, error = time[chosen] - begin, stiffness[chosen] / command.stiffness - 1.0
        outside = np.concatenate([[0.0], t[np.abs(error) > SETTLING_BAND], [t[-1] if len(t) else 0.0]])
        inside = outside[:-1][np.diff(outside) > DWELL_S]
        found.append(
            {
                "stiffness": command.stiffness,
                "at_s": round(begin, 3),
                "reached_s": round(float(inside[0]), 3) if len(inside) else None,
                "end_error": float(error[-1]) if len(error) else None,
            }
        )
    return found


def holds(modes: Sequence[ControlMode], end: float) -> list[dict[str, Any]]:
    """Intervals up to `end` [s] in which the motors were held, and those of re-excitation, with their first reason."""
    changes = [
        one for one, last in zip(modes, [None, *modes[:-1]], strict=True) if last is None or one.mode != last.mode
    ]
    ends = [*(one.time for one in changes[1:]), end]
    return [
        {
            "mode": one.mode,
            "at_s": round(one.time, 3),
            "duration_s": round(min(until, end) - one.time, 3),
            "reason": one.reason,
        }
        for one, until in zip(changes, ends, strict=True)
        if one.mode in ("holding", "exciting") and one.time < end
    ]


def failures(figures: Mapping[str, Any]) -> list[str]:
    """A sentence for each command that is not reached and for each hold of more than MAX_HOLD_S."""
    texts = []
    for one in figures["reached"]:
        if one["reached_s"] is None:
            error = "no samples" if one["end_error"] is None else f"{100 * one['end_error']:+.1f} % at its end"
            texts.append(f"{one['stiffness']:g} N m/rad, commanded at {one['at_s']:.1f} s, not reached: {error}")
    texts += [
        f"motors held for {one['duration_s']:.1f} s from {one['at_s']:.1f} s on: {one['reason']}"
        for one in figures["holds"]
        if one["mode"] == "holding" and one["duration_s"] > MAX_HOLD_S
    ]
    return texts
