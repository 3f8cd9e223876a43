"""Cam that turns linear springs on a roller follower into an exponential spring: Fig. 1 and section II-B; SI units.

The rod is pulled by x, the follower's springs give by psi. Virtual work: F dx = n k_s psi dpsi. The roller's centre
travels along (x, psi - preload); the cam is cut one roller radius beside that path.
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
    curvature: np.ndarray  # of the roller's path, > 0 where the roller lies in a hollow [1/m]
    cut_x: np.ndarray  # the surface to cut, along the rod [m]
    cut_y: np.ndarray  # and across it, from the roller's first centre [m]
    unloading_force: np.ndarray  # of the rod on the way back; the law's where there is no friction [N]

    @property
    def lift(self) -> np.ndarray:
        """Travel of the roller across the rod [m]."""
        return self.compression - self.compression[0]

    @property
    def largest_roller(self) -> float:
        """Radius [m] below which a roller reaches every point of its path; infinite where no crest limits it."""
        return float(-1.0 / min(self.curvature.min(), -1e-12)) if self.curvature.min() < 0.0 else np.inf

    @property
    def tightest(self) -> float:
        """Deflection [m] where the path bends most over a crest."""
        return float(self.deflection[self.curvature.argmin()])


def cam_for(spring: ExponentialSpring, follower: Follower, max_deflection: float, points: int = 4001) -> Cam:
    """Cam whose rod force is the spring's law from 0 to `max_deflection` [m]."""
    x = np.linspace(0.0, max_deflection, points)
    rate = follower.springs * follower.spring_rate
    compression = _compression(spring, follower, x)
    slope = _slope(spring, follower, x, compression)
    angle = np.arctan(slope)
    bend = np.gradient(slope, x, edge_order=2)
    back = rate * compression * np.tan(angle - np.arctan(follower.friction))
    return Cam(
        deflection=x,
        compression=compression,
        slope=slope,
        curvature=bend * np.cos(angle) ** 3,
        cut_x=x + follower.roller_radius * np.sin(angle),
        cut_y=compression - follower.preload - follower.roller_radius * np.cos(angle),
        unloading_force=back,
    )


def _slope(spring: ExponentialSpring, follower: Follower, x: np.ndarray, compression: np.ndarray) -> np.ndarray:
    """tan(theta) of the path that gives the law while loading: F = n k_s psi tan(theta + phi), tan(phi) = friction."""
    ratio = spring.force(x) / (follower.springs * follower.spring_rate * compression)
    return (ratio - follower.friction) / (1.0 + ratio * follower.friction)


def _compression(spring: ExponentialSpring, follower: Follower, x: np.ndarray) -> np.ndarray:
    """psi(x) [m]: from the energy without friction, by Runge and Kutta's fourth order with it."""
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
    """Force of the rod while loading [N] when the roller rides on a cut surface: the check of a finished cam.

    The roller rests on whichever points of the surface hold it highest, so a surface that undercuts shows.
    """
    contacts = [_contact(cut_x, cut_y, follower.roller_radius, float(x)) for x in deflection]
    centre, slope = np.array(contacts).T
    at_rest, _ = _contact(cut_x, cut_y, follower.roller_radius, 0.0)
    ratio = (slope + follower.friction) / (1.0 - slope * follower.friction)
    return follower.springs * follower.spring_rate * (follower.preload + centre - at_rest) * ratio


def _contact(cut_x: np.ndarray, cut_y: np.ndarray, radius: float, x: float) -> tuple[float, float]:
    """Height of the roller's centre [m] and slope of its path [1] when it stands at `x` [m]."""
    if not radius:
        after = int(np.clip(np.searchsorted(cut_x, x), 1, len(cut_x) - 1))
        slope = (cut_y[after] - cut_y[after - 1]) / (cut_x[after] - cut_x[after - 1])
        return float(np.interp(x, cut_x, cut_y)), float(slope)
    near = np.abs(cut_x - x) < radius
    reach = cut_x[near] - x
    held = cut_y[near] + np.sqrt(radius**2 - reach**2)
    top = int(held.argmax())
    touch, centre = reach[top], held[top]
    if 0 < top < len(held) - 1:  # between the points: the crest of the parabola through the three highest
        a, b, _ = np.polyfit(reach[top - 1 : top + 2] - touch, held[top - 1 : top + 2] - centre, 2)
        if a < 0.0:
            touch, centre = touch - b / (2.0 * a), centre - b * b / (4.0 * a)
    return float(centre), float(touch / np.sqrt(radius**2 - touch**2))


def least_preload(spring: ExponentialSpring, follower: Follower, max_deflection: float) -> float:
    """Preload [m] from which on the roller reaches every point of its path; NaN where none up to 0.1 m does."""

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
