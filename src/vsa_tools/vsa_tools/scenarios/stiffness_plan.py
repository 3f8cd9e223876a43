# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Schedule and evaluation of the stiffness steps: pure functions of time and of the rig's truth."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from vsa_common.types import Array
from vsa_joint.geometry import Joint
from vsa_joint.impedance.reflection import branch_at_joint

INITIALIZATION_S = 24.0  # [s] of motion by the rig's profile, until both estimators are VALID
STEPS = (1.0, 2.0, 4.0, 2.0, 1.0, 0.5, 4.0, 0.5, 1.0)  # [N m/rad]: steps by factors 2 and 8; the first is the approach
STEP_S = 5.0  # [s] for each step: several settling times
UNREACHABLE = 12.0  # [N m/rad]: above the reachable range of the paper's rig
REFUSAL_S = 1.0  # [s] for which UNREACHABLE is commanded
PUSH_STIFFNESSES = (0.5, 1.0, 4.0)  # [N m/rad] at which the joint is pushed
PUSH_ANGLE = 0.1  # [rad] expected deflection by the push: far above the encoder's noise
PUSH_SETTLE_S = 4.0  # [s] from the command to the push, for the stiffness to settle
PUSH_RAMP_S = 3.0  # [s] of the ramp of the torque: quasi-static
PUSH_S = 14.0  # [s] for each direction
RAMP_STEPS = 300  # [1]: torque increments below 1 % of the push
RELEASE_S = 3.0  # [s] of the ramp back to zero torque
STEADY_S = 1.5  # [s] at the end of each interval that count as steady state
SETTLING_BAND = 0.05  # of the commanded stiffness [1], the usual 5 % band


@dataclass(frozen=True)
class Command:
    """A stiffness [N m/rad] commanded at `time` [s] and evaluated until `end` [s]."""

    time: float
    end: float
    stiffness: float


@dataclass(frozen=True)
class Push:
    """External torque [N m] from `time` [s] on."""

    time: float
    torque: float


@dataclass(frozen=True)
class Step:
    """Response to one step of the commanded stiffness [N m/rad]; steady_error is relative [1]."""

    start: float
    to: float
    settle_5pct_s: float
    equilibrium_steady_mrad: float
    equilibrium_transient_mrad: float
    steady_error: float

    def row(self) -> dict[str, float]:
        """The entry of control.json."""
        values = asdict(self)
        return {"from": values.pop("start"), **values}


def step_commands() -> list[Command]:
    """The steps, in order of time; the first is the approach."""
    return [
        Command(INITIALIZATION_S + i * STEP_S, INITIALIZATION_S + (i + 1) * STEP_S, stiffness)
        for i, stiffness in enumerate(STEPS)
    ]


def refusal_time() -> float:
    """Time at which UNREACHABLE is commanded [s]."""
    return step_commands()[-1].end


def push_commands() -> list[Command]:
    """Commands during which an external torque pushes the joint in both directions."""
    each, start = PUSH_SETTLE_S + 2.0 * PUSH_S + RELEASE_S, refusal_time() + REFUSAL_S
    return [
        Command(start + i * each, start + (i + 1) * each, stiffness) for i, stiffness in enumerate(PUSH_STIFFNESSES)
    ]


def duration() -> float:
    """Duration of the scenario [s]."""
    return push_commands()[-1].end + 1.0


def pushes() -> list[Push]:
    """External torque of all pushes: cosine ramps to one side, to the other, and back to zero."""
    out = []
    for command in push_commands():
        begin, now = command.time + PUSH_SETTLE_S, 0.0
        for sign in (1.0, -1.0):
            target = sign * PUSH_ANGLE * command.stiffness
            for k in range(1, RAMP_STEPS + 1):
                fraction = k / RAMP_STEPS
                eased = 0.5 - 0.5 * math.cos(math.pi * fraction)
                out.append(Push(begin + PUSH_RAMP_S * fraction, now + eased * (target - now)))
            begin, now = begin + PUSH_S, target
        out += [
            Push(begin + RELEASE_S * k / RAMP_STEPS, now * (0.5 + 0.5 * math.cos(math.pi * k / RAMP_STEPS)))
            for k in range(1, RAMP_STEPS + 1)
        ]
    return out


def commanded(time: float) -> float | None:
    """Stiffness to command at `time` [s] in N m/rad; None during the initialization of the estimators."""
    target = None
    for command in (*step_commands(), *push_commands()):
        if time >= command.time:
            target = command.stiffness
    if refusal_time() <= time < refusal_time() + REFUSAL_S:
        return UNREACHABLE
    return target


def true_stiffness(truth: Mapping[str, Array], joint: Joint) -> Array:
    """Stiffness of the joint in each row of the rig's truth [N m/rad], eq. (11)."""
    total = np.zeros_like(truth["angle"])
    for number, path in zip((1, 2), joint.paths, strict=True):
        total += branch_at_joint(truth[f"stiffness_{number}"], path.radius, path.tendon_stiffness)
    return total


def evaluate_steps(time: Array, stiffness: Array, angle: Array, begins: Sequence[float]) -> list[Step]:
    """Response to each step after the approach; `begins` are the actual times of the commands [s]."""
    out = []
    commands = step_commands()
    for before, command, begin in zip(commands[:-1], commands[1:], begins[1:], strict=True):
        chosen = (time >= begin) & (time < command.end)
        late = (time >= command.end - STEADY_S) & (time < command.end)
        outside = time[chosen][np.abs(stiffness[chosen] / command.stiffness - 1.0) > SETTLING_BAND]
        out.append(
            Step(
                before.stiffness,
                command.stiffness,
                float(outside[-1] - begin) if len(outside) else 0.0,
                float(1e3 * np.abs(angle[late]).max()),
                float(1e3 * np.abs(angle[chosen]).max()),
                float(stiffness[late].mean() / command.stiffness - 1.0),
            )
        )
    return out


def evaluate_pushes(time: Array, angle: Array, torque: Array) -> list[dict[str, float]]:
    """Rendered stiffness, torque over angle between both pushes [N m/rad], for each commanded stiffness."""
    out = []
    for command in push_commands():
        ends = [command.time + PUSH_SETTLE_S + PUSH_S * n for n in (1, 2)]
        windows = [(time >= end - STEADY_S) & (time < end - 0.05) for end in ends]
        turned = angle[windows[0]].mean() - angle[windows[1]].mean()
        pushed = torque[windows[0]].mean() - torque[windows[1]].mean()
        out.append({"commanded": command.stiffness, "rendered": float(pushed / turned)})
    return out


def figures(
    truth: Mapping[str, Array], joint: Joint, begins: Sequence[float], refused: Sequence[Any]
) -> dict[str, Any]:
    """Content of control.json; `refused` are the refused commands."""
    time = truth["time"]
    stiffness = true_stiffness(truth, joint)
    controlled = (time >= begins[1]) & (time < push_commands()[-1].end)
    forces = np.stack([truth["force_1"], truth["force_2"]])[:, controlled]
    return {
        "steps": [step.row() for step in evaluate_steps(time, stiffness, truth["angle"], begins)],
        "push_tests": evaluate_pushes(time, truth["angle"], truth["external_torque"]),
        "refused": list(refused),
        "tension_min_n": float(0.5 * forces.min()),
        "tension_max_n": float(0.5 * forces.max()),
    }
