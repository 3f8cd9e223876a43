# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One transmission: spring, damper, friction, internal forces and mass behind a 2:1 moving pulley.

Deflection x > 0 elongates, rod force F = 2 T > 0 pulls, T the tendon's tension:
F = M x'' + F_d(x') + F_f(x') + F_s(x, t) + q + h y, (6), with F_s = F0 + s(t) E(x), s the drift of the spring, q the
viscoelastic branch, h y the hysteresis. The paper's rig has E = k1 exp(k2 x), (2), s = 1, q = h = 0.
"""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.curve import NO_CURVE, Curve, argument_at, curve_of, greatest_slope, slope_at, value_at
from vsa_simulator.laws.dampers import CUBIC, DAMPERS, TOP_SPEED
from vsa_simulator.laws.friction import LUGRE, Friction, bristle_rate, friction_force, friction_from
from vsa_simulator.laws.internal import branch_rate, hysteresis_rate
from vsa_simulator.laws.springs import EXPONENTIAL, SPRINGS
from vsa_simulator.rig.config import TransmissionConfig

MAX_STEP = 5e-5  # [s]
STEPS_PER_RATE = 1.5  # step times fastest rate; the Runge-Kutta method of fourth order is stable up to 2.7
FASTEST_RATE = STEPS_PER_RATE / MAX_STEP  # [1/s]
STROKE = (-0.05, 1.05)  # range of a spring's table in full strokes, 0 and 1 at nodes; beyond it a straight line
LEAST_SCALE = 0.05  # of the elastic force after a long fall


class Rod(NamedTuple):
    """State of a rod, or its time derivative; SI."""

    x: float  # deflection
    v: float
    z: float  # bristles of the friction
    q: float  # force of the viscoelastic branch
    y: float  # hysteretic force over its amplitude


class Transmission(NamedTuple):
    """Parameters of one transmission for the integrator; SI, names as in its configuration."""

    force_offset: float
    k1: float
    k2: float
    d1: float
    d2: float
    inertia: float
    tendon_stiffness: float
    peak_speed: float  # at the maximum of the cubic damper's force
    greatest_damping: float
    greatest_stiffness: float  # of a tabulated spring
    drift: float  # of the elastic force [1/s]
    share: float  # of the viscoelastic branch
    time_constant: float
    hysteresis: float  # [N]
    hysteresis_travel: float
    hysteresis_shape: float
    exponential: bool  # else `spring` holds the law
    cubic: bool  # else `damper` holds the law
    friction: Friction
    spring: Curve
    damper: Curve


def transmission_from(config: TransmissionConfig, laws: ForceLaws) -> Transmission:
    """Parameters of a configuration. Raises ConfigurationError for a table that does not increase."""
    spring, damper = _spring_of(config, laws), _damper_of(config, laws)
    exponential, cubic = laws.spring.kind == EXPONENTIAL, laws.damper.kind == CUBIC
    memory = laws.viscoelastic.share > 0.0 or laws.hysteresis.amplitude > 0.0
    paper = exponential and cubic and not memory
    return Transmission(
        force_offset=config.force_offset,
        k1=config.k1,
        k2=config.k2,
        d1=config.d1,
        d2=config.d2,
        inertia=config.inertia,
        tendon_stiffness=config.tendon_stiffness,
        peak_speed=_peak_speed(config),
        greatest_damping=config.d1 if cubic else greatest_slope(damper),
        greatest_stiffness=0.0 if exponential else greatest_slope(spring),
        drift=laws.spring.drift / 100.0 / 60.0,
        share=laws.viscoelastic.share,
        time_constant=laws.viscoelastic.time_constant,
        hysteresis=laws.hysteresis.amplitude,
        hysteresis_travel=laws.hysteresis.travel,
        hysteresis_shape=laws.hysteresis.shape,
        exponential=exponential,
        cubic=cubic,
        friction=friction_from(config.coulomb_friction, laws.friction),
        spring=NO_CURVE if paper else spring,
        damper=NO_CURVE if paper else damper,
    )


def _spring_of(config: TransmissionConfig, laws: ForceLaws) -> Array:
    """Elastic force without F0 over the deflection, k1 at zero and k1 exp(k2 L) at full stroke L."""
    if laws.spring.kind == EXPONENTIAL:
        return np.zeros(2 * len(NO_CURVE))
    law, stroke = SPRINGS[laws.spring.kind], laws.spring.full_stroke
    rise = config.k1 * math.expm1(config.k2 * stroke)
    return curve_of(lambda x: config.k1 + rise * law(x / stroke, laws.spring), STROKE[0] * stroke, STROKE[1] * stroke)


def _damper_of(config: TransmissionConfig, laws: ForceLaws) -> Array:
    """Viscous force over the speed."""
    if laws.damper.kind == CUBIC:
        return np.zeros(2 * len(NO_CURVE))
    law, peak = DAMPERS[laws.damper.kind], _peak_speed(config)
    return curve_of(lambda speed: config.d1 * peak * law(speed / peak, laws.damper), 0.0, TOP_SPEED)


def _peak_speed(config: TransmissionConfig) -> float:
    return math.sqrt(config.d1 / (-3.0 * config.d2))


@compiled
def _is_general(p: Transmission) -> bool:
    """Whether other laws than the paper's act: a constant of the compiled code, which drops what it does not need."""
    return len(p.spring) > len(NO_CURVE)


@compiled
def elastic_scale(time: float, p: Transmission) -> float:
    """Scale s of the elastic force at `time` [s], 1 at the start."""
    return max(1.0 + p.drift * time, LEAST_SCALE)


@compiled
def elastic_force(x: float, p: Transmission) -> float:
    """Elastic force without F0 and drift at deflection `x` [N]; for the exponential the second term of (2)."""
    if p.exponential or not _is_general(p):
        return p.k1 * math.exp(p.k2 * x)
    return value_at(x, p.spring)


@compiled
def spring_force(x: float, p: Transmission) -> float:
    """Force of the spring without drift at deflection `x`, (2) [N]."""
    return p.force_offset + elastic_force(x, p)


@compiled
def spring_deflection(force: float, p: Transmission) -> float:
    """Deflection at which the force of the spring is `force` [m]; the inverse of `spring_force`."""
    if p.exponential or not _is_general(p):
        return math.log(max(force - p.force_offset, 1e-9) / p.k1) / p.k2
    return argument_at(force - p.force_offset, p.spring)


@compiled
def stiffness(x: float, p: Transmission) -> float:
    """Slope of the static elastic law without drift at deflection `x`, (3) [N/m]."""
    if p.exponential or not _is_general(p):
        return p.k1 * p.k2 * math.exp(p.k2 * x)
    return slope_at(x, p.spring)


def ln_stiffness_slope(x: float, p: Transmission) -> float:
    """Slope of ln(stiffness) over the deflection at `x` [1/m]: k2 of the exponential that osculates the elastic law."""
    if p.exponential:
        return p.k2
    step = 1e-5
    return math.log(stiffness(x + step, p) / stiffness(x - step, p)) / (2.0 * step)


@compiled
def damper_force(v: float, p: Transmission) -> float:
    """Viscous force at velocity `v` [N]; the cubic (5) is constant beyond its maximum."""
    if p.cubic or not _is_general(p):
        c = min(max(v, -p.peak_speed), p.peak_speed)
        return p.d1 * c + p.d2 * c**3
    return math.copysign(value_at(abs(v), p.damper), v)


@compiled
def damping(v: float, p: Transmission) -> float:
    """Slope of the viscous force at velocity `v`, (8) [N s/m]; zero where the force is constant."""
    if p.cubic or not _is_general(p):
        c = min(max(v, -p.peak_speed), p.peak_speed)
        return p.d1 + 3.0 * p.d2 * c * c
    return slope_at(abs(v), p.damper)


@compiled
def rod_rates(rod: Rod, time: float, tension: float, p: Transmission) -> Rod:
    """Time derivative of a rod's state under a tendon of `tension` [N], (6) solved for x''."""
    x, v, z, q, y = rod
    scale = elastic_scale(time, p)
    bristle = bristle_rate(v, z, FASTEST_RATE, p.friction)
    friction = friction_force(v, z, bristle, p.friction)
    spring = p.force_offset + scale * elastic_force(x, p)
    force = 2.0 * tension - spring - damper_force(v, p) - friction - (q + p.hysteresis * y)
    if not _is_general(p):
        return Rod(v, force / p.inertia, bristle, 0.0, 0.0)
    branch = branch_rate(q, v, scale * stiffness(x, p), p.share, p.time_constant)
    hysteresis = hysteresis_rate(y, v, p.hysteresis_travel, p.hysteresis_shape)
    return Rod(v, force / p.inertia, bristle, branch, hysteresis)


def substeps_for(rate_hz: float, p: Transmission) -> int:
    """Integration steps of a sample that resolve the rod's fastest mode."""
    viscous, elastic, friction = p.greatest_damping, 4.0 * p.tendon_stiffness, p.friction
    if friction.kind == LUGRE:
        viscous, elastic = viscous + friction.bristle_damping, elastic + friction.bristle_stiffness
    else:
        viscous += (friction.coulomb + friction.dip) / friction.smoothing_speed
    elastic += p.greatest_stiffness + p.hysteresis / p.hysteresis_travel
    fastest = max(viscous / p.inertia, math.sqrt(elastic / p.inertia))
    return math.ceil(1.0 / (rate_hz * min(MAX_STEP, STEPS_PER_RATE / fastest)))
