# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Models of the bank: terms, process noise, prior probability, and the prior of their coefficients."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.general.basis import fill_table
from vsa_estimator.general.records import (
    D0,
    D1,
    D2,
    DAMPER,
    DAMPER_SIZE,
    DELAY,
    GEOMETRY,
    HYSTERESIS,
    HYSTERESIS_SIZE,
    INTERVALS,
    LEVEL_RATE,
    MEMBER,
    RELAXATION,
    RELAXATION_SIZE,
    SIZE,
    SPRING,
    SPRING_SIZE,
    STRIBECK,
    STRIBECK_SIZE,
    A,
    B,
    J,
    L,
    M,
    Record,
    V,
    X,
)  # fmt: skip
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import INITIAL_ACCELERATION_STD, INITIAL_SPEED_STD, MIN_ELASTIC_FORCE
from vsa_estimator.tuning.force_law import UNBOUNDED_SPEED
from vsa_estimator.tuning.general import (
    CUBIC_STD,
    DAMPER_SHAPE_LENGTH,
    DAMPER_SHAPE_STD,
    DELAY_STD,
    HYSTERESIS_STD,
    INITIAL_JERK_STD,
    LEVEL_RATE_TIME,
    LEVEL_STD,
    RELAXATION_STD,
    SHAPE_LENGTH,
    SHAPE_STD,
    SLOPE_STD,
    SPARE_INTERVALS,
    SPARE_SPEED,
    SPEED_SPACING,
    SPRING_SPACING,
    STIFFNESS_STD,
    STRIBECK_STD,
)  # fmt: skip


class Model(NamedTuple):
    """One hypothesis about the transmission and its sensors; noise in SI, see `records.MODEL`."""

    name: str
    prior: float
    spline_damper: bool = True
    delay: bool = True
    stribeck: bool = True
    relaxation: bool = False
    hysteresis: bool = False
    shape: bool = True  # whether the elastic law may differ from the exponential
    travel_std: float = 0.0
    travel_length: float = 1e-3
    encoder: bool = False
    level_density: float = 2.5e-8
    scale_density: float = 0.0
    rate_density: float = 0.0


MODELS = (
    Model("exponential", 0.28, spline_damper=False, delay=False, stribeck=False, shape=False),
    Model("exponential, any damper and friction", 0.08, shape=False),
    Model("any spring", 0.18, spline_damper=False, delay=False, stribeck=False),
    Model("any spring, delay", 0.085, spline_damper=False, stribeck=False),
    Model("any damper", 0.05, delay=False, stribeck=False),
    Model("any damper and friction", 0.05),
    Model("drift", 0.05, level_density=2.5e-5, scale_density=1e-6),
    Model("fast drift", 0.03, level_density=2.5e-5, scale_density=2e-5),
    Model("wandering level", 0.03, level_density=2.5e-5, scale_density=1e-6, rate_density=5e-3),
    Model("rough force", 0.03, travel_std=0.03, travel_length=0.7e-3, level_density=2.5e-5, scale_density=1e-7),
    Model("very rough force", 0.03, travel_std=0.12, travel_length=0.7e-3, level_density=4e-4, scale_density=1e-6),
    Model("cyclic encoder error", 0.03, travel_std=15e-6, travel_length=0.5e-3, encoder=True, level_density=2.5e-5,
        scale_density=1e-7),
    Model("relaxation", 0.06, relaxation=True),
    Model("hysteresis", 0.06, hysteresis=True, travel_std=0.03, travel_length=0.7e-3, level_density=2.5e-5,
        scale_density=1e-7),
)  # fmt: skip
NESTED = {0: 2, 1: 5}  # members with an exponential spring, by index, and what they differ from in the spring alone
SIMPLE = slice(2, 6)  # members with any spring, without drift, relaxation and hysteresis


def matern(at: NDArray[np.floating[Any]], length: float, std: float) -> Array:
    """Covariance (n, n) of a Gaussian process at the points `at` (n,): Matern 5/2 (Rasmussen and Williams, 2006)."""
    distance = np.abs(at[:, None] - at[None]) / length * math.sqrt(5.0)
    return np.asarray(std * std * (1.0 + distance + distance**2 / 3.0) * np.exp(-distance))


def peak_speed_of(initial: Initial) -> float:
    """v* [m/s] of the initial damper, or a usual one."""
    speed = float(peak_speed(initial.d1, initial.d2))
    return speed if speed < UNBOUNDED_SPEED else SPARE_SPEED


def geometry_at(initial: Initial, reference: float, growth: float, span: tuple[float, float] | None = None) -> Record:
    """(1,) GEOMETRY of splines of the stiffness relative to exp(growth (x - reference)), in 1/m and m.

    The elastic spline is centred on `span` [m], by default the reference, and has SPARE_INTERVALS on either side of it.
    """
    geometry, (first, last) = np.zeros(1, GEOMETRY), span or (reference, reference)
    spacing = max(SPRING_SPACING / initial.k2, (last - first) / (INTERVALS - 2 * SPARE_INTERVALS))
    geometry["growth"], geometry["reference"], geometry["spacing"] = growth, reference, spacing
    geometry["origin"], geometry["unit"] = 0.5 * (first + last) - 0.5 * INTERVALS * spacing, 1.0 / initial.k2
    geometry["speed_spacing"] = SPEED_SPACING * peak_speed_of(initial)
    fill_table(geometry)
    return geometry


def abscissas(geometry: Record) -> Array:
    """Deflections (SPRING_SIZE,) [m] at which the coefficients are the values of the spline, to second order."""
    return np.asarray(geometry["origin"] + (np.arange(SPRING_SIZE) - 1.0) * geometry["spacing"])


def members_at(initial: Initial, geometry: Record, force: float, deflection_variance: float) -> Record:
    """(n,) MEMBER, one for each of MODELS, at a first force [N] at the reference of `geometry`, (1,) GEOMETRY."""
    deflection = float(geometry["reference"][0])
    members = np.zeros(len(MODELS), MEMBER)
    for member, model in zip(members, MODELS, strict=True):
        noise = member["model"]
        for name in ("travel_std", "travel_length", "encoder", "level_density", "scale_density", "rate_density"):
            noise[name] = getattr(model, name)
        noise["spline_damper"], noise["exponential"] = model.spline_damper, not model.shape
        noise["relaxation"] = model.relaxation
        noise["ln_prior"] = math.log(model.prior)
        mean, covariance = member["mean"], member["covariance"]
        mean[X], mean[L], mean[M], mean[D0] = deflection, force, initial.inertia, initial.coulomb_friction
        covariance[np.diag_indices(SPRING)] = _standard_deviations(model, initial, deflection_variance) ** 2
        if model.spline_damper:
            _set_damper(mean, covariance, initial)
        else:
            mean[D1], mean[D2] = initial.d1, initial.d2
        mean[SPRING:] = initial.k2 * max(force - initial.force_offset, MIN_ELASTIC_FORCE)
        active = np.union1d(np.flatnonzero(np.diag(covariance) > 0.0), np.arange(SPRING, SIZE))
        active = np.union1d(active, [B]) if model.travel_std else active
        member["active"][: active.size], member["count"] = active, active.size
        member["linear"], member["driving"], member["deflection"] = mean, mean[SPRING:], deflection
        member["stiffness_inflation"] = member["damping_inflation"] = 1.0
    set_spring_prior(members, geometry)
    return members


def _standard_deviations(model: Model, initial: Initial, deflection_variance: float) -> Array:
    """Prior standard deviations of all states but the spring's (SPRING,)."""
    std = np.zeros(SPRING)
    std[[X, V]] = 2.0 * math.sqrt(deflection_variance), INITIAL_SPEED_STD
    std[[A, J]] = INITIAL_ACCELERATION_STD, INITIAL_JERK_STD
    std[[L, M, D0]] = LEVEL_STD, initial.inertia_std, initial.coulomb_friction_std
    std[LEVEL_RATE] = math.sqrt(0.5 * model.rate_density * LEVEL_RATE_TIME)
    std[DELAY] = DELAY_STD if model.delay else 0.0
    std[STRIBECK : STRIBECK + STRIBECK_SIZE] = STRIBECK_STD * initial.coulomb_friction_std * model.stribeck
    std[RELAXATION : RELAXATION + RELAXATION_SIZE] = RELAXATION_STD * model.relaxation
    std[HYSTERESIS : HYSTERESIS + HYSTERESIS_SIZE] = HYSTERESIS_STD * initial.coulomb_friction_std * model.hysteresis
    if not model.spline_damper:
        std[[D1, D2]] = initial.d1_std, CUBIC_STD * initial.d2_std
    return std


def _set_damper(mean: Array, covariance: Array, initial: Initial) -> None:
    part = slice(DAMPER, DAMPER + DAMPER_SIZE)
    at = (np.arange(DAMPER_SIZE) - 0.5) * SPEED_SPACING  # in v*
    mean[part] = initial.d1
    covariance[part, part] = initial.d1_std**2 + matern(at, DAMPER_SHAPE_LENGTH, DAMPER_SHAPE_STD * initial.d1)


def set_spring_prior(members: Record, geometry: Record) -> None:
    """Set the prior covariance of the elastic law of (n,) MEMBER at their prior mean, a constant, over `geometry`."""
    part, at = slice(SPRING, SIZE), (abscissas(geometry) - geometry["reference"]) / geometry["unit"]
    exponential = STIFFNESS_STD**2 + SLOPE_STD**2 * np.outer(at, at)
    general = exponential + matern(at, SHAPE_LENGTH, SHAPE_STD)
    for member in members:
        shape = exponential if member["model"]["exponential"] else general
        member["covariance"][part, part] = member["mean"][SPRING] ** 2 * shape


def transferred(coefficients: Array, geometry: Record, other: Record) -> Array:
    """Spring coefficients (n, SPRING_SIZE) of `geometry` for another geometry with the same reference."""
    before, after = abscissas(geometry), abscissas(other)
    grown = np.exp((geometry["growth"] - other["growth"]) * (after - geometry["reference"]))
    return np.stack([np.interp(after, before, one) * grown for one in coefficients])
