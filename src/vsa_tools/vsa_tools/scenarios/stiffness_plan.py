"""Schedule and judgement of the demo in which stiffness steps through its range: pure functions of time and truth."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from vsa_common.types import Array
from vsa_joint.geometry import Joint
from vsa_joint.impedance.reflection import branch_at_joint

LEARNING = 24.0  # s of motion by the rig's profile, for the estimators
STEPS = (1.0, 2.0, 4.0, 2.0, 1.0, 0.5, 4.0, 0.5, 1.0)  # N m/rad, the first is the way in
STEP_TIME = 5.0  # s
UNREACHABLE, REFUSAL_TIME = 12.0, 1.0  # N m/rad, s
FELT = (0.5, 1.0, 4.0)  # N m/rad
FELT_ANGLE = 0.1  # rad, that the push should turn the joint by
FELT_SETTLE, PUSH_RAMP, PUSH_TIME, RAMP_STEPS = 4.0, 3.0, 14.0, 300  # s, s, s for each sign
RELEASE = 3.0  # s
LOOKED_AT = 1.5  # s at the end of each, that count as steady
BAND = 0.05  # of the stiffness


@dataclass(frozen=True)
class Command:
    """A stiffness [N m/rad] commanded from `time` [s] on, and until when it is judged."""

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
    """What a step of the commanded stiffness did."""

    start: float
    to: float
    settle_5pct_s: float
    equilibrium_steady_mrad: float
    equilibrium_transient_mrad: float
    steady_error: float

    def row(self) -> dict[str, float]:
        """For control.json."""
        values = asdict(self)
        return {"from": values.pop("start"), **values}


def step_commands() -> list[Command]:
    """Stiffness up and down by two and by eight."""
    return [
        Command(LEARNING + i * STEP_TIME, LEARNING + (i + 1) * STEP_TIME, stiffness)
        for i, stiffness in enumerate(STEPS)
    ]


def refusal_time() -> float:
    """When what cannot be reached is commanded [s]."""
    return step_commands()[-1].end


def felt_commands() -> list[Command]:
    """Stiffness while the joint is pushed one way and the other."""
    each, start = FELT_SETTLE + 2.0 * PUSH_TIME + RELEASE, refusal_time() + REFUSAL_TIME
    return [Command(start + i * each, start + (i + 1) * each, stiffness) for i, stiffness in enumerate(FELT)]


def duration() -> float:
    """Of the whole [s]."""
    return felt_commands()[-1].end + 1.0


def pushes() -> list[Push]:
    """Torque to one side, to the other, and back to nothing, in steps too small to feel."""
    out = []
    for command in felt_commands():
        begin, now = command.time + FELT_SETTLE, 0.0
        for sign in (1.0, -1.0):
            wanted = sign * FELT_ANGLE * command.stiffness
            for k in range(1, RAMP_STEPS + 1):
                part = k / RAMP_STEPS
                eased = 0.5 - 0.5 * math.cos(math.pi * part)
                out.append(Push(begin + PUSH_RAMP * part, now + eased * (wanted - now)))
            begin, now = begin + PUSH_TIME, wanted
        out += [
            Push(begin + RELEASE * k / RAMP_STEPS, now * (0.5 + 0.5 * math.cos(math.pi * k / RAMP_STEPS)))
            for k in range(1, RAMP_STEPS + 1)
        ]
    return out


def commanded(time: float) -> float | None:
    """Stiffness to command at an instant [N m/rad]; None while the estimators learn."""
    wanted = None
    for command in (*step_commands(), *felt_commands()):
        if time >= command.time:
            wanted = command.stiffness
    if refusal_time() <= time < refusal_time() + REFUSAL_TIME:
        return UNREACHABLE
    return wanted


def true_stiffness(truth: Mapping[str, Array], joint: Joint) -> Array:
    """Stiffness of the joint in each row of the rig's truth, (11) [N m/rad]."""
    total = np.zeros_like(truth["angle"])
    for number, path in zip((1, 2), joint.paths, strict=True):
        total += branch_at_joint(truth[f"stiffness_{number}"], path.radius, path.tendon_stiffness)
    return total


def judge_steps(time: Array, stiffness: Array, angle: Array, begins: Sequence[float]) -> list[Step]:
    """Each step after the way in; `begins` are the instants at which the commands really went out [s]."""
    out = []
    commands = step_commands()
    for before, command, begin in zip(commands[:-1], commands[1:], begins[1:], strict=True):
        chosen = (time >= begin) & (time < command.end)
        late = (time >= command.end - LOOKED_AT) & (time < command.end)
        outside = time[chosen][np.abs(stiffness[chosen] / command.stiffness - 1.0) > BAND]
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


def judge_felt(time: Array, angle: Array, torque: Array) -> list[dict[str, float]]:
    """Torque over angle between both pushes, for each commanded stiffness."""
    out = []
    for command in felt_commands():
        ends = [command.time + FELT_SETTLE + PUSH_TIME * n for n in (1, 2)]
        windows = [(time >= end - LOOKED_AT) & (time < end - 0.05) for end in ends]
        turned = angle[windows[0]].mean() - angle[windows[1]].mean()
        pushed = torque[windows[0]].mean() - torque[windows[1]].mean()
        out.append({"commanded": command.stiffness, "rendered": float(pushed / turned)})
    return out


def figures(
    truth: Mapping[str, Array], joint: Joint, begins: Sequence[float], refused: Sequence[Any]
) -> dict[str, Any]:
    """The content of control.json."""
    time = truth["time"]
    stiffness = true_stiffness(truth, joint)
    controlled = (time >= begins[1]) & (time < felt_commands()[-1].end)
    forces = np.stack([truth["force_1"], truth["force_2"]])[:, controlled]
    return {
        "steps": [step.row() for step in judge_steps(time, stiffness, truth["angle"], begins)],
        "felt": judge_felt(time, truth["angle"], truth["external_torque"]),
        "refused": list(refused),
        "tension_min_n": float(0.5 * forces.min()),
        "tension_max_n": float(0.5 * forces.max()),
    }
