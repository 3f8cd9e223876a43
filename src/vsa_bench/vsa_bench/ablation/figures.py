# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of one run, and their change from one run to another."""

from dataclasses import asdict, dataclass

import numpy as np
from vsa_bench.ablation.recordings import Recording
from vsa_bench.estimation.score import TWO_SIDED_95, WRONG_SHARE, WRONG_STDS, time_to_accuracy
from vsa_common.types import Array, Booleans

SCORED_FROM = 0.4  # errors and coverage are taken over what follows this share of a recording
ERRORS = ("stiffness_nrmse", "damping_nrmse", "noise_error", "instant_error")
FIELDS = (
    "stiffness", "stiffness_variance", "stiffness_valid", "damping", "damping_variance", "damping_valid",
)  # fmt: skip


@dataclass(frozen=True)
class Figures:
    """Errors and shares as fractions; None where a run does not define a figure."""

    stiffness_nrmse: float | None = None
    damping_nrmse: float | None = None  # while damping is valid
    noise_error: float | None = None  # of the sensors' noise at rest
    instant_error: float | None = None  # of the instants of the samples, rms [ns]
    stiffness_coverage: float | None = None  # of the 95 % interval
    damping_coverage: float | None = None  # of the 95 % interval, while damping is valid
    convergence_time_s: float | None = None  # from when on stiffness stays within 5 %
    stiffness_valid: float | None = None  # share of the samples
    damping_valid: float | None = None  # share of the samples
    wrong: float | None = None  # share of the samples that are valid and off by 4 deviations and 1 %, or of the signals
    flagged: float | None = None  # share of the samples with a flag of the preprocessing
    accepted: float | None = None  # share of the samples that enter it
    resets: int | None = None


def figures(recording: Recording, estimates: dict[str, Array], resets: int) -> Figures:
    """Figures of a run from its `estimates`, one array for each of FIELDS, NaN where a sample was dropped."""
    used = np.isfinite(estimates["stiffness"])
    recording = recording.selected(used)
    e = {name: values[used] for name, values in estimates.items()}
    scored = recording.time >= SCORED_FROM * recording.time[-1]
    damping_scored = scored & (e["damping_valid"] > 0) & recording.damping_defined
    with np.errstate(all="ignore"):
        ln_error = np.log(np.maximum(e["stiffness"], 1e-9) / recording.stiffness)
        ln_std = np.sqrt(e["stiffness_variance"]) / e["stiffness"]
        damping_error, damping_std = e["damping"] - recording.damping, np.sqrt(e["damping_variance"])
        converged = float(time_to_accuracy(ln_error[None], recording.time)[0])
        wrong = _wrong(e, "stiffness", recording.stiffness) | _wrong(e, "damping", recording.damping)
        return Figures(
            stiffness_nrmse=_nrmse(e["stiffness"] - recording.stiffness, recording.stiffness, scored),
            damping_nrmse=_nrmse(damping_error, recording.damping, damping_scored),
            stiffness_coverage=_share(np.abs(ln_error) <= TWO_SIDED_95 * ln_std, scored),
            damping_coverage=_share(np.abs(damping_error) <= TWO_SIDED_95 * damping_std, damping_scored),
            convergence_time_s=converged if np.isfinite(converged) else None,
            stiffness_valid=float(np.mean(e["stiffness_valid"] > 0)),
            damping_valid=float(np.mean(e["damping_valid"] > 0)),
            wrong=float(np.mean(wrong)),
            resets=resets,
        )


def changes(base: Figures, varied: Figures, duration: float) -> dict[str, float]:
    """Change of each figure: of errors relative, of the convergence time as a share of `duration` [s], else absolute.

    A figure that only one of the two runs defines has changed by 1.
    """
    result = {}
    before, after = asdict(base), asdict(varied)
    for name, old in before.items():
        new = after[name]
        if old is None or new is None:
            result[name] = float((old is None) != (new is None))
        elif name in ERRORS:
            result[name] = new / old - 1.0 if old > 0.0 else float(new > 0.0)
        else:
            result[name] = (new - old) / (duration if name == "convergence_time_s" else 1.0)
    return result


def _nrmse(error: Array, true: Array, part: Booleans) -> float | None:
    if not part.any():
        return None
    return float(np.sqrt(np.mean(error[part] ** 2) / np.mean(true[part] ** 2)))


def _share(held: Booleans, part: Booleans) -> float | None:
    return float(np.mean(held[part])) if part.any() else None


def _wrong(estimates: dict[str, Array], name: str, true: Array) -> Booleans:
    """Samples that are valid and off by more than 4 standard deviations and 1 %, as `bench estimation` counts them."""
    error = np.abs(estimates[name] - true)
    wrong = error > WRONG_STDS * np.sqrt(estimates[f"{name}_variance"])
    wrong &= error > WRONG_SHARE * np.maximum(np.abs(true), WRONG_SHARE * np.abs(true).max())
    return np.asarray(wrong & (estimates[f"{name}_valid"] > 0))
