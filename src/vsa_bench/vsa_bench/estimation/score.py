# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Scores of a track: the columns of the bench."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri  # scipy.stats takes a second to import
from vsa_bench.estimation.bound import Bound
from vsa_bench.estimation.recordings import Recording
from vsa_bench.estimation.track import Track
from vsa_common.types import Array

Mask = NDArray[np.bool_]

SETTLED = 0.7  # errors are scored over what follows this share of a recording
CONVERGED = 0.05  # relative error of stiffness
CONSISTENT_FROM = 1.0  # [s]; from here on the interval of the stiffness is scored
TWO_SIDED_95 = 1.959964
WRONG_STDS, WRONG_SHARE = 4.0, 0.01  # confidently wrong: valid, and beyond both


def score(track: Track, recording: Recording, bound: Bound | None) -> dict[str, Any]:
    """All columns of one method on one case; None for a quantity that the method does not estimate.

    Errors are fractions: stiffness and damping are the median over the seeds of each run's error, root mean square over
    the settled part and relative to the quantity's own; k2 and d2 are the root mean square over the seeds at the end.
    """
    truth = recording.truth
    settled = np.arange(len(truth.time)) >= SETTLED * len(truth.time)
    later = truth.time >= CONSISTENT_FROM
    with np.errstate(all="ignore"):
        ln_error = np.log(np.maximum(track.stiffness, 1e-9) / truth.stiffness)
        gives_variance = track.stiffness_variance.shape[1] > 1
        ln_variance = track.stiffness_variance / track.stiffness**2 if gives_variance else track.stiffness_variance
        times = time_to_accuracy(ln_error, truth.time)
        result = {
            "converged": float(np.mean(np.isfinite(times) & (times < SETTLED * truth.time[-1]))),
            "time_to_5pct_s": _number(np.median(times)),
            "stiffness_nrmse": _number(np.median(nrmse(track.stiffness, truth.stiffness, settled))),
            "damping_nrmse": _median(_damping_nrmse(track, recording, settled)),
            "k2_error": _rms(track.k2[:, -1] / truth.coefficients.k2 - 1.0),
            "d2_error": _rms(track.d2[:, -1] / truth.coefficients.d2 - 1.0),
            "coverage": {
                "stiffness": _coverage(ln_error, ln_variance, settled),
                "damping": _coverage(
                    track.damping - truth.damping, track.damping_variance, settled, track.damping_valid
                ),
                "k2": _coverage(track.k2 - truth.coefficients.k2, track.k2_variance, settled),
                "stiffness_from_1s": _coverage(ln_error, ln_variance, later),
            },
            "nees": _mean(track.nees[:, int(SETTLED * track.nees.shape[1]) :]),
            "nees_band": [float(chdtri(3 * len(track.nees), p) / len(track.nees)) for p in (0.975, 0.025)],
            "us_per_step": _number(1e6 * track.seconds / track.stiffness.size),
            "stiffness_worst": _worst(ln_error, times, truth.time),
            "valid_share": {name: _valid_share(track, name, settled) for name in ("stiffness", "damping", "inertia")},
            "confidently_wrong": confidently_wrong(track, recording),
        }
        ratios = _ratios(track, recording, bound, settled) if bound else {}
    values = [ratio for ratio in ratios.values() if ratio is not None]
    return result | {"ratio_to_bound": max(values) if values else None, "ratios_to_bound": ratios}


def time_to_accuracy(ln_error: Array, time: Array) -> Array:
    """From when on each run's stiffness stays within 5 % [s]; infinite where it does not."""
    outside = ~(np.abs(ln_error) < np.log1p(CONVERGED))
    last = outside.shape[1] - 1 - np.argmax(outside[:, ::-1], axis=1)
    after = np.append(time, np.inf)[last + 1]
    return np.where(outside.any(axis=1), after, 0.0)


def nrmse(estimate: Array, true: Array, part: Mask) -> Array:
    """Root mean square error of each run over `part`, relative to the true quantity's root mean square."""
    if estimate.shape[1] == 1:
        return np.full(len(estimate), np.nan)
    return np.asarray(np.sqrt(np.mean((estimate[:, part] - true[part]) ** 2, axis=1) / np.mean(true[part] ** 2)))


def confidently_wrong(track: Track, recording: Recording) -> dict[str, float | None]:
    """Share of all samples that are valid and off by more than 4 standard deviations and 1 %."""
    truth = recording.truth
    inertia = np.full_like(truth.time, truth.coefficients.inertia)
    result: dict[str, float | None] = {}
    for name, true in (("stiffness", truth.stiffness), ("damping", truth.damping), ("inertia", inertia)):
        if _width(track, name) == 1:
            result[name] = None
            continue
        error = np.abs(getattr(track, name) - true)
        wrong = error > WRONG_STDS * np.sqrt(getattr(track, f"{name}_variance"))
        wrong &= error > WRONG_SHARE * np.maximum(np.abs(true), WRONG_SHARE * np.abs(true).max())
        result[name] = float(np.mean(wrong & (getattr(track, f"{name}_valid") > 0)))
    return result


def _valid_share(track: Track, name: str, settled: Mask) -> float | None:
    return None if _width(track, name) == 1 else float(np.mean(getattr(track, f"{name}_valid")[:, settled]))


def _width(track: Track, name: str) -> int:
    return int(getattr(track, f"{name}_valid").shape[1])


def _damping_nrmse(track: Track, recording: Recording, settled: Mask) -> Array:
    """As nrmse, where damping is valid (a method without validity: below the damper's maximum speed)."""
    truth = recording.truth
    if track.damping.shape[1] == 1:
        return np.array([np.nan])
    valid = track.damping_valid if track.damping_valid.shape[1] > 1 else np.ones_like(track.damping)
    use = settled & (valid > 0) & (np.abs(truth.velocity) < truth.coefficients.maximum_speed)
    squares = np.where(use, (track.damping - truth.damping) ** 2, 0.0).sum(axis=1)
    true_squares = np.where(use, truth.damping**2, 0.0).sum(axis=1)
    return np.sqrt(np.divide(squares, true_squares, out=np.full(len(true_squares), np.nan), where=true_squares > 0.0))


def _coverage(error: Array, variance: Array, part: Mask, valid: Array | None = None) -> float | None:
    """Share of samples whose 95 % interval contains the truth."""
    if variance.shape[1] == 1:
        return None
    covered = (np.abs(error) <= TWO_SIDED_95 * np.sqrt(variance))[:, part]
    use = np.ones_like(covered) if valid is None else valid[:, part] > 0
    return float(np.mean(covered[use])) if use.any() else None


def _worst(ln_error: Array, times: Array, time: Array) -> float | None:
    """Greatest error of stiffness of any run after it has converged."""
    after = time >= times[:, None]
    return _number(np.max(np.abs(np.expm1(ln_error[after])))) if after.any() else None


def _ratios(track: Track, recording: Recording, bound: Bound, settled: Mask) -> dict[str, float | None]:
    """Root mean square error over the bound's, over all seeds."""
    error = (track.stiffness / recording.truth.stiffness - 1.0)[:, settled]
    k2_error = track.k2[:, -1] - recording.truth.coefficients.k2
    return {
        "stiffness": _rms(error / np.sqrt(np.mean(bound.ln_stiffness[settled]))),
        "k2": _rms(k2_error / np.sqrt(bound.k2[-1])),
    }


def _rms(error: Array) -> float | None:
    return _number(np.sqrt(np.mean(error**2)))


def _mean(values: Array) -> float | None:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else None


def _median(values: Array) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if finite.size else None


def _number(value: Any) -> float | None:
    return float(value) if value is not None and np.isfinite(value) else None
