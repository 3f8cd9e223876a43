# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The quantities that an excitation can make known, and since when they are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from vsa_joint.excitation.tuning import KNOWN_TIME

UNITS = {
    "stiffness": "N/m",
    "k2": "1/m",
    "damping": "N s/m",
    "d2": "N s^3/m^3",
    "inertia": "kg",
    "force_offset": "N",
    "coulomb_friction": "N",
}
DEFAULT = ("stiffness", "k2", "damping", "d2")
INTERVAL = 1.96  # standard deviations of half a 95 % interval
_FIELDS = {"damping": "d1"}  # of EstimatorState, where the name differs


class QuantityState(Protocol):
    """Fields that `estimate_of` reads of EstimatorState or of the estimator's own state, besides NAME, NAME_variance
    and NAME_valid of the quantities."""

    ln_stiffness_reference: float
    ln_stiffness_reference_variance: float
    elastic_law_valid: bool
    observability: Sequence[str]


@dataclass(frozen=True)
class QuantityEstimate:
    """Value and standard deviation of one quantity of one transmission; `known_after` [s] is None while not known."""

    transmission: int  # 1 or 2
    quantity: str
    value: float
    std: float
    valid: bool
    known_after: float | None = None
    reason: str = ""  # why it is not valid

    @property
    def relative_interval(self) -> float:
        """Half of the 95 % interval over the value."""
        return INTERVAL * self.std / abs(self.value) if self.value else math.inf


def estimate_of(quantity: str, transmission: int, state: QuantityState) -> QuantityEstimate:
    """Estimate of a quantity from the state of an estimator; the stiffness is that at `deflection_reference`."""
    reason = next((line.partition(": ")[2] for line in state.observability if line.startswith(f"{quantity}: ")), "")
    if quantity == "stiffness":
        value = math.exp(state.ln_stiffness_reference)
        std = value * math.sqrt(max(state.ln_stiffness_reference_variance, 0.0))
        return QuantityEstimate(transmission, quantity, value, std, bool(state.elastic_law_valid), reason=reason)
    name = _FIELDS.get(quantity, quantity)
    value, variance, valid = (getattr(state, f"{name}{suffix}") for suffix in ("", "_variance", "_valid"))
    return QuantityEstimate(transmission, quantity, value, math.sqrt(max(variance, 0.0)), bool(valid), reason=reason)


class KnownQuantities:
    """Wanted quantities of both transmissions: known once they are valid within the interval for KNOWN_TIME."""

    def __init__(self, quantities: Sequence[str], relative_interval: float) -> None:
        self._quantities, self._relative_interval = tuple(quantities), relative_interval
        self._since: dict[tuple[int, str], float] = {}
        self.estimates: tuple[QuantityEstimate, ...] = ()

    def update(self, states: Sequence[QuantityState], elapsed: float) -> None:
        """Take the states of both estimators at the time `elapsed` [s]."""
        found = ((name, number, state) for number, state in enumerate(states, 1) for name in self._quantities)
        self.estimates = tuple(self._with_time(estimate_of(*one), elapsed) for one in found)

    @property
    def all_known(self) -> bool:
        """Whether every wanted quantity is known."""
        return bool(self.estimates) and all(one.known_after is not None for one in self.estimates)

    @property
    def unknown(self) -> list[QuantityEstimate]:
        """Wanted quantities that are not known."""
        return [one for one in self.estimates if one.known_after is None]

    def _with_time(self, one: QuantityEstimate, elapsed: float) -> QuantityEstimate:
        key = one.transmission, one.quantity
        if not one.valid or (self._relative_interval and one.relative_interval > self._relative_interval):
            self._since.pop(key, None)
            return one
        since = self._since.setdefault(key, elapsed)
        known = since if elapsed - since >= KNOWN_TIME else None
        return QuantityEstimate(one.transmission, one.quantity, one.value, one.std, True, known)
