# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Functions of one variable as tables with cubic Hermite interpolation, for laws that are plain Python functions.

A curve is a flat array: origin and step of the grid, then value and slope at each node. The slope that a curve gives is
the exact derivative of its value. Beyond its ends a curve is a straight line. NO_CURVE is a tuple and not an array:
compiled code is then specialised without arrays, whose reference counting would double the time of a step.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array

INTERVALS = 2200
_STEP = 1e-30  # of the complex step: exact derivatives of analytic functions

Curve = Array | tuple[float, ...]
Complex = NDArray[Any]  # of complex numbers
Function = Callable[[Complex], Complex]

NO_CURVE = (0.0, 1.0, 0.0, 1.0)


def curve_of(function: Function, start: float, end: float) -> Array:
    """Curve of an analytic `function` from `start` to `end`; its slopes by the complex step."""
    grid = np.linspace(start, end, INTERVALS + 1)
    values = function(grid + 1j * _STEP)
    nodes = np.column_stack([values.real, values.imag / _STEP])
    return np.concatenate([[start, (end - start) / INTERVALS], nodes.ravel()])


def greatest_slope(curve: Array) -> float:
    """Greatest slope among the nodes."""
    return float(curve[3::2].max())


@compiled
def value_at(x: float, curve: Curve) -> float:
    """Value of the curve at `x`."""
    origin, step, last = curve[0], curve[1], len(curve) // 2 - 2
    place = (x - origin) / step
    if place <= 0.0:
        return curve[2] + curve[3] * (x - origin)
    if place >= last:
        return curve[2 + 2 * last] + curve[3 + 2 * last] * (x - origin - last * step)
    i = 2 + 2 * int(place)
    t = place - int(place)
    rise, begin, end = curve[i + 2] - curve[i], step * curve[i + 1], step * curve[i + 3]
    return curve[i] + t * (begin + t * (3.0 * rise - 2.0 * begin - end + t * (begin + end - 2.0 * rise)))


@compiled
def slope_at(x: float, curve: Curve) -> float:
    """Derivative of the curve at `x`."""
    origin, step, last = curve[0], curve[1], len(curve) // 2 - 2
    place = (x - origin) / step
    if place <= 0.0:
        return curve[3]
    if place >= last:
        return curve[3 + 2 * last]
    i = 2 + 2 * int(place)
    t = place - int(place)
    rise, begin, end = curve[i + 2] - curve[i], step * curve[i + 1], step * curve[i + 3]
    return (begin + t * (2.0 * (3.0 * rise - 2.0 * begin - end) + 3.0 * t * (begin + end - 2.0 * rise))) / step


@compiled
def argument_at(value: float, curve: Curve) -> float:
    """Argument at which a strictly increasing curve has `value`: bisection to an interval, then Newton's method."""
    origin, step, last = curve[0], curve[1], len(curve) // 2 - 2
    if value <= curve[2]:
        return origin + (value - curve[2]) / curve[3]
    if value >= curve[2 + 2 * last]:
        return origin + last * step + (value - curve[2 + 2 * last]) / curve[3 + 2 * last]
    below, above = 0, last
    while above - below > 1:
        middle = (below + above) // 2
        if curve[2 + 2 * middle] <= value:
            below = middle
        else:
            above = middle
    low = origin + below * step
    x = low + step * (value - curve[2 + 2 * below]) / (curve[2 + 2 * above] - curve[2 + 2 * below])
    for _ in range(4):  # two suffice: the curve is nearly straight within an interval
        x -= (value_at(x, curve) - value) / slope_at(x, curve)
        x = min(max(x, low), low + step)
    return x
