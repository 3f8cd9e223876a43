# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Required figures over all cases of a run, each with the figure reached and the worst case."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from vsa_bench.mismatch.cases import DRAWN_GROUP, SENSOR_GROUP, SPRING_GROUP

MAX_WRONG = 0.005  # share of the samples
MIN_COVERAGE, MEAN_COVERAGE = 0.90, (0.93, 0.99)
MAX_ERROR, MIN_VALID = 0.003, 0.90  # stiffness of springs
MAX_HALF_WIDTH = {SPRING_GROUP: 0.01, SENSOR_GROUP: 0.025}  # of stiffness
MAX_SETTLING = 8.0  # [s], mean

Case = dict[str, Any]  # one entry of the JSON


class Bar(NamedTuple):
    """One required figure; `missed`: cases of `cases` that miss it, None for a mean over all."""

    quantity: str
    limit: str
    figure: str
    worst: str
    missed: int | None
    cases: int
    reached: bool


def bars(cases: Sequence[Case]) -> list[Bar]:
    """All required figures that `cases` define."""
    springs = [one for one in cases if one["group"] == SPRING_GROUP]
    result: list[Bar | None] = []
    for name in ("stiffness", "damping"):
        wrong, coverage = _of(name, "wrong"), _of(name, "coverage")
        result += [
            _every(f"{name}: valid and wrong", cases, wrong, _at_most(MAX_WRONG)),
            _every(f"{name}: coverage", cases, coverage, _at_least(MIN_COVERAGE)),
            _mean(f"{name}: mean coverage", cases, coverage, MEAN_COVERAGE, "{:.3f}"),
        ]
    result += [
        _every("springs: stiffness error", springs, _of("stiffness", "error"), _at_most(MAX_ERROR)),
        _every("springs: stiffness valid", springs, _of("stiffness", "valid"), _at_least(MIN_VALID)),
        _every("springs: error over the best peer's", springs, error_over_best_peer, _Limit(1.0, False, "{:.2f}")),
    ]
    for group, limit in MAX_HALF_WIDTH.items():
        members = [one for one in cases if one["group"] == group]
        result.append(_every(f"{group}: half-width", members, _of("stiffness", "half_width"), _at_most(limit)))
    result += [
        _every("converged", cases, lambda one: one["median"]["converged"], _at_least(1.0)),
        _mean("seconds to 5 %", cases, mean_settling, (0.0, MAX_SETTLING), "{:.1f}"),
    ]
    return [one for one in result if one]


def best_peer(case: Case) -> tuple[str, float] | None:
    """Name and median stiffness error of the best peer."""
    errors = {name: error for name, error in case["median"]["peers"].items() if error is not None}
    name = min(errors, key=lambda one: errors[one], default=None)
    return None if name is None else (name, errors[name])


def error_over_best_peer(case: Case) -> float | None:
    """Median stiffness error of the estimator over that of the best peer."""
    peer, own = best_peer(case), case["median"]["stiffness"]["error"]
    return None if peer is None or own is None else own / peer[1]


def mean_settling(case: Case) -> float | None:
    """Mean time to 5 % of the runs that settle [s]."""
    times = [run["time_to_5pct_s"] for run in case["runs"] if run["time_to_5pct_s"] is not None]
    return float(np.mean(times)) if times else None


class _Limit(NamedTuple):
    value: float
    lower: bool  # else an upper limit
    format: str

    def permits(self, figure: float) -> bool:
        return figure >= self.value if self.lower else figure <= self.value

    def __str__(self) -> str:
        return (">= " if self.lower else "<= ") + self.format.format(self.value)


def _at_most(share: float) -> _Limit:
    return _Limit(share, False, "{:.2%}")


def _at_least(share: float) -> _Limit:
    return _Limit(share, True, "{:.1%}")


def _of(name: str, key: str) -> Callable[[Case], float | None]:
    def figure(case: Case) -> float | None:
        value: float | None = case["median"][name][key]
        return value

    return figure


def _defined(cases: Sequence[Case], figure: Callable[[Case], float | None]) -> list[tuple[float, Case]]:
    return [(value, one) for one in cases if (value := figure(one)) is not None]


def _every(quantity: str, cases: Sequence[Case], figure: Callable[[Case], float | None], limit: _Limit) -> Bar | None:
    """The bar of a figure in every case: the worst of them."""
    found = _defined(cases, figure)
    if not found:
        return None
    value, worst = (min if limit.lower else max)(found, key=lambda one: one[0])
    missed = sum(not limit.permits(one) for one, _ in found)
    return Bar(quantity, str(limit), limit.format.format(value), _label(worst), missed, len(found), not missed)


def _mean(
    quantity: str,
    cases: Sequence[Case],
    figure: Callable[[Case], float | None],
    band: tuple[float, float],
    form: str,
) -> Bar | None:
    """The bar of a mean over the cases."""
    found = [value for value, _ in _defined(cases, figure)]
    if not found:
        return None
    mean, limit = float(np.mean(found)), " to ".join(form.format(one) for one in band)
    return Bar(quantity, limit, form.format(mean), "", None, len(found), band[0] <= mean <= band[1])


def _label(case: Case) -> str:
    motion = "" if case["group"] == DRAWN_GROUP else f"{case['motion']} "
    return f"{case['case']} {motion}{case['rate_hz']} Hz"
