# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings for `./vsa identify` and `./vsa noise` with known coefficients and noise, and the figures of a run."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_bench.ablation.figures import Figures
from vsa_bench.ablation.recordings import SEED
from vsa_bench.estimation.cases import Case, Coefficients, case
from vsa_bench.estimation.recordings import record
from vsa_bench.estimation.score import TWO_SIDED_95
from vsa_common.types import Array

FORCE_STD, DEFLECTION_STD = 0.017, 1e-5  # white noise of the recordings at rest [N, m]
IDENTIFIED = (
    (case(motion="multisine"), 40.0),
    (case(motion="slow", rate_hz=500, deflection_noise_mm=0.1), 20.0),
    (case("transmission_2", "dwells"), 70.0),
    (case(motion="fast", rate_hz=200, rig="other"), 25.0),
)
HELD = 3  # samples for which the force sensor of the last of them holds its value
JITTER = 0.2  # of its stamps, in sample periods
POINTS = 50  # deflections and speeds at which an identified law is compared


@dataclass(frozen=True)
class Identified:
    """A recording of a motion and the coefficients of its transmission."""

    name: str
    stamps_ns: NDArray[np.int64]
    force: Array  # [N]
    deflection: Array  # [m]
    coefficients: Coefficients


@dataclass(frozen=True)
class Rest:
    """A recording at rest, the noise of its sensors, and whether it is white."""

    name: str
    stamps_ns: NDArray[np.int64]
    force: Array  # [N]
    deflection: Array  # [m]
    white: bool


def offline_recordings(seconds: float | None = None) -> Iterator[Identified | Rest]:
    """All of both kinds, each of its own length or of `seconds` [s]."""
    for one, usual in IDENTIFIED:
        yield _moving(one, seconds or usual)
    yield _uneven(_moving(IDENTIFIED[-1][0], seconds or IDENTIFIED[-1][1]))
    yield from _at_rest(seconds or 30.0)


def run_identification(one: Identified) -> tuple[Figures, str]:
    """Figures and digest of `identify`; stiffness over the deflections, damping over the speeds below v*."""
    from vsa_estimator.offline.identification import NAMES, identify
    from vsa_estimator.offline.instants import corrected

    result = identify([corrected(_offline(one))[0]])
    c, found = one.coefficients, dict(zip(NAMES, result.values.tolist(), strict=True))
    x = np.linspace(float(np.quantile(one.deflection, 0.05)), float(np.quantile(one.deflection, 0.95)), POINTS)
    speed = np.linspace(0.0, c.maximum_speed, POINTS)
    ln_slopes = np.zeros((POINTS, len(NAMES)))
    ln_slopes[:, NAMES.index("k1")], ln_slopes[:, NAMES.index("k2")] = 1.0 / found["k1"], 1.0 / found["k2"] + x
    d_slopes = np.zeros_like(ln_slopes)
    d_slopes[:, NAMES.index("d1")], d_slopes[:, NAMES.index("d2")] = 1.0, 3.0 * speed**2
    ln_error = np.log(found["k1"] * found["k2"] / (c.k1 * c.k2)) + (found["k2"] - c.k2) * x
    error = found["d1"] - c.d1 + 3.0 * (found["d2"] - c.d2) * speed**2
    digest = hashlib.sha256(result.values.tobytes() + result.covariance.tobytes()).hexdigest()
    return Figures(
        stiffness_nrmse=float(np.sqrt(np.mean(ln_error**2))),
        damping_nrmse=float(np.sqrt(np.mean(error**2)) / c.d1),
        stiffness_coverage=_covered(ln_error, ln_slopes, result.covariance),
        damping_coverage=_covered(error, d_slopes, result.covariance),
    ), digest


def run_noise(one: Rest) -> tuple[Figures, str]:
    """Figures and digest of `noise`."""
    from vsa_estimator.offline.noise import analyse

    signals, timing = analyse(_offline(one))
    true = {"force": FORCE_STD, "deflection": DEFLECTION_STD}
    errors = [signals[name].std / std - 1.0 for name, std in true.items()]
    wrong = float(np.mean([signals[name].white != one.white for name in true]))
    digest = hashlib.sha256(repr((signals, timing)).encode()).hexdigest()
    return Figures(noise_error=float(np.sqrt(np.mean(np.square(errors)))), wrong=wrong), digest


def _moving(one: Case, seconds: float) -> Identified:
    source = record(one, [SEED], seconds)
    return Identified(
        f"identify {one.label}", source.stamps_ns, source.force[0], source.deflection[0], one.coefficients
    )


def _uneven(one: Identified) -> Identified:
    """Stamps with jitter, and a force sensor that is slower than the recording."""
    period_ns = float(np.median(np.diff(one.stamps_ns)))
    late_ns = JITTER * period_ns * np.random.default_rng(SEED).random(len(one.stamps_ns))
    force = one.force[np.arange(len(one.force)) // HELD * HELD]
    return replace(one, name=f"{one.name} uneven", stamps_ns=one.stamps_ns + late_ns.astype(np.int64), force=force)


def _at_rest(seconds: float) -> Iterator[Rest]:
    """White noise, with and without lost samples, and noise with a drift (random walk) of its size in a second."""
    random, rate_hz = np.random.default_rng(SEED), 200
    count = round(seconds * rate_hz)
    stamps_ns = 1_000_000_000 + np.arange(count) * (1_000_000_000 // rate_hz)
    white = random.standard_normal((2, count))
    drifting = white + np.cumsum(random.standard_normal((2, count)), axis=1) / np.sqrt(rate_hz)
    received = random.random(count) > 0.015
    for name, noise, kept, is_white in (
        ("noise white", white, received | True, True),
        ("noise with losses", white, received, True),
        ("noise drift", drifting, received | True, False),
    ):
        force, deflection = 20.0 + FORCE_STD * noise[0], 0.01 + DEFLECTION_STD * noise[1]
        yield Rest(name, stamps_ns[kept], force[kept], deflection[kept], is_white)


def _offline(one: Identified | Rest) -> Any:
    from vsa_estimator.offline.recordings import Recording

    stamps_s = np.asarray(1e-9 * one.stamps_ns, np.float64)
    return Recording(Path(one.name), "transmission_1", one.stamps_ns, stamps_s, one.force, one.deflection)


def _covered(error: Array, slopes: Array, covariance: Array) -> float:
    """Share of the 95 % intervals that hold the truth."""
    std = np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    return float(np.mean(np.abs(error) <= TWO_SIDED_95 * std))
