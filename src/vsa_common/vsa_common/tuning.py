# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Registry of tuned constants: each with unit, range, reason and evidence."""

from typing import NamedTuple, TypeVar, cast

Value = TypeVar("Value", int, float, "tuple[float, ...]")


class Constant(NamedTuple):
    """A tuned constant; `evidence` is a derivation, a source, or `ablation` for a row of `./vsa bench ablation`."""

    name: str
    value: int | float | tuple[float, ...]
    unit: str
    low: float
    high: float
    reason: str
    evidence: str


CONSTANTS: dict[str, dict[str, Constant]] = {}  # by module of declaration, by name
OVERRIDES: dict[tuple[str, str], int | float | tuple[float, ...]] = {}  # by module and name, for `bench ablation`


def constant(
    name: str, value: Value, unit: str, low: float, high: float, reason: str, evidence: str, *, module: str
) -> Value:
    """Declare a tuned constant of `module`; its value. Raises ValueError out of range or declared twice.

    An entry of OVERRIDES, of the same type, takes the place of `value`.
    """
    value = cast(Value, OVERRIDES.get((module, name), value))
    values = value if isinstance(value, tuple) else (value,)
    if not all(low <= one <= high for one in values):
        raise ValueError(f"{module}.{name} = {value!r} {unit}: must be within {low:g} to {high:g}")
    declared = CONSTANTS.setdefault(module, {})
    if name in declared:
        raise ValueError(f"{module}.{name} is declared twice")
    declared[name] = Constant(name, value, unit, low, high, reason, evidence)
    return value
