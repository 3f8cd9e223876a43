# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Start values of a run: as identified on the rig, or as taken from its data sheet."""

import math
from dataclasses import dataclass

import numpy as np
from vsa_bench.estimation.cases import Case, Coefficients

BAD_FORCE_OFFSET_SHARE = 0.5  # standard deviation of a bad force offset, as a share of the first force


@dataclass(frozen=True)
class Start:
    """Start value and standard deviation of each coefficient, named as the estimator's `initial` parameters, SI."""

    value: dict[str, float]
    std: dict[str, float]

    def parameters(self) -> dict[str, float]:
        """The estimator's parameters initial.X and initial.X_std."""
        stds = {f"initial.{name}_std": std for name, std in self.std.items()}
        return {f"initial.{name}": value for name, value in self.value.items()} | stds


def draw(case: Case, first_deflection: float, seed: int) -> Start:
    """Start values of one run.

    good: with the errors of `identify`. bad: k2 30 % and stiffness by a factor 2 too high or too low, d1 x 0.6 or 1.6,
    d2 halved, inertia doubled, friction as in the data sheet.
    """
    random = np.random.default_rng([seed, 1])
    c = case.coefficients
    if case.start == "good":
        std = {"k2": 0.03 * c.k2, "d1": 0.2 * c.d1, "d2": -0.3 * c.d2, "inertia": 0.3 * c.inertia}
        std |= {"force_offset": 0.42, "coulomb_friction": 0.1}
        true = {"k2": c.k2, "d1": c.d1, "d2": c.d2, "inertia": c.inertia}
        true |= {"force_offset": c.force_offset, "coulomb_friction": c.coulomb_friction}
        value = {name: true[name] + std[name] * random.standard_normal() for name in true}
        value["d2"] = min(value["d2"], -1e5)
        return Start(
            {n: max(v, 0.1 * true[n]) if n in ("d1", "inertia") else v for n, v in _positive(value).items()}, std
        )
    elastic = c.k1 * math.exp(c.k2 * first_deflection)
    return wrong_start(c, elastic * c.k2, c.force_offset + elastic, random)


def wrong_start(c: Coefficients, stiffness: float, force: float, random: np.random.Generator) -> Start:
    """A bad start for any elastic law, about the stiffness [N/m] and static force [N] at the first sample.

    The stiffness is a factor 2 too high or too low, k2 30 % off that of `c`, the other coefficients are off theirs.
    """
    high = random.random() < 0.5
    k2 = c.k2 * (1.3 if high else 0.7)
    start_elastic = stiffness * (2.0 if high else 0.5) / k2
    value = {
        "k2": k2,
        "d1": c.d1 * (0.6 if random.random() < 0.5 else 1.6),
        "d2": 0.5 * c.d2,
        "inertia": 2.0 * c.inertia,
    }
    value |= {"force_offset": force - start_elastic, "coulomb_friction": 0.3}
    std = {"k2": 0.3 * k2, "d1": 0.6 * value["d1"], "d2": -value["d2"], "inertia": value["inertia"]}
    std |= {"force_offset": BAD_FORCE_OFFSET_SHARE * force, "coulomb_friction": 0.3}
    return Start(value, std)


def _positive(value: dict[str, float]) -> dict[str, float]:
    return value | {"coulomb_friction": abs(value["coulomb_friction"])}
