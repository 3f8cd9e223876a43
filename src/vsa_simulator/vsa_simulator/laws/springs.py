# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic laws. Each is a function of u = deflection / full stroke, from 0 at u = 0 to 1 at u = 1, strictly increasing.

Law, u and parameters are dimensionless. A law becomes a force [N] by the transmission's own scale,
F_s = F0 + k1 + (k1 exp(k2 L) - k1) law(x / L), L the full stroke, so that every law has the force of the paper's spring
(2) at both ends of the stroke. A new law is one function and one line of SPRINGS; its stiffness follows by the complex
step, hence abs, min and max of `u` are not permitted in it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from vsa_common.config.configuration import ConfigurationError, choice, quantities, quantity
from vsa_common.types import Array
from vsa_simulator.laws.curve import Complex

EXPONENTIAL = "exponential"  # the paper's, evaluated in closed form


def linear(u: Complex, config: "SpringConfig") -> Complex:
    """u: Hooke's law, constant stiffness; the antagonistic joint cannot vary its stiffness with it."""
    return u


def quadratic(u: Complex, config: "SpringConfig") -> Complex:
    """s u + (1 - s) u |u|: stiffness linear in deflection; Migliore, Brown, DeWeerth, ICRA 2005. s: initial_slope."""
    return config.initial_slope * u + (1.0 - config.initial_slope) * u * u * np.sign(u.real)


def cubic(u: Complex, config: "SpringConfig") -> Complex:
    """s u + (1 - s) u^3: the Duffing spring, s: initial_slope."""
    return config.initial_slope * u + (1.0 - config.initial_slope) * u**3


def sinh(u: Complex, config: "SpringConfig") -> Complex:
    """sinh(b u) / sinh(b): form of the qbmove's data sheet; Della Santina et al. 2017; b: sinh_rate."""
    return np.sinh(config.sinh_rate * u) / np.sinh(config.sinh_rate)


def stop(u: Complex, config: "SpringConfig") -> Complex:
    """(c - 1) u / (c - u): hardens towards a stop at u = c, as a spring whose coils close; c: stop_ratio."""
    return (config.stop_ratio - 1.0) * u / (config.stop_ratio - u)


def softening(u: Complex, config: "SpringConfig") -> Complex:
    """(1 - exp(-b u)) / (1 - exp(-b)): stiffness falls with deflection, as of rubber in shear; b: softening_rate."""
    return np.expm1(-config.softening_rate * u) / np.expm1(-config.softening_rate)


def tabulated(u: Complex, config: "SpringConfig") -> Complex:
    """Points at equal distances from u = 0 to 1, joined by monotone cubics (Fritsch and Carlson 1980): `table`."""
    points = np.array(config.table)
    if points.size < 3 or np.any(np.diff(points) <= 0.0):
        raise ConfigurationError(f"spring.table = {list(config.table)}: must have three values or more that increase")
    points = (points - points[0]) / (points[-1] - points[0])
    slopes, last = monotone_slopes(points), len(points) - 1
    i = np.clip(np.floor(u.real * last).astype(int), 0, last - 1)
    t = u * last - i
    rise, begin, end = points[i + 1] - points[i], slopes[i], slopes[i + 1]
    inner = points[i] + t * (begin + t * (3.0 * rise - 2.0 * begin - end + t * (begin + end - 2.0 * rise)))
    return np.where(t.real < 0.0, points[i] + t * begin, np.where(t.real > 1.0, points[i + 1] + (t - 1.0) * end, inner))


SPRINGS: dict[str, Callable[[Complex, "SpringConfig"], Complex]] = {
    law.__name__: law for law in (linear, quadratic, cubic, sinh, stop, softening, tabulated)
}


@dataclass(frozen=True)
class SpringConfig:
    """Elastic law of both transmissions, and its slow drift."""

    kind: str = choice(EXPONENTIAL, (EXPONENTIAL, *SPRINGS), "elastic law; all have the same force at full stroke")
    full_stroke: float = quantity(0.020, "m", 0.001, 1.0, "deflection at which each law has the exponential's force")
    initial_slope: float = quantity(0.08, "", 0.001, 1.0, "quadratic, cubic: stiffness at zero deflection over mean")
    sinh_rate: float = quantity(4.4, "", 0.1, 20.0, "sinh: rate times full stroke; 4.4 is 0.22 1/mm")
    stop_ratio: float = quantity(1.1, "", 1.06, 10.0, "stop: deflection of the stop over full stroke")
    softening_rate: float = quantity(1.5, "", 0.1, 10.0, "softening: rate times full stroke")
    table: tuple[float, ...] = quantities(
        (0.0, 0.015, 0.035, 0.065, 0.11, 0.18, 0.28, 0.41, 0.57, 0.77, 1.0),
        "",
        -1e6,
        1e6,
        "tabulated: elastic force at equal distances from zero deflection to full stroke, in any unit",
    )
    drift: float = quantity(0.0, "%/min", -100.0, 100.0, "change of the elastic force, F0 excluded, with time")


def monotone_slopes(points: Array) -> Array:
    """Slopes at increasing points of unit distance: harmonic mean of the secants (Fritsch and Butland 1984)."""
    secants = np.diff(points)
    inner = 2.0 * secants[1:] * secants[:-1] / (secants[1:] + secants[:-1])
    return np.concatenate([[_end_slope(secants[0], secants[1])], inner, [_end_slope(secants[-1], secants[-2])]])


def _end_slope(near: float, far: float) -> float:
    """Three-point slope at an end, between a tenth and three times the next secant, so that the curve increases."""
    return min(max(1.5 * near - 0.5 * far, 0.1 * near), 3.0 * near)
