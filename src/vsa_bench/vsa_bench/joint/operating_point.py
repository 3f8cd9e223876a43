# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Reduction of truth and estimates to the operating point: the mean deflection at rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_joint.impedance.fusion import JointEstimate
from vsa_joint.impedance.reflection import Impedance, Transmissions
from vsa_simulator.rig.dynamics import TRUTH

NEAR = 0.5  # standard deviations from the mean deflection
NAMES = ("stiffness", "damping", "inertia")


def transmissions_of(row: Array) -> Transmissions:
    """Impedance of both transmissions in a row of the truth (columns as in TRUTH)."""
    first, second = (Impedance(*(float(row[TRUTH.index(f"{name}_{number}")]) for name in NAMES)) for number in (1, 2))
    return first, second


class OperatingPoint:
    """Regression of a quantity on position and rate in rows of the truth, evaluated at the mean position at rest.

    The position is the difference of both deflections, on the tendon side as in the experiment. Without friction the
    amplitude is small, and the mean applies.
    """

    def __init__(self, truth: Array, frictionless: bool) -> None:
        position, rate = (
            _standardized(truth[:, TRUTH.index(f"{name}_2")] - truth[:, TRUTH.index(f"{name}_1")])
            for name in ("deflection", "velocity")
        )
        powers = [(0, 0)] if frictionless else [(i, j) for i in range(4) for j in range(4 - i)]
        self._regressors = np.stack([position**i * rate**j for i, j in powers], axis=1)
        self._near = np.abs(position) < NEAR

    def at_rest(self, impedances: Sequence[Impedance | JointEstimate]) -> Impedance:
        """Value at the operating point."""
        values = []
        for name in NAMES:
            series, chosen = _series(impedances, name), _valid(impedances, name)
            values.append(float(np.linalg.lstsq(self._regressors[chosen], series[chosen], rcond=None)[0][0]))
        return Impedance(*values)

    def std(self, estimates: Sequence[JointEstimate]) -> Impedance:
        """Median standard deviation of the estimates near the mean position."""
        stds = []
        for name in NAMES:
            chosen = _valid(estimates, name)
            chosen = chosen & self._near if (chosen & self._near).any() else chosen
            stds.append(float(np.sqrt(np.median(_series(estimates, f"{name}_variance")[chosen]))))
        return Impedance(*stds)


def _series(impedances: Sequence[Impedance | JointEstimate], name: str) -> Array:
    return np.array([getattr(impedance, name) for impedance in impedances])


def _valid(impedances: Sequence[Impedance | JointEstimate], name: str) -> NDArray[np.bool_]:
    """Mask of the valid rows; all rows where none is valid, and for the inertia, which slow motion does not excite."""
    valid = np.array([getattr(one, f"{name}_valid", True) for one in impedances], dtype=bool)
    return valid if valid.any() and name != "inertia" else np.ones_like(valid)


def _standardized(signal: Array) -> Array:
    return np.asarray((signal - signal.mean()) / np.std(signal))
