"""The antagonistic joint in motion, integrated by fixed Runge-Kutta steps of fourth order.

T_1 = K_t (q_1 - R theta - 2 x_1), T_2 = K_t (q_2 + R theta - 2 x_2), never pushing;
J theta'' + D theta' = R (T_1 - T_2) + tau_ext; rods as in `transmission`; motors critically damped.
The tensions are taken once a stage for rods and shaft alike: taken at different instants they would
add damping that is not there.
"""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.motion import Motion, fade, position
from vsa_simulator.rig.transmission import (
    Transmission,
    bristle_rate,
    damping,
    rod_acceleration,
    spring_deflection,
    spring_force,
    stiffness,
)

Pair = tuple[Transmission, Transmission]


# Places in the state of the rig; SI, the motors' as travel of their tendons.
ANGLE, SPEED, X1, V1, Z1, X2, V2, Z2, Q1, W1, Q2, W2 = range(12)
STATES = 12


class Joint(NamedTuple):
    """Numbers of shaft and motors for the integrator; SI, speed and place of the motors as tendon travel."""

    radius: float
    inertia: float
    damping: float
    equilibrium_angle: float
    motor_rate: float
    speed_limit: float
    lower_limit: float
    upper_limit: float
    motor_radius: float


class Load(NamedTuple):
    """External torque: what the motors balance, what pushes besides [N m], and tones (amplitude, Hz, phase)."""

    constant: float
    push: float
    tones: Array
    fade_in: float


# Where the numbers of a whole rig lie in one row: compiled code reads a named tuple that comes from Python at half a
# microsecond a field.
_SIDES = 2 * len(Transmission._fields)
_JOINT_END = _SIDES + len(Joint._fields)
CONSTANT, PUSH, TORQUE_FADE, CENTRE, KIND, MOTION_FADE = range(_JOINT_END, _JOINT_END + 6)


def rig_numbers(p: Pair, j: Joint, load: Load, motion: Motion) -> Array:
    """The numbers of transmissions, joint, load and motion in one row, for `advance_rig`."""
    rest = (load.constant, load.push, load.fade_in, motion.centre, motion.kind, motion.fade_in)
    return np.array([*p[0], *p[1], *j, *rest], float)


SIDE = ("deflection", "velocity", "acceleration", "force", "stiffness", "damping", "inertia")
JOINT = ("angle", "angular_velocity", "external_torque", "tension_1", "tension_2", "motor_1", "motor_2")
TRUTH = ("time", *(f"{name}_1" for name in SIDE), *(f"{name}_2" for name in SIDE), *JOINT)


@compiled
def tension(side: int, y: Array, p: Pair, j: Joint) -> float:
    """Tension of tendon `side`, 0 or 1 [N]."""
    turned = j.radius * y[ANGLE]
    if side == 0:
        return max(0.0, p[0].tendon_stiffness * (y[Q1] - turned - 2.0 * y[X1]))
    return max(0.0, p[1].tendon_stiffness * (y[Q2] + turned - 2.0 * y[X2]))


@compiled
def derivative(y: Array, torque: float, wanted_1: float, wanted_2: float, p: Pair, j: Joint, rate: Array) -> None:
    """Write the rate of the state into `rate`; `wanted` are the commanded tendon travels [m]."""
    t1, t2 = tension(0, y, p, j), tension(1, y, p, j)
    rate[ANGLE] = y[SPEED]
    rate[SPEED] = (j.radius * (t1 - t2) - j.damping * y[SPEED] + torque) / j.inertia
    rate[X1] = y[V1]
    rate[V1] = rod_acceleration(y[X1], y[V1], y[Z1], t1, p[0])
    rate[Z1] = bristle_rate(y[V1], y[Z1], p[0])
    rate[X2] = y[V2]
    rate[V2] = rod_acceleration(y[X2], y[V2], y[Z2], t2, p[1])
    rate[Z2] = bristle_rate(y[V2], y[Z2], p[1])
    rate[Q1], rate[W1] = y[W1], motor_acceleration(y[Q1], y[W1], wanted_1, j)
    rate[Q2], rate[W2] = y[W2], motor_acceleration(y[Q2], y[W2], wanted_2, j)


@compiled
def motor_acceleration(travel: float, speed: float, wanted: float, j: Joint) -> float:
    """q'' = 2 w (clip(w/2 (q* - q)) - q'): critically damped at w, with its speed limited [m/s^2]."""
    w, limit = j.motor_rate, j.speed_limit
    target = min(max(wanted, j.lower_limit), j.upper_limit)
    return 2.0 * w * (min(max(0.5 * w * (target - travel), -limit), limit) - speed)


@compiled
def torque_at(time: float, load: Load) -> float:
    """External torque at `time` [N m]."""
    torque, tones = load.constant + load.push, load.tones
    for i in range(tones.shape[0]):
        swing = tones[i, 0] * math.sin(2.0 * math.pi * tones[i, 1] * time + tones[i, 2])
        torque += fade(time, load.fade_in) * swing
    return torque


@compiled
def balanced_travels(x: float, torque: float, p: Pair, j: Joint, travels: Array) -> None:
    """Write the tendon travels that hold rod 1 at deflection `x` and the joint at its equilibrium angle [m]."""
    force_1 = spring_force(x, p[0])
    force_2 = force_1 + 2.0 * torque / j.radius
    turned = j.radius * j.equilibrium_angle
    travels[0] = 2.0 * x + turned + 0.5 * force_1 / p[0].tendon_stiffness
    travels[1] = 2.0 * spring_deflection(force_2, p[1]) - turned + 0.5 * force_2 / p[1].tendon_stiffness


@compiled
def advance(
    y: Array,
    first: int,
    substeps: int,
    step: float,
    p: Pair,
    j: Joint,
    load: Load,
    motion: Motion,
    commanded: bool,
    command: Array,
    truth: Array,
) -> None:
    """Fill the rows of `truth` from sample `first` on, and leave the state one sample after the last.

    The motors follow the tendon travels `command` [m] where `commanded`, else the motion, ahead by their own lag.
    """
    k1, k2, k3, k4 = np.empty(STATES), np.empty(STATES), np.empty(STATES), np.empty(STATES)
    trial, now, middle, then = np.empty(STATES), command.copy(), command.copy(), command.copy()
    lead = 2.0 / j.motor_rate
    if not commanded:
        balanced_travels(position(first * substeps * step + lead, motion), load.constant, p, j, then)
    for row in range(truth.shape[0]):
        for sub in range(substeps):
            time = ((first + row) * substeps + sub) * step
            now[:] = then
            if not commanded:
                balanced_travels(position(time + 0.5 * step + lead, motion), load.constant, p, j, middle)
                balanced_travels(position(time + step + lead, motion), load.constant, p, j, then)
            torque, torque_middle = torque_at(time, load), torque_at(time + 0.5 * step, load)
            derivative(y, torque, now[0], now[1], p, j, k1)
            if sub == 0:
                write_truth(truth[row], time, y, k1, torque, p, j)
            for i in range(STATES):
                trial[i] = y[i] + 0.5 * step * k1[i]
            derivative(trial, torque_middle, middle[0], middle[1], p, j, k2)
            for i in range(STATES):
                trial[i] = y[i] + 0.5 * step * k2[i]
            derivative(trial, torque_middle, middle[0], middle[1], p, j, k3)
            for i in range(STATES):
                trial[i] = y[i] + step * k3[i]
            derivative(trial, torque_at(time + step, load), then[0], then[1], p, j, k4)
            for i in range(STATES):
                y[i] += step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])


@compiled
def _transmission(n: Array) -> Transmission:
    return Transmission(
        n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9] != 0.0, n[10], n[11], n[12], n[13], n[14]
    )


@compiled
def advance_rig(
    y: Array,
    first: int,
    substeps: int,
    step: float,
    numbers: Array,
    tones: Array,
    table: Array,
    commanded: bool,
    command: Array,
    truth: Array,
) -> None:
    """`advance` with the rig's numbers in one row (`rig_numbers`), tones of the torque and table of the motion."""
    n, half = numbers, _SIDES // 2
    p = _transmission(n[:half]), _transmission(n[half:_SIDES])
    j = n[_SIDES:_JOINT_END]
    joint = Joint(j[0], j[1], j[2], j[3], j[4], j[5], j[6], j[7], j[8])
    load = Load(n[CONSTANT], n[PUSH], tones, n[TORQUE_FADE])
    motion = Motion(n[CENTRE], int(n[KIND]), table, n[MOTION_FADE])
    advance(y, first, substeps, step, p, joint, load, motion, commanded, command, truth)


@compiled
def write_truth(row: Array, time: float, y: Array, rate: Array, torque: float, p: Pair, j: Joint) -> None:
    """Fill one row of truth, columns as in `TRUTH`."""
    row[0] = time
    for side in range(2):
        x, v, a = y[X1 + 3 * side], y[V1 + 3 * side], rate[V1 + 3 * side]
        pull = tension(side, y, p, j)
        column = 1 + 7 * side
        row[column], row[column + 1], row[column + 2] = x, v, a
        row[column + 3] = 2.0 * pull
        row[column + 4], row[column + 5], row[column + 6] = stiffness(x, p[side]), damping(v, p[side]), p[side].inertia
        row[18 + side] = pull
    row[15], row[16], row[17] = y[ANGLE], y[SPEED], torque
    row[20], row[21] = y[Q1] / j.motor_radius, y[Q2] / j.motor_radius
