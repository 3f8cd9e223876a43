# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Viscous laws. Each is a function of w = speed / v* for w >= 0, odd in velocity, in units of d1 v*.

d1 is the damping at rest of the paper's damper (5), v* = sqrt(d1 / (-3 d2)) the speed of its greatest force,
2/3 d1 v*. A new law is one function and one line of DAMPERS; its damping follows by the complex step, hence abs, min
and max of `w` are not permitted in it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from vsa_common.config.configuration import choice, quantity
from vsa_simulator.laws.curve import Complex

CUBIC = "cubic"  # the paper's, evaluated in closed form
TOP_SPEED = 0.025  # [m/s] end of the tables: half the speed limit of the motors' tendons


def linear(w: Complex, config: "DamperConfig") -> Complex:
    """w: constant damping d1 (Stokes)."""
    return w


def quadratic(w: Complex, config: "DamperConfig") -> Complex:
    """r w + (2/3 - r) w^2: orifice flow, damping r d1 at rest, force of the paper's damper at v*; r: rest_ratio."""
    return config.rest_ratio * w + (2.0 / 3.0 - config.rest_ratio) * w * w


def soft_knee(w: Complex, config: "DamperConfig") -> Complex:
    """2/3 tanh(3/2 w): damping d1 at rest, greatest force of the paper's damper, reached gradually."""
    return 2.0 / 3.0 * np.tanh(1.5 * w)


DAMPERS: dict[str, Callable[[Complex, "DamperConfig"], Complex]] = {
    law.__name__: law for law in (linear, quadratic, soft_knee)
}


@dataclass(frozen=True)
class DamperConfig:
    """Viscous law of both transmissions."""

    kind: str = choice(CUBIC, (CUBIC, *DAMPERS), "viscous law; cubic: the paper's (5)")
    rest_ratio: float = quantity(0.25, "", 0.01, 0.66, "quadratic: damping at rest over d1")
