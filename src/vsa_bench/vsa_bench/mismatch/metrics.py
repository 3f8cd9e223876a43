# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of one run, and their aggregate over the seeds of a case."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from vsa_bench.estimation.score import SETTLED, TWO_SIDED_95, WRONG_SHARE, WRONG_STDS, time_to_accuracy
from vsa_common.types import Array, Booleans

SCORED_FROM = 0.3  # figures are taken over what follows this share of a recording
DAMPING_FLOOR = 0.2  # of d1: damping errors are relative to the damping, or to this share of d1 where that is greater
QUANTITIES = ("stiffness", "damping", "inertia")


@dataclass(frozen=True)
class Estimates:
    """One estimated quantity along a run, (samples,), SI."""

    value: Array
    variance: Array
    valid: Booleans


def quantity_figures(estimates: Estimates, true: Array, scale: Array, logarithmic: bool = False) -> dict[str, Any]:
    """Figures of a quantity over the samples given; shares and errors are fractions, errors are relative to `scale`.

    valid: share of the samples. error, half_width: median over the valid samples, of the interval's 95 % half-width.
    coverage: share of the valid samples whose 95 % interval contains the truth; `logarithmic`: the interval is
    value * exp(+-1.96 std / value), else value +-1.96 std. wrong: share of all samples that are valid and off by more
    than 4 standard deviations and 1 % of `scale`. None without a valid sample.
    """
    valid = estimates.valid
    error, std = np.abs(estimates.value - true), np.sqrt(estimates.variance)
    wrong = valid & (error > WRONG_STDS * std) & (error > WRONG_SHARE * scale)
    with np.errstate(all="ignore"):
        if logarithmic:
            covered = np.abs(np.log(estimates.value / true)) <= TWO_SIDED_95 * std / estimates.value
        else:
            covered = error <= TWO_SIDED_95 * std
    return {
        "valid": float(np.mean(valid)),
        "error": _median((error / scale)[valid]),
        "coverage": float(np.mean(covered[valid])) if valid.any() else None,
        "wrong": float(np.mean(wrong)),
        "half_width": _median((TWO_SIDED_95 * std / scale)[valid]),
    }


def settling(stiffness: Array, true: Array, time: Array) -> dict[str, Any]:
    """Time from which on the stiffness stays within 5 % [s], as `bench estimation` defines it, None if never.

    A run has converged if that time is within the first 70 % of the recording.
    """
    with np.errstate(all="ignore"):
        ln_error = np.log(np.maximum(stiffness, 1e-9) / true)
    seconds = float(time_to_accuracy(ln_error[None], time)[0])
    converged = bool(np.isfinite(seconds) and seconds < SETTLED * time[-1])
    return {"time_to_5pct_s": seconds if np.isfinite(seconds) else None, "converged": converged}


def peer_error(stiffness: Array, true: Array) -> float | None:
    """Median relative error of a stiffness without validity; None where it is not finite."""
    return _median(np.abs(stiffness / true - 1.0))


def aggregate(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Median of each figure over the runs that define it, share of the runs that have converged.

    A run that never settles counts as infinite in the median of the times.
    """
    result: dict[str, Any] = {
        name: {key: _median_of([run[name][key] for run in runs]) for key in runs[0][name]}
        for name in (*QUANTITIES, "peers")
    }
    times = [np.inf if run["time_to_5pct_s"] is None else run["time_to_5pct_s"] for run in runs]
    result["time_to_5pct_s"] = _median(np.array(times))
    result["converged"] = float(np.mean([run["converged"] for run in runs]))
    result["dropped"] = _median_of([run["dropped"] for run in runs])
    return result


def _median_of(values: Sequence[float | None]) -> float | None:
    return _median(np.array([one for one in values if one is not None], float))


def _median(values: Array) -> float | None:
    median = float(np.median(values)) if len(values) else np.nan
    return median if np.isfinite(median) else None
