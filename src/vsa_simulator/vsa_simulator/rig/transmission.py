"""One transmission: exponential spring, damper, friction and mass behind a 2:1 moving pulley.

Deflection x > 0 elongates, rod force F = 2 T > 0 pulls, T the tendon's tension:
F = M x'' + F_d(x') + F_s(x), (6), with F_s = F0 + k1 exp(k2 x), (2).
"""

import math
from typing import NamedTuple

from vsa_common.accel import compiled
from vsa_simulator.rig.config import FrictionConfig, TransmissionConfig

LONGEST_STEP = 5e-5  # [s]
STEPS_PER_RATE = 1.5  # a step times the fastest rate; Runge-Kutta of fourth order is stable up to 2.7


class Transmission(NamedTuple):
    """Numbers of one transmission for the integrator; SI, names as in its configuration."""

    force_offset: float
    k1: float
    k2: float
    d1: float
    d2: float
    coulomb_friction: float
    inertia: float
    tendon_stiffness: float
    peak_speed: float  # where the cubic damper has its greatest force
    sticks: bool
    smoothing_speed: float
    bristle_stiffness: float
    bristle_damping: float
    static_friction: float
    stribeck_speed: float


def transmission_from(config: TransmissionConfig, friction: FrictionConfig) -> Transmission:
    """The numbers that a configuration describes."""
    return Transmission(
        config.force_offset,
        config.k1,
        config.k2,
        config.d1,
        config.d2,
        config.coulomb_friction,
        config.inertia,
        config.tendon_stiffness,
        math.sqrt(config.d1 / (-3.0 * config.d2)),
        friction.model == "lugre",
        friction.smoothing_speed,
        friction.bristle_stiffness,
        friction.bristle_damping,
        friction.static_ratio * config.coulomb_friction,
        friction.stribeck_speed,
    )


@compiled
def spring_force(x: float, p: Transmission) -> float:
    """Elastic force at deflection `x`, (2) [N]."""
    return p.force_offset + p.k1 * math.exp(p.k2 * x)


@compiled
def spring_deflection(force: float, p: Transmission) -> float:
    """Deflection at which the spring bears `force` [m]; the inverse of (2)."""
    return math.log(max(force - p.force_offset, 1e-9) / p.k1) / p.k2


@compiled
def stiffness(x: float, p: Transmission) -> float:
    """Stiffness at deflection `x`, (3) [N/m]."""
    return p.k1 * p.k2 * math.exp(p.k2 * x)


@compiled
def damper_force(v: float, p: Transmission) -> float:
    """Viscous force at speed `v`, (5), held at its maximum beyond the speed where the cubic turns down [N]."""
    c = min(max(v, -p.peak_speed), p.peak_speed)
    return p.d1 * c + p.d2 * c**3


@compiled
def damping(v: float, p: Transmission) -> float:
    """Damping at speed `v`, (8) [N s/m]; zero where the force is held."""
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
    # bristles that bend faster than a step would blow up; slowing them leaves the friction of steady sliding as it is
    return rate * min(1.0, STEPS_PER_RATE / LONGEST_STEP / max(relaxation, 1.0))


@compiled
def friction_force(v: float, z: float, p: Transmission) -> float:
    """Dry friction [N]: d0 tanh(v / smoothing speed), or what the bristles bear."""
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
    """How many integration steps a sample needs to resolve the rod's fastest motion."""
    if p.sticks:
        viscous, elastic = p.d1 + p.bristle_damping, 4.0 * p.tendon_stiffness + p.bristle_stiffness
    else:
        viscous, elastic = p.d1 + p.coulomb_friction / p.smoothing_speed, 4.0 * p.tendon_stiffness
    fastest = max(viscous / p.inertia, math.sqrt(elastic / p.inertia))
    return math.ceil(1.0 / (rate_hz * min(LONGEST_STEP, STEPS_PER_RATE / fastest)))
