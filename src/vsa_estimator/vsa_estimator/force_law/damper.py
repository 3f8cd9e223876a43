# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cubic damper, eq. (5): d1 v + d2 v^3 up to the peak speed v*, constant beyond it (a passive damper does not push)."""

import math

from vsa_common import damper
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.state import D1, D2, V
from vsa_estimator.tuning.force_law import (
    MAX_CUBIC_STD,
    MAX_RELATIVE_SPEED_STD,
    PEAK_SPEED_MARGIN,
    UNBOUNDED_SPEED,
)

_peak_speed = compiled(damper.peak_speed)


@compiled
def peak_speed(d1: float, d2: float) -> float:
    """Speed v* [m/s] of the greatest damper force, eq. (5); UNBOUNDED_SPEED where it is above every speed."""
    return min(_peak_speed(d1, d2), UNBOUNDED_SPEED)


@compiled
def known_speed(d1: float, d2: float, d2_variance: float, limit: float) -> float:
    """Speed [m/s] up to which the damper force is known: v* where d2 determines it, else below v* and `limit` [m/s].

    A cubic without a peak, as that of a damper that grows with the speed, is an extrapolation. Beyond v* nothing damps
    a vibration of the rod.
    """
    peak = peak_speed(d1, d2)
    known = d2 < 0.0 and d2_variance < (MAX_CUBIC_STD * d2) ** 2
    return peak if known else PEAK_SPEED_MARGIN * min(peak, limit)


@compiled
def clip_speed(v: float, v_peak: float) -> float:
    """Speed [m/s] limited to +-v*."""
    return min(max(v, -v_peak), v_peak)


@compiled
def damper_terms(d1: float, d2: float, c: float) -> tuple[float, float]:
    """Linear and cubic part of the damper force [N] at the limited speed c [m/s]."""
    return d1 * c, d2 * c * c * c


@compiled
def damping(d1: float, d2: float, c: float) -> float:
    """D [N s/m], eq. (9), at a speed c [m/s] within +-v*."""
    return d1 + 3.0 * d2 * c * c


@compiled
def force_slope(d1: float, d2: float, v: float, v_peak: float) -> float:
    """Derivative of the damper force by the speed [N s/m]; 0 beyond v*."""
    return damping(d1, d2, v) if abs(v) < v_peak else 0.0


@compiled
def damping_slope(d2: float, c: float) -> float:
    """Derivative of D by the speed [N s^2/m^2]."""
    return 6.0 * d2 * c


@compiled
def add_damper_derivatives(v: float, d1: float, d2: float, gradient: Array, hessian: Array) -> None:
    """First derivatives of the damper force into `gradient`, second into the upper triangle of `hessian`."""
    v_peak = peak_speed(d1, d2)
    c = clip_speed(v, v_peak)
    gradient[V] = force_slope(d1, d2, v, v_peak)
    gradient[D1] = c
    gradient[D2] = c * c * c
    if abs(v) < v_peak:
        hessian[V, V] = damping_slope(d2, v)
        hessian[V, D1] = 1.0
        hessian[V, D2] = 3.0 * v * v
    elif v_peak < UNBOUNDED_SPEED:
        side = 1.0 if v > 0.0 else -1.0
        hessian[D1, D1] = side * v_peak / (2.0 * d1)
        hessian[D1, D2] = side * v_peak / (-2.0 * d2)
        hessian[D2, D2] = side * 1.5 * v_peak**3 / (-d2)


@compiled
def linearize_near_peak(z: Array, speed_std: float, gradient: Array, hessian: Array) -> None:
    """Statistical linearisation of the damper force near v*, over a Gaussian speed of `speed_std` [m/s].

    The slope of the force has a step at v*: a Taylor expansion at one speed understates the error on the far side.
    A `speed_std` above MAX_RELATIVE_SPEED_STD v* leaves the derivatives unchanged: smoothed, they would fit any force.
    """
    v, d1, d2 = z[V], z[D1], z[D2]
    v_peak = peak_speed(d1, d2)
    beyond = (abs(v) - v_peak) / max(speed_std, 1e-12)
    if abs(beyond) > 4.0 or speed_std > MAX_RELATIVE_SPEED_STD * v_peak:
        return
    density = math.exp(-0.5 * beyond * beyond) / math.sqrt(2.0 * math.pi)
    below = 0.5 * math.erfc(beyond / math.sqrt(2.0))
    curvature = (1.0 + beyond * beyond) * below - beyond * density - min(beyond, 0.0) ** 2
    slope = density - beyond * below + min(beyond, 0.0)
    side = 1.0 if v > 0.0 else -1.0
    gradient[V] -= 6.0 * d2 * v_peak * speed_std * slope
    hessian[V, V] = 6.0 * d2 * side * v_peak * curvature
