"""The antagonistic joint integrated with Runge-Kutta, for tests: the paper's two transmissions, SI.

Shares no line with the simulated rig. Motors stand still or follow given travel; the tendon force of one instant
acts on rods and joint alike.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

RADIUS, JOINT_DAMPING, JOINT_INERTIA = 0.0215, 0.01, 1e-3


@dataclass(frozen=True)
class Law:
    """Coefficients of one transmission."""

    k2: float
    k1: float
    force_offset: float
    d1: float
    d2: float
    inertia: float
    coulomb: float

    def deflection(self, force: float) -> float:
        return math.log((force - self.force_offset) / self.k1) / self.k2

    def stiffness(self, force: float) -> float:
        return self.k2 * (force - self.force_offset)


@dataclass(frozen=True)
class Rig:
    """Both laws and the tendon stiffness [N/m]."""

    tendon: float = 1e5
    friction: bool = True
    laws: tuple[Law, Law] = field(
        default=(
            Law(267.2, 0.776, 16.39, 4000.0, -0.1089e9, 0.3755, 0.3),
            Law(165.6, 7.031, 8.269, 4000.0, -0.1170e9, 0.2295, 0.5),
        )
    )

    def travel(self, force: float) -> np.ndarray:
        """Motor travel that holds both rods at `force` [N] and the joint at zero."""
        return np.array([2 * law.deflection(force) + force / (2 * self.tendon) for law in self.laws])

    def run(self, force: float, torque: np.ndarray, rate: float = 1000.0) -> dict[str, np.ndarray]:
        """Joint and rods from rest at `force` under external torque; one row a sample of `torque`."""
        c = 1.0 if self.friction else 0.0
        p = np.array(
            [[w.k2, w.k1, w.force_offset, w.d1, w.d2, w.inertia, c * w.coulomb] for w in self.laws]
        )
        start = np.array([0.0, 0.0, self.laws[0].deflection(force), 0.0, self.laws[1].deflection(force), 0.0])
        substeps = max(1, math.ceil(2e4 / rate))
        states = _integrate(start, torque, self.travel(force), p, self.tendon, 1.0 / rate, substeps)
        tension = [self.tendon * (self.travel(force)[i] - s * RADIUS * states[:, 0] - 2 * states[:, 2 + 2 * i])
                   for i, s in ((0, 1.0), (1, -1.0))]
        return {
            "angle": states[:, 0],
            "torque": torque,
            "deflection": states[:, [2, 4]],
            "velocity": states[:, [3, 5]],
            "force": 2.0 * np.array(tension).T,
        }


@njit(cache=True)
def _rod(x, v, tension, p):
    k2, k1, f0, d1, d2, m, d0 = p
    w = math.sqrt(d1 / (3.0 * abs(d2)))
    c = min(max(v, -w), w)
    return (2.0 * tension - f0 - k1 * math.exp(k2 * x) - d1 * c - d2 * c**3 - d0 * math.tanh(v / 1.5e-4)) / m


@njit(cache=True)
def _rate(y, torque, q, p, kt):
    t1 = kt * (q[0] - RADIUS * y[0] - 2.0 * y[2])
    t2 = kt * (q[1] + RADIUS * y[0] - 2.0 * y[4])
    out = np.empty(6)
    out[0] = y[1]
    out[1] = (RADIUS * (t1 - t2) + torque - JOINT_DAMPING * y[1]) / JOINT_INERTIA
    out[2] = y[3]
    out[3] = _rod(y[2], y[3], t1, p[0])
    out[4] = y[5]
    out[5] = _rod(y[4], y[5], t2, p[1])
    return out


@njit(cache=True)
def _integrate(y, torque, q, p, kt, dt, substeps):
    out = np.empty((len(torque), 6))
    h = dt / substeps
    for k in range(len(torque)):
        out[k] = y
        end = torque[k + 1] if k + 1 < len(torque) else torque[k]
        for i in range(substeps):
            a = torque[k] + (end - torque[k]) * i / substeps
            b = torque[k] + (end - torque[k]) * (i + 1) / substeps
            k1 = _rate(y, a, q, p, kt)
            k2 = _rate(y + 0.5 * h * k1, 0.5 * (a + b), q, p, kt)
            k3 = _rate(y + 0.5 * h * k2, 0.5 * (a + b), q, p, kt)
            k4 = _rate(y + h * k3, b, q, p, kt)
            y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return out
