# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cam that turns linear springs on a roller follower into an exponential spring: Fig. 1 and section II-B; SI units.

The rod moves by x, the follower's springs compress by psi. Virtual work: F dx = n k_s psi dpsi. The roller's centre
moves along (x, psi - preload); the cam surface is offset from that path by one roller radius.
"""

from dataclasses import dataclass, replace

import numpy as np
from vsa_common.config.configuration import quantity
from vsa_tools.design.spring import ExponentialSpring


@dataclass(frozen=True)
class Follower:
    """The spring-loaded roller; n, k_s, r and the friction at its contact."""

    springs: int = quantity(1, "1", 1, 20, "linear springs on the follower")
    spring_rate: float = quantity(5000.0, "N/m", 1.0, 1e7, "rate of one of them")
    preload: float = quantity(0.0015, "m", 1e-6, 0.1, "their compression before the rod is pulled")
    roller_radius: float = quantity(0.003, "m", 0.0, 0.1, "0 cuts the path itself, as the paper's cam was")
    friction: float = quantity(0.0, "1", 0.0, 0.9, "coefficient at the contact; the law then holds while loading")


@dataclass(frozen=True)
class Cam:
    """The cam along the stroke; one array element a point."""

    deflection: np.ndarray  # of the rod, x [m]
    compression: np.ndarray  # of the follower's springs, psi [m]
    slope: np.ndarray  # of the roller's path, tan(theta) [1]
    curvature: np.ndarray  # of the roller's path, > 0 where it is concave [1/m]
    cut_x: np.ndarray  # cut surface, along the rod [m]
    cut_y: np.ndarray  # cut surface, across the rod, from the roller's first centre [m]
    unloading_force: np.ndarray  # of the rod while unloading; equal to the law without friction [N]

    @property
    def lift(self) -> np.ndarray:
        """Travel of the roller across the rod [m]."""
        return self.compression - self.compression[0]

    @property
    def largest_roller(self) -> float:
        """Radius [m] below which a roller has no undercut; infinite for a path without a convex section."""
        return np.inf if self.curvature.min() >= 0.0 else float(-1.0 / min(self.curvature.min(), -1e-12))

    @property
    def tightest(self) -> float:
        """Deflection [m] of the greatest convex curvature of the path."""
        return float(self.deflection[self.curvature.argmin()])


def cam_for(spring: ExponentialSpring, follower: Follower, max_deflection: float, points: int = 4001) -> Cam:
    """Cam whose rod force is the spring's law from 0 to `max_deflection` [m]."""
    x = np.linspace(0.0, max_deflection, points)
    rate = follower.springs * follower.spring_rate
    compression = _compression(spring, follower, x)
    slope = _slope(spring, follower, x, compression)
    angle = np.arctan(slope)
    slope_rate = np.gradient(slope, x, edge_order=2)
    unloading = rate * compression * np.tan(angle - np.arctan(follower.friction))
    return Cam(
        deflection=x,
        compression=compression,
        slope=slope,
        curvature=slope_rate * np.cos(angle) ** 3,
        cut_x=x + follower.roller_radius * np.sin(angle),
        cut_y=compression - follower.preload - follower.roller_radius * np.cos(angle),
        unloading_force=unloading,
    )


def _slope(spring: ExponentialSpring, follower: Follower, x: np.ndarray, compression: np.ndarray) -> np.ndarray:
    """tan(theta) of the path for the law while loading: F = n k_s psi tan(theta + phi), tan(phi) = friction."""
    ratio = spring.force(x) / (follower.springs * follower.spring_rate * compression)
    return (ratio - follower.friction) / (1.0 + ratio * follower.friction)


def _compression(spring: ExponentialSpring, follower: Follower, x: np.ndarray) -> np.ndarray:
    """psi(x) [m]: from the energy without friction, by fourth-order Runge-Kutta with friction."""
    if not follower.friction:
        stored = 2.0 * spring.work(x) / (follower.springs * follower.spring_rate)
        return np.sqrt(follower.preload**2 + stored)
    psi = np.empty_like(x)
    psi[0] = follower.preload
    for i, h in enumerate(np.diff(x)):
        a = _slope(spring, follower, x[i], psi[i])
        b = _slope(spring, follower, x[i] + h / 2.0, psi[i] + h / 2.0 * a)
        c = _slope(spring, follower, x[i] + h / 2.0, psi[i] + h / 2.0 * b)
        d = _slope(spring, follower, x[i] + h, psi[i] + h * c)
        psi[i + 1] = psi[i] + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return psi


def rolled_force(cut_x: np.ndarray, cut_y: np.ndarray, follower: Follower, deflection: np.ndarray) -> np.ndarray:
    """Force of the rod while loading [N] with the roller on a given cut surface: the verification of a cam.

    The roller contacts the surface at the point with the highest centre, which reveals an undercut.
    """
    contacts = [_contact(cut_x, cut_y, follower.roller_radius, float(x)) for x in deflection]
    centre, slope = np.array(contacts).T
    at_rest, _ = _contact(cut_x, cut_y, follower.roller_radius, 0.0)
    ratio = (slope + follower.friction) / (1.0 - slope * follower.friction)
    return follower.springs * follower.spring_rate * (follower.preload + centre - at_rest) * ratio


def _contact(cut_x: np.ndarray, cut_y: np.ndarray, radius: float, x: float) -> tuple[float, float]:
    """Height of the roller's centre [m] and slope of its path [1] at `x` [m]."""
    if not radius:
        after = int(np.clip(np.searchsorted(cut_x, x), 1, len(cut_x) - 1))
        slope = (cut_y[after] - cut_y[after - 1]) / (cut_x[after] - cut_x[after - 1])
        return float(np.interp(x, cut_x, cut_y)), float(slope)
    near = np.abs(cut_x - x) < radius
    reach = cut_x[near] - x
    height = cut_y[near] + np.sqrt(radius**2 - reach**2)
    top = int(height.argmax())
    touch, centre = reach[top], height[top]
    if 0 < top < len(height) - 1:  # between the points: vertex of the parabola through the three highest ones
        a, b, _ = np.polyfit(reach[top - 1 : top + 2] - touch, height[top - 1 : top + 2] - centre, 2)
        if a < 0.0:
            touch, centre = touch - b / (2.0 * a), centre - b * b / (4.0 * a)
    return float(centre), float(touch / np.sqrt(radius**2 - touch**2))


def least_preload(spring: ExponentialSpring, follower: Follower, max_deflection: float) -> float:
    """Least preload [m] without undercut and with a rising cam; NaN if none up to 0.1 m suffices."""

    def fits(preload: float) -> bool:
        cam = cam_for(spring, replace(follower, preload=preload), max_deflection, points=1001)
        return bool(cam.slope.min() > 0.0 and cam.largest_roller > follower.roller_radius)

    low, high = follower.preload, 0.1
    if not fits(high):
        return float("nan")
    while high - low > 1e-3 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high
