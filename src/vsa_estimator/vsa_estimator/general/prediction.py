# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Prediction of a member: motion with white snap, disturbances, relaxation and hysteresis."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.general.basis import cubic, growth_factor, locate
from vsa_estimator.general.records import (
    HYSTERESIS_SIZE,
    LEVEL_RATE,
    MOTION,
    RELAXATION_SIZE,
    SIZE,
    SPRING,
    SPRING_SIZE,
    A,
    B,
    J,
    L,
    Record,
    V,
    X,
)  # fmt: skip
from vsa_estimator.tuning.general import (
    LEVEL_RATE_TIME,
    MIN_RELATIVE_STIFFNESS,
    RELAXATION_TIMES,
    STOP_TRAVELS,
)

RELAXATION_TIME = np.array(RELAXATION_TIMES)
STOP_TRAVEL = np.array(STOP_TRAVELS)
FACTORIAL = np.array([6.0, 2.0, 1.0, 1.0])  # (3 - i)! of the states of the motion


@compiled
def advance_memory(member: Record, geometry: Record, x: float, dt: float) -> None:
    """Relaxation states q_k [N] and stop operators y_k (within +-1) over dt [s] to the deflection x [m].

    They follow the deflection, as the elastic force does: the integral of the estimated velocity is another motion.
    The relaxation states are driven by an elastic law that stays the same between repetitions, so that the force is
    linear in their shares.
    """
    one = member[0]
    travel, middle = x - one["deflection"], 0.5 * (x + one["deflection"])
    one["deflection"] = x
    if one["model"]["relaxation"]:
        force = max(spring_stiffness(one["driving"], geometry, middle), 1.0) * travel
        for k in range(RELAXATION_SIZE):
            rate = dt / RELAXATION_TIME[k]
            decay = math.exp(-rate)
            one["relaxation"][k] = one["relaxation"][k] * decay + force * (1.0 - decay) / rate
    for k in range(HYSTERESIS_SIZE):
        one["stop"][k] = min(max(one["stop"][k] + travel / STOP_TRAVEL[k], -1.0), 1.0)


@compiled
def spring_stiffness(coefficients: Array, geometry: Record, x: float) -> float:
    """Stiffness [N/m] of an elastic law with these coefficients (SPRING_SIZE,) at x [m]."""
    i, u = locate(x, geometry[0]["origin"], geometry[0]["spacing"])
    w, relative = np.empty(4), 0.0
    cubic(u, w)
    for j in range(4):
        relative += w[j] * coefficients[i + j]
    return relative * growth_factor(geometry, x)


@compiled
def integrate(rows: Array, dt: float) -> None:
    """Multiply the first MOTION of `rows` (m, n) by the transition of a motion with constant jerk over dt [s]."""
    half, sixth = 0.5 * dt * dt, dt**3 / 6.0
    for j in range(rows.shape[1]):
        rows[X, j] += dt * rows[V, j] + half * rows[A, j] + sixth * rows[J, j]
        rows[V, j] += dt * rows[A, j] + half * rows[J, j]
        rows[A, j] += dt * rows[J, j]


@compiled
def transition(rows: Array, dt: float, decay: float) -> None:
    """Multiply `rows` (SIZE, n) by the transition over dt [s]; `decay` is that of B."""
    rate_decay = math.exp(-dt / LEVEL_RATE_TIME)
    integrate(rows, dt)
    for j in range(rows.shape[1]):
        rows[B, j] *= decay
        rows[L, j] += dt * rows[LEVEL_RATE, j]
        rows[LEVEL_RATE, j] *= rate_decay


@compiled
def add_snap_noise(p: Array, density: float, dt: float) -> None:
    """Add the noise of white snap of a density [m^2/s^7] over dt [s] to the covariance of the motion."""
    for i in range(MOTION):
        for j in range(MOTION):
            p[i, j] += density * dt ** (7 - i - j) / (FACTORIAL[i] * FACTORIAL[j] * (7 - i - j))


@compiled
def add_law_noise(p: Array, level: float, direction: Array, variance: float) -> None:
    """Add a random change of the elastic law to the covariance: of the level [N] and along `direction` (SPRING_SIZE,).

    `variance` is that of the common factor of both.
    """
    p[L, L] += variance * level * level
    for i in range(SPRING_SIZE):
        p[L, SPRING + i] += variance * level * direction[i]
        p[SPRING + i, L] += variance * level * direction[i]
        for j in range(SPRING_SIZE):
            p[SPRING + i, SPRING + j] += variance * (direction[i] * direction[j])


@compiled
def at_reference(member: Record, geometry: Record) -> float:
    """Stiffness of a member at the reference [N/m]."""
    return spring_stiffness(member[0]["mean"][SPRING:], geometry, geometry[0]["reference"])


@compiled
def add_scale_noise(member: Record, geometry: Record, variance: float) -> None:
    """Add a random change of the whole elastic law of this relative variance to the covariance."""
    level = at_reference(member, geometry) * geometry[0]["unit"]
    add_law_noise(member[0]["covariance"], level, member[0]["mean"][SPRING:], variance)


@compiled
def drop_innovation(member: Record) -> None:
    """The step of a member, (1,) MEMBER, has no force."""
    member[0]["innovation"] = member[0]["innovation_variance"] = 0.0
    member[0]["gain"][:] = 0.0


@compiled
def add_shift_noise(member: Record, geometry: Record, deflection_variance: float, force_variance: float) -> None:
    """Add shifts of the encoder and of the force sensor of these variances [m^2, N^2] to the covariance.

    A shift of the encoder by d is one of the law: sigma(x) becomes sigma(x - d), the level L - sigma d.
    The coefficients change by their slope over the deflection, of which each is the value at its abscissa.
    """
    c, one = member[0]["mean"][SPRING:], geometry[0]
    least = MIN_RELATIVE_STIFFNESS * np.abs(c).max()
    direction = np.empty(SPRING_SIZE)
    for i in range(SPRING_SIZE):
        low, high = max(i - 1, 0), min(i + 1, SPRING_SIZE - 1)
        growth = math.log(max(c[high], least) / max(c[low], least)) / ((high - low) * one["spacing"])
        direction[i] = -max(c[i], least) * (one["growth"] + growth)
    add_law_noise(member[0]["covariance"], -at_reference(member, geometry), direction, deflection_variance)
    member[0]["covariance"][L, L] += force_variance


@compiled
def predict_level(member: Record, geometry: Record, dt: float) -> None:
    """Predict level and elastic law by dt [s], as `predict_member` does; the motion stays, with its covariance."""
    one = member[0]
    z, p, decay = one["mean"], one["covariance"], math.exp(-dt / LEVEL_RATE_TIME)
    z[L] += dt * z[LEVEL_RATE]
    z[LEVEL_RATE] *= decay
    for j in range(SIZE):
        p[L, j] += dt * p[LEVEL_RATE, j]
        p[LEVEL_RATE, j] *= decay
    for j in range(SIZE):
        p[j, L] += dt * p[j, LEVEL_RATE]
        p[j, LEVEL_RATE] *= decay
    add_law_densities(member, geometry, dt)


@compiled
def add_law_densities(member: Record, geometry: Record, dt: float) -> None:
    """Add the noise of level, level rate and elastic law over dt [s] to the covariance."""
    p, model = member[0]["covariance"], member[0]["model"]
    p[L, L] += model["level_density"] * dt
    p[LEVEL_RATE, LEVEL_RATE] += model["rate_density"] * dt
    if model["scale_density"] > 0.0:
        add_scale_noise(member, geometry, model["scale_density"] * dt)


@compiled
def predict_member(member: Record, geometry: Record, dt: float, snap_density: float) -> None:
    """Predict state and covariance by dt [s] with white snap of a density [m^2/s^7]."""
    one = member[0]
    z, p, model = one["mean"], one["covariance"], one["model"]
    decay = math.exp(-abs(z[V] * dt) / model["travel_length"])
    transition(z.reshape((SIZE, 1)), dt, decay)
    transition(one["bias"].reshape((SIZE, 1)), dt, decay)
    transition(p, dt, decay)
    transition(p.T, dt, decay)
    for i in range(LEVEL_RATE + 1):
        for j in range(i + 1, SIZE):
            p[j, i] = p[i, j]  # symmetric to the last bit, which the correction keeps
    add_snap_noise(p, snap_density, dt)
    p[B, B] += model["travel_std"] ** 2 * (1.0 - decay * decay)
    add_law_densities(member, geometry, dt)
