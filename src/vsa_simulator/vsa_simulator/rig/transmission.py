"""One transmission: exponential spring, damper, friction and mass behind a 2:1 moving pulley.

Deflection x > 0 elongates, rod force F = 2 T > 0 pulls, T the tendon's tension:
F = M x'' + F_d(x') + F_s(x), (6), with F_s = F0 + k1 exp(k2 x), (2).
"""

import math
from typing import NamedTuple

from vsa_common.accel import compiled
from vsa_simulator.rig.config import FrictionConfig, TransmissionConfig

MAX_STEP = 5e-5  # [s]
STEPS_PER_RATE = 1.5  # step times fastest rate; the Runge-Kutta method of fourth order is stable up to 2.7


class Transmission(NamedTuple):
    """Parameters of one transmission for the integrator; SI, names as in its configuration."""

    force_offset: float
    k1: float
    k2: float
    d1: float
    d2: float
    coulomb_friction: float
    inertia: float
    tendon_stiffness: float
    peak_speed: float  # at the maximum of the cubic damper's force
    sticks: bool  # LuGre friction
    smoothing_speed: float
    bristle_stiffness: float
    bristle_damping: float
    static_friction: float
    stribeck_speed: float


def transmission_from(config: TransmissionConfig, friction: FrictionConfig) -> Transmission:
    """Parameters of a configuration."""
    return Transmission(
        force_offset=config.force_offset,
        k1=config.k1,
        k2=config.k2,
        d1=config.d1,
        d2=config.d2,
        coulomb_friction=config.coulomb_friction,
        inertia=config.inertia,
        tendon_stiffness=config.tendon_stiffness,
        peak_speed=math.sqrt(config.d1 / (-3.0 * config.d2)),
        sticks=friction.model == "lugre",
        smoothing_speed=friction.smoothing_speed,
        bristle_stiffness=friction.bristle_stiffness,
        bristle_damping=friction.bristle_damping,
        static_friction=friction.static_ratio * config.coulomb_friction,
        stribeck_speed=friction.stribeck_speed,
    )


@compiled
def spring_force(x: float, p: Transmission) -> float:
    """Elastic force at deflection `x`, (2) [N]."""
    return p.force_offset + p.k1 * math.exp(p.k2 * x)


@compiled
def spring_deflection(force: float, p: Transmission) -> float:
    """Deflection at which the elastic force is `force` [m]; the inverse of (2)."""
    return math.log(max(force - p.force_offset, 1e-9) / p.k1) / p.k2


@compiled
def stiffness(x: float, p: Transmission) -> float:
    """Stiffness at deflection `x`, (3) [N/m]."""
    return p.k1 * p.k2 * math.exp(p.k2 * x)


@compiled
def damper_force(v: float, p: Transmission) -> float:
    """Viscous force at speed `v`, (5), constant beyond the maximum of the cubic [N]."""
    c = min(max(v, -p.peak_speed), p.peak_speed)
    return p.d1 * c + p.d2 * c**3


@compiled
def damping(v: float, p: Transmission) -> float:
    """Damping at speed `v`, (8) [N s/m]; zero where the force is constant."""
    c = min(max(v, -p.peak_speed), p.peak_speed)
    return p.d1 + 3.0 * p.d2 * c * c


@compiled
def bristle_rate(v: float, z: float, p: Transmission) -> float:
    """Rate of the mean bristle deflection `z` of the LuGre model [m/s]; 0 in the tanh model."""
    if not p.sticks or p.coulomb_friction == 0.0:
        return 0.0
    slip = p.coulomb_friction + (p.static_friction - p.coulomb_friction) * math.exp(-((v / p.stribeck_speed) ** 2))
    relaxation = p.bristle_stiffness * abs(v) / slip
    rate = v - relaxation * z
    # a rate beyond the stability limit of the step diverges; limiting it keeps the friction of steady sliding
    return rate * min(1.0, STEPS_PER_RATE / MAX_STEP / max(relaxation, 1.0))


@compiled
def friction_force(v: float, z: float, p: Transmission) -> float:
    """Dry friction [N]: d0 tanh(v / smoothing speed), or the force of the bristles."""
    if not p.sticks:
        return p.coulomb_friction * math.tanh(v / p.smoothing_speed)
    if p.coulomb_friction == 0.0:
        return 0.0
    return p.bristle_stiffness * z + p.bristle_damping * bristle_rate(v, z, p)


@compiled
def rod_acceleration(x: float, v: float, z: float, tension: float, p: Transmission) -> float:
    """Acceleration of the rod under a tendon of `tension`, (6) solved for x'' [m/s^2]."""
    return (2.0 * tension - spring_force(x, p) - damper_force(v, p) - friction_force(v, z, p)) / p.inertia


def substeps_for(rate_hz: float, p: Transmission) -> int:
    """Integration steps of a sample that resolve the rod's fastest mode."""
    if p.sticks:
        viscous, elastic = p.d1 + p.bristle_damping, 4.0 * p.tendon_stiffness + p.bristle_stiffness
    else:
        viscous, elastic = p.d1 + p.coulomb_friction / p.smoothing_speed, 4.0 * p.tendon_stiffness
    fastest = max(viscous / p.inertia, math.sqrt(elastic / p.inertia))
    return math.ceil(1.0 / (rate_hz * min(MAX_STEP, STEPS_PER_RATE / fastest)))
