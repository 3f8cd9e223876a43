# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Spline bases: cubic B-splines of the relative stiffness, quadratic B-splines of the damping over |v|."""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.general.records import DAMPER_SIZE, INTERVALS, SPRING_SIZE, Record

NODES = np.array([-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526])  # Gauss-Legendre
WEIGHTS = np.array([0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538])
MAX_EXPONENT = 30.0
MAX_CELLS = 1e6


@compiled
def cubic(u: float, w: Array) -> None:
    """Four cubic B-splines at u in 0 to 1 of their interval, into `w` (4,)."""
    w[0] = (1.0 - u) ** 3 / 6.0
    w[1] = (4.0 - 6.0 * u * u + 3.0 * u**3) / 6.0
    w[2] = (1.0 + 3.0 * u + 3.0 * u * u - 3.0 * u**3) / 6.0
    w[3] = u**3 / 6.0


@compiled
def cubic_slope(u: float, w: Array) -> None:
    """Derivatives of `cubic` by u, into `w` (4,)."""
    w[0] = -0.5 * (1.0 - u) ** 2
    w[1] = 0.5 * (3.0 * u * u - 4.0 * u)
    w[2] = 0.5 * (1.0 + 2.0 * u - 3.0 * u * u)
    w[3] = 0.5 * u * u


@compiled
def locate(x: float, origin: float, spacing: float) -> tuple[int, float]:
    """Interval of x [m] and position within it, 0 to 1; limited to the ends of the spline."""
    s = min(max((x - origin) / spacing, -MAX_CELLS), MAX_CELLS)
    i = min(max(math.floor(s), 0), INTERVALS - 1)
    return i, min(max(s - i, 0.0), 1.0)


@compiled
def elastic_spline(geometry: Record, x: float, w: Array, slope: Array) -> int:
    """Index of the first of four cubic B-splines at x [m]; values and derivatives by x into `w` and `slope` (4,).

    Beyond the ends of the spline they are constant.
    """
    origin, spacing = geometry[0]["origin"], geometry[0]["spacing"]
    i, u = locate(x, origin, spacing)
    cubic(u, w)
    cubic_slope(u, slope)
    inside = 0.0 <= x - origin <= INTERVALS * spacing
    for j in range(4):
        slope[j] = slope[j] / spacing if inside else 0.0
    return i


@compiled
def extrapolation(geometry: Record, x: float) -> float:
    """Distance of x from the spline, in 1 / k2 of the prior; 0 within it."""
    start, one = geometry[0]["origin"], geometry[0]
    return float(max(start - x, x - start - INTERVALS * one["spacing"], 0.0) / one["unit"])


@compiled
def growth_factor(geometry: Record, x: float) -> float:
    """exp(kappa (x - reference)), limited."""
    exponent = geometry[0]["growth"] * (x - geometry[0]["reference"])
    return math.exp(min(max(exponent, -MAX_EXPONENT), MAX_EXPONENT))


@compiled
def add_integrals(geometry: Record, i: int, left: float, x: float, out: Array) -> None:
    """Add the integrals of exp(kappa (x - reference)) B_j over left to x, within interval i, to `out` (SPRING_SIZE,).

    Beyond the ends of the spline B_j is constant.
    """
    end = geometry[0]["origin"] + (i + 1) * geometry[0]["spacing"]
    if x > end:
        _add_smooth(geometry, i, left, end, out)
        left = end
    _add_smooth(geometry, i, left, x, out)


@compiled
def _add_smooth(geometry: Record, i: int, left: float, x: float, out: Array) -> None:
    """`add_integrals` where x is not beyond the end of interval i, or left and x both are."""
    origin, spacing = geometry[0]["origin"], geometry[0]["spacing"]
    w = np.empty(4)
    half, middle = 0.5 * (x - left), 0.5 * (x + left)
    for n in range(4):
        at = middle + half * NODES[n]
        cubic(min(max((at - origin) / spacing - i, 0.0), 1.0), w)
        scale = WEIGHTS[n] * half * growth_factor(geometry, at)
        for j in range(4):
            out[i + j] += scale * w[j]


def fill_table(geometry: Record) -> None:
    """Write the integrals from the reference to each knot into the table of `geometry`, (1,) GEOMETRY."""
    origin, spacing = float(geometry["origin"][0]), float(geometry["spacing"][0])
    table = np.zeros((INTERVALS + 1, SPRING_SIZE))
    for i in range(INTERVALS):
        table[i + 1] = table[i]
        add_integrals(geometry, i, origin + i * spacing, origin + (i + 1) * spacing, table[i + 1])
    reference = float(geometry["reference"][0])
    i, _ = locate(reference, origin, spacing)
    at_reference = table[i].copy()
    add_integrals(geometry, i, origin + i * spacing, reference, at_reference)
    geometry["table"][0] = table - at_reference


@compiled
def damping_spline(v: float, spacing: float, w: Array, slope: Array) -> int:
    """Index of the first of three quadratic B-splines at |v|; values and derivatives by v into `w` and `slope`."""
    s = min(abs(v) / spacing, MAX_CELLS)
    i = int(s) if s < DAMPER_SIZE else DAMPER_SIZE  # also of NaN
    u = s - i
    side = 1.0 if v >= 0.0 else -1.0
    if i >= DAMPER_SIZE - 2:  # constant beyond the last knot
        i, u, side = DAMPER_SIZE - 3, 1.0, 0.0
    w[0], w[1], w[2] = 0.5 * (1.0 - u) ** 2, 0.5 + u - u * u, 0.5 * u * u
    slope[0], slope[1], slope[2] = -side * (1.0 - u) / spacing, side * (1.0 - 2.0 * u) / spacing, side * u / spacing
    return i


@compiled
def damper_integrals(v: float, spacing: float, out: Array) -> None:
    """Integrals of the quadratic B-splines from 0 to |v|, odd in v [m/s], into `out` (DAMPER_SIZE,)."""
    out[:] = 0.0
    scale = spacing if v >= 0.0 else -spacing
    rest = min(abs(v) / spacing, MAX_CELLS)
    i = 0
    while rest > 0.0:
        if i >= DAMPER_SIZE - 2:  # constant beyond the last knot
            out[DAMPER_SIZE - 2] += 0.5 * scale * rest
            out[DAMPER_SIZE - 1] += 0.5 * scale * rest
            break
        u = min(rest, 1.0)
        out[i] += scale * (1.0 - (1.0 - u) ** 3) / 6.0
        out[i + 1] += scale * (0.5 * u + 0.5 * u * u - u**3 / 3.0)
        out[i + 2] += scale * u**3 / 6.0
        rest -= u
        i += 1
