# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Half and double of each tuned constant, within its permitted range."""

import importlib
import math
import pkgutil
from dataclasses import dataclass

from vsa_common.tuning import CONSTANTS, Constant

HALF, DOUBLE = FACTORS = (0.5, 2.0)
Value = int | float | tuple[float, ...]


@dataclass(frozen=True)
class Variation:
    """One constant at another value; `clipped` where its range does not permit the whole factor."""

    module: str
    name: str
    factor: float
    value: Value
    clipped: bool

    @property
    def overrides(self) -> dict[tuple[str, str], Value]:
        """The entry of `vsa_common.tuning.OVERRIDES`."""
        return {(self.module, self.name): self.value}


def declared(package: str) -> dict[str, dict[str, Constant]]:
    """Tuned constants of `package`.tuning and its submodules, by module and name; empty where there is none."""
    root = f"{package}.tuning"
    try:
        tuning = importlib.import_module(root)
    except ModuleNotFoundError as error:
        if error.name != root:
            raise
        return {}
    for module in pkgutil.walk_packages(getattr(tuning, "__path__", []), f"{root}."):
        importlib.import_module(module.name)
    return {name: dict(CONSTANTS[name]) for name in sorted(CONSTANTS) if f"{name}.".startswith(f"{package}.")}


def vary(module: str, constant: Constant, factor: float) -> Variation | None:
    """`constant` times `factor`, within its range; None where that leaves its value.

    A tuple is scaled as a whole. An integer is rounded and stays at least 1.

    >>> vary("filter", Constant("GATE", 5, "", 1.0, 8.0, "", ""), 2.0)
    Variation(module='filter', name='GATE', factor=2.0, value=8, clipped=True)
    """
    values = constant.value if isinstance(constant.value, tuple) else (constant.value,)
    permitted = _permitted(values, constant.low, constant.high, factor)
    scaled = tuple(_scaled(one, permitted, constant.low, constant.high) for one in values)
    if scaled == values:
        return None
    value = scaled if isinstance(constant.value, tuple) else scaled[0]
    return Variation(module, constant.name, factor, value, permitted != factor)


def _permitted(values: tuple[float, ...], low: float, high: float, factor: float) -> float:
    """The part of `factor` with which all values stay within `low` and `high`."""
    for value in values:
        if value:
            bounds = sorted((low / value, high / value))
            factor = min(max(factor, bounds[0]), bounds[1])
    return factor


def _scaled(value: float, factor: float, low: float, high: float) -> float:
    if isinstance(value, int):
        rounded = math.floor(factor * value + 0.5)
        rounded = max(rounded, 1) if value > 0 else rounded
        return min(max(rounded, math.ceil(low)), math.floor(high))
    return min(max(factor * value, low), high)
