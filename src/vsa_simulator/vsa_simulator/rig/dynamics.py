# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Dynamics of the antagonistic joint, integrated by the Runge-Kutta method of fourth order with fixed steps.

T_1 = K_t (q_1 - R theta - 2 x_1), T_2 = K_t (q_2 + R theta - 2 x_2), never negative;
J theta'' + D theta' = R (T_1 - T_2) + tau_ext; rods as in `transmission`; motors critically damped.
Each stage evaluates the tensions once, for rods and shaft alike: tensions of different instants would add
numerical damping.
"""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.motion import Table, fade, position
from vsa_simulator.rig.parameters import Command, Curves, Joint, Load, Model, Pair, Record, Steps, model_of
from vsa_simulator.rig.transmission import (
    Rod,
    damping,
    elastic_scale,
    rod_rates,
    spring_deflection,
    spring_force,
    stiffness,
)

# State of the rig, SI: both rods, columns as in `Rod`, shaft, motors as travel of their tendons.
ROD = len(Rod._fields)
X1, X2 = 0, ROD
ANGLE, SPEED, Q1, W1, Q2, W2 = range(2 * ROD, 2 * ROD + 6)
STATES = 2 * ROD + 6

SIDE = ("deflection", "velocity", "acceleration", "force", "stiffness", "damping", "inertia")
JOINT = ("angle", "angular_velocity", "external_torque", "tension_1", "tension_2", "motor_1", "motor_2")
TRUTH = ("time", *(f"{name}_1" for name in SIDE), *(f"{name}_2" for name in SIDE), *JOINT)

# Columns of the truth; those of transmission 2 follow `SIDE_COLUMNS` later.
SIDE_COLUMNS = len(SIDE)
TIME, DEFLECTION, VELOCITY, ACCELERATION, FORCE, STIFFNESS, DAMPING, INERTIA = range(1 + SIDE_COLUMNS)
JOINT_ANGLE, JOINT_SPEED, TORQUE, TENSION_1, TENSION_2, MOTOR_1, MOTOR_2 = range(1 + 2 * SIDE_COLUMNS, len(TRUTH))


@compiled
def advance_rig(y: Array, record: Record, curves: Curves, tones: Array, table: Table, first: int, truth: Array) -> None:
    """Integrate the rig of `record` (1,) over the samples from `first` on.

    Fills the rows of `truth` (samples, len(TRUTH)), and leaves the state `y` (STATES,) one sample after the last.
    `curves` are those of the laws, `tones` those of the torque, `table` is that of the motion.
    """
    r = record[0]
    steps = Steps(int(r["steps"]["per_sample"]), float(r["steps"]["length"]))
    command = Command(r["command"]["active"], r["command"]["travel_1"], r["command"]["travel_2"])
    _advance(y, first, steps, model_of(r, curves, tones, table), command, truth)


@compiled
def balanced_travels(x: float, torque: float, p: Pair, j: Joint, travels: Array) -> None:
    """Write the tendon travels that hold rod 1 at deflection `x` and the joint at its equilibrium angle [m]."""
    force_1 = spring_force(x, p[0])
    force_2 = force_1 + 2.0 * torque / j.radius
    turned = j.radius * j.equilibrium_angle
    travels[0] = 2.0 * x + turned + 0.5 * force_1 / p[0].tendon_stiffness
    travels[1] = 2.0 * spring_deflection(force_2, p[1]) - turned + 0.5 * force_2 / p[1].tendon_stiffness


@compiled
def _advance(y: Array, first: int, steps: Steps, model: Model, command: Command, truth: Array) -> None:
    """The motors follow the command where it is active, else the motion, ahead by their own lag."""
    step, lead = steps.length, 2.0 / model.joint.motor_bandwidth
    rates, trial, targets = np.empty((4, STATES)), np.empty(STATES), np.empty((3, 2))
    targets[:, 0], targets[:, 1] = command.travel_1, command.travel_2  # at begin, middle and end of a step
    if not command.active:
        _profile_travels(first * steps.per_sample * step + lead, model, targets[2])
    for row in range(truth.shape[0]):
        for sub in range(steps.per_sample):
            time = ((first + row) * steps.per_sample + sub) * step
            targets[0] = targets[2]
            if not command.active:
                _profile_travels(time + 0.5 * step + lead, model, targets[1])
                _profile_travels(time + step + lead, model, targets[2])
            torque = _torque_at(time, model.load)
            _derivative(y, time, torque, targets[0], model, rates[0])
            if sub == 0:
                _write_truth(truth[row], time, y, rates[0], torque, model)
            _finish_step(y, time, step, targets, model, rates, trial)


@compiled
def _finish_step(y: Array, time: float, step: float, targets: Array, model: Model, rates: Array, trial: Array) -> None:
    """Advance the state by one step from the first of the four `rates`, that at `time`."""
    k1, k2, k3, k4 = rates[0], rates[1], rates[2], rates[3]
    middle, end = time + 0.5 * step, time + step
    torque_middle = _torque_at(middle, model.load)
    for i in range(STATES):
        trial[i] = y[i] + 0.5 * step * k1[i]
    _derivative(trial, middle, torque_middle, targets[1], model, k2)
    for i in range(STATES):
        trial[i] = y[i] + 0.5 * step * k2[i]
    _derivative(trial, middle, torque_middle, targets[1], model, k3)
    for i in range(STATES):
        trial[i] = y[i] + step * k3[i]
    _derivative(trial, end, _torque_at(end, model.load), targets[2], model, k4)
    for i in range(STATES):
        y[i] += step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])


@compiled
def _profile_travels(time: float, model: Model, travels: Array) -> None:
    """Write the tendon travels of the motion at `time` [m]."""
    balanced_travels(position(time, model.motion), model.load.constant, model.transmissions, model.joint, travels)


@compiled
def _derivative(y: Array, time: float, torque: float, targets: Array, model: Model, rate: Array) -> None:
    """Write the time derivative of the state at `time` into `rate`; `targets` are those of the motors' travels [m]."""
    p, j = model.transmissions, model.joint
    t1, t2 = _tension(0, y, p, j), _tension(1, y, p, j)
    rate[ANGLE] = y[SPEED]
    rate[SPEED] = (j.radius * (t1 - t2) - j.damping * y[SPEED] + torque) / j.inertia
    _write_rod(rate, X1, rod_rates(_rod(y, X1), time, t1, p[0]))
    _write_rod(rate, X2, rod_rates(_rod(y, X2), time, t2, p[1]))
    rate[Q1], rate[W1] = y[W1], _motor_acceleration(y[Q1], y[W1], targets[0], j)
    rate[Q2], rate[W2] = y[W2], _motor_acceleration(y[Q2], y[W2], targets[1], j)


@compiled
def _rod(y: Array, first: int) -> Rod:
    return Rod(y[first], y[first + 1], y[first + 2], y[first + 3], y[first + 4])


@compiled
def _write_rod(rate: Array, first: int, rod: Rod) -> None:
    for i, value in enumerate(rod):
        rate[first + i] = value


@compiled
def _tension(side: int, y: Array, p: Pair, j: Joint) -> float:
    """Tension of tendon `side`, 0 or 1 [N]."""
    turned = j.radius * y[ANGLE]
    if side == 0:
        return max(0.0, p[0].tendon_stiffness * (y[Q1] - turned - 2.0 * y[X1]))
    return max(0.0, p[1].tendon_stiffness * (y[Q2] + turned - 2.0 * y[X2]))


@compiled
def _motor_acceleration(travel: float, speed: float, target: float, j: Joint) -> float:
    """q'' = 2 w (clip(w/2 (q* - q)) - q'): critically damped at w, with limited speed [m/s^2]."""
    w, limit = j.motor_bandwidth, j.speed_limit
    reachable = min(max(target, j.lower_limit), j.upper_limit)
    return 2.0 * w * (min(max(0.5 * w * (reachable - travel), -limit), limit) - speed)


@compiled
def _torque_at(time: float, load: Load) -> float:
    """External torque at `time` [N m]."""
    torque, tones = load.constant + load.disturbance, load.tones
    for i in range(tones.shape[0]):
        tone = tones[i, 0] * math.sin(2.0 * math.pi * tones[i, 1] * time + tones[i, 2])
        torque += fade(time, load.fade_in) * tone
    return torque


@compiled
def _write_truth(row: Array, time: float, y: Array, rate: Array, torque: float, model: Model) -> None:
    """Fill one row of truth, columns as in `TRUTH`."""
    p, j = model.transmissions, model.joint
    row[TIME] = time
    for side in range(2):
        x, v, a = y[side * ROD], y[side * ROD + 1], rate[side * ROD + 1]
        tension, offset = _tension(side, y, p, j), side * SIDE_COLUMNS
        row[offset + DEFLECTION], row[offset + VELOCITY], row[offset + ACCELERATION] = x, v, a
        row[offset + FORCE], row[TENSION_1 + side] = 2.0 * tension, tension
        row[offset + STIFFNESS] = elastic_scale(time, p[side]) * stiffness(x, p[side])
        row[offset + DAMPING] = damping(v, p[side])
        row[offset + INERTIA] = p[side].inertia
    row[JOINT_ANGLE], row[JOINT_SPEED], row[TORQUE] = y[ANGLE], y[SPEED], torque
    row[MOTOR_1], row[MOTOR_2] = y[Q1] / j.motor_radius, y[Q2] / j.motor_radius
