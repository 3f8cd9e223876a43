"""What holds in the middle of the motion and at rest: the rig's truth and the live estimates reduced alike."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_joint.impedance.fusion import JointEstimate
from vsa_joint.impedance.reflection import Impedance, Sides
from vsa_simulator.rig.dynamics import TRUTH

NEAR = 0.5  # standard deviations from the middle that still count as there
NAMES = ("stiffness", "damping", "inertia")


def rods_of(row: Array) -> Sides:
    """Both rods in a row of the truth."""
    first, second = (Impedance(*(float(row[TRUTH.index(f"{name}_{side}")]) for name in NAMES)) for side in (1, 2))
    return first, second


class Place:
    """Where the rods are and how fast they move in rows of the truth.

    The coordinate is the difference of both deflections: behind the tendons, as the experiment sees the joint.
    A joint without friction hardly moves; there the mean is what a small response sees.
    """

    def __init__(self, truth: Array, frictionless: bool) -> None:
        place, rate = (
            _centred(truth[:, TRUTH.index(f"{name}_2")] - truth[:, TRUTH.index(f"{name}_1")])
            for name in ("deflection", "velocity")
        )
        powers = [(0, 0)] if frictionless else [(i, j) for i in range(4) for j in range(4 - i)]
        self._by = np.stack([place**i * rate**j for i, j in powers], axis=1)
        self._near = np.abs(place) < NEAR

    def at_rest(self, impedances: Sequence[Impedance | JointEstimate]) -> Impedance:
        """Value in the middle and at rest."""
        values = []
        for name in NAMES:
            series, chosen = _series(impedances, name), _valid(impedances, name)
            values.append(float(np.linalg.lstsq(self._by[chosen], series[chosen], rcond=None)[0][0]))
        return Impedance(*values)

    def std(self, estimates: Sequence[JointEstimate]) -> Impedance:
        """Standard deviation that the estimates typically say they have near the middle."""
        stds = []
        for name in NAMES:
            chosen = _valid(estimates, name)
            chosen = chosen & self._near if (chosen & self._near).any() else chosen
            stds.append(float(np.sqrt(np.median(_series(estimates, f"{name}_variance")[chosen]))))
        return Impedance(*stds)


def _series(of: Sequence[Impedance | JointEstimate], name: str) -> Array:
    return np.array([getattr(one, name) for one in of])


def _valid(of: Sequence[Impedance | JointEstimate], name: str) -> NDArray[np.bool_]:
    """Rows that are valid; all where none is, and of the inertia, which so slow a motion never shows."""
    valid = np.array([getattr(one, f"{name}_valid", True) for one in of], dtype=bool)
    return valid if valid.any() and name != "inertia" else np.ones_like(valid)


def _centred(signal: Array) -> Array:
    return np.asarray((signal - signal.mean()) / np.std(signal))
