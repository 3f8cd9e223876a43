# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Dry friction of the rod: d0 tanh, the same with a Stribeck dip, or LuGre's bristles."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from vsa_common.accel import compiled
from vsa_common.config.configuration import choice, quantity

TANH, STRIBECK, LUGRE = range(3)
FRICTIONS = {"tanh": TANH, "stribeck": STRIBECK, "lugre": LUGRE}


@dataclass(frozen=True)
class FrictionConfig:
    """Model of dry friction about zero velocity."""

    model: str = choice(
        "tanh", tuple(FRICTIONS), "tanh: smooth; stribeck: tanh, more friction when slow; lugre: bristles, stick-slip"
    )
    smoothing_speed: float = quantity(5e-5, "m/s", 1e-6, 1e-2, "tanh, stribeck: speed at which tanh is 0.76")
    bristle_stiffness: float = quantity(1e6, "N/m", 1e4, 1e8, "lugre: stiffness of the contact before it slips")
    bristle_damping: float = quantity(0.0, "N s/m", 0.0, 1e5, "lugre: damping of the contact before it slips")
    static_ratio: float = quantity(1.5, "", 1.0, 5.0, "lugre: breakaway force over d0; 1 makes it Dahl's model")
    stribeck_speed: float = quantity(1e-4, "m/s", 1e-6, 1e-1, "lugre: speed at which friction has fallen to d0")
    dip: float = quantity(1.0, "", 0.0, 5.0, "stribeck: additional friction when slow, over d0")
    dip_speed: float = quantity(3e-4, "m/s", 1e-6, 1e-1, "stribeck: speed at which it has fallen to 37 %")


class Friction(NamedTuple):
    """Parameters for the integrator, SI."""

    kind: int  # of FRICTIONS
    coulomb: float  # d0 [N]
    smoothing_speed: float
    bristle_stiffness: float
    bristle_damping: float
    static: float  # [N]
    stribeck_speed: float
    dip: float  # [N]
    dip_speed: float


def friction_from(coulomb: float, config: FrictionConfig) -> Friction:
    """Parameters of a configuration with Coulomb friction `coulomb`, d0 [N]."""
    return Friction(
        kind=FRICTIONS[config.model],
        coulomb=coulomb,
        smoothing_speed=config.smoothing_speed,
        bristle_stiffness=config.bristle_stiffness,
        bristle_damping=config.bristle_damping,
        static=config.static_ratio * coulomb,
        stribeck_speed=config.stribeck_speed,
        dip=config.dip * coulomb if config.model == "stribeck" else 0.0,
        dip_speed=config.dip_speed,
    )


@compiled
def friction_force(v: float, z: float, bristle_rate: float, p: Friction) -> float:
    """Dry friction at velocity `v` and bristle deflection `z` [N].

    tanh: d0 tanh(v / v_s).
    stribeck: (d0 + dip exp(-(v / v_d)^2)) tanh(v / v_s); Stribeck 1902, Armstrong-Helouvry et al. 1994.
    lugre: s0 z + s1 dz/dt; Canudas de Wit et al. 1995.
    """
    if p.kind == TANH:
        return p.coulomb * math.tanh(v / p.smoothing_speed)
    if p.kind == STRIBECK:
        return (p.coulomb + p.dip * math.exp(-((v / p.dip_speed) ** 2))) * math.tanh(v / p.smoothing_speed)
    if p.coulomb == 0.0:
        return 0.0
    return p.bristle_stiffness * z + p.bristle_damping * bristle_rate


@compiled
def bristle_rate(v: float, z: float, fastest: float, p: Friction) -> float:
    """Rate of the mean bristle deflection `z` of the LuGre model [m/s]; 0 in the others.

    dz/dt = v - s0 |v| z / (d0 + (static - d0) exp(-(v / v_st)^2)). A rate beyond `fastest` [1/s], which the step of the
    integration resolves, would diverge; limiting it keeps the friction of steady sliding.
    """
    if p.kind != LUGRE or p.coulomb == 0.0:
        return 0.0
    slip = p.coulomb + (p.static - p.coulomb) * math.exp(-((v / p.stribeck_speed) ** 2))
    relaxation = p.bristle_stiffness * abs(v) / slip
    return (v - relaxation * z) * min(1.0, fastest / max(relaxation, 1.0))
