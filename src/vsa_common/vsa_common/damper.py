# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cubic damper, eq. (5): F = d1 v + d2 v^3 with d1 > 0 > d2, up to its peak speed v*."""

import math


def peak_speed(d1: float, d2: float) -> float:
    """Speed v* [m/s] of the greatest damper force, where D = d1 + 3 d2 v^2 vanishes; infinite where there is none.

    d1 [N s/m], d2 [N s^3/m^3].

    >>> round(peak_speed(4000.0, -1.089e8), 6)
    0.003499
    >>> peak_speed(4000.0, 0.0)
    inf
    """
    return math.sqrt(d1 / (-3.0 * d2)) if d1 > 0.0 > d2 else math.inf
