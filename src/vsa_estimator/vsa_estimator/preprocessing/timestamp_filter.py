# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Instants of the samples: their stamps, or the sensor's sample clock behind delayed stamps.

The choice is a sequential test on the motion: the deflection is smooth over the true instants and over no others.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.clock_estimate import initial_clock, update_clock
from vsa_estimator.preprocessing.records import TIMESTAMPS
from vsa_estimator.tuning.preprocessing import (
    DECISION_LLR,
    LLR_CAP,
    LLR_RUNS,
    MAX_JITTER,
    MAX_RUN_NS,
    MIN_RELOCKS,
    MIN_RESIDUAL,
    RESIDUAL_RUNS,
)


def initial_timestamps() -> NDArray[Any]:
    """(1,) TIMESTAMPS before the first stamp."""
    state = np.zeros(1, TIMESTAMPS)
    state["clock"] = initial_clock()
    return state


@compiled
def corrected_stamp(timestamps: Any, stamp_ns: int, deflection: float) -> int:
    """Instant [ns] of a sample [ns, m], not after its stamp; strictly increasing as the stamps are.

    `timestamps`: a TIMESTAMPS record.
    """
    if not timestamps["origin_ns"]:
        timestamps["origin_ns"] = stamp_ns
    origin, last = timestamps["origin_ns"], timestamps["last_instant_ns"]
    instant = origin + select_instant(timestamps, stamp_ns - origin, deflection)
    if instant <= last:
        instant = last + 1
    timestamps["last_instant_ns"] = instant
    return int(instant)


@compiled
def select_instant(timestamps: Any, stamp_ns: int, deflection: float) -> int:
    """Stamp or instant of the clock [ns], whichever the sequential test selects; both count from the first stamp."""
    clock, evidence = timestamps["clock"], timestamps["evidence"]
    instant_ns = update_clock(clock, stamp_ns)
    if stamp_ns - instant_ns > MAX_JITTER * clock["period_ns"]:
        add_delayed(evidence, stamp_ns, instant_ns, deflection)
    else:
        end_run(evidence, stamp_ns, deflection)
    decision = evidence["decision"]
    if decision > 0 or (decision == 0 and clock["relock_count"] >= MIN_RELOCKS):
        return round(instant_ns)
    return stamp_ns


@compiled
def add_delayed(evidence: Any, stamp_ns: float, instant_ns: float, deflection: float) -> None:
    """Add a delayed sample to the run; `evidence`: an EVIDENCE record."""
    x = deflection - evidence["start_deflection"]
    s, c = stamp_ns - evidence["start_ns"], instant_ns - evidence["start_ns"]
    evidence["samples"] += 1.0
    evidence["xx"] += x * x
    evidence["xs"] += x * s
    evidence["ss"] += s * s
    evidence["xc"] += x * c
    evidence["cc"] += c * c


@compiled
def end_run(evidence: Any, stamp_ns: float, deflection: float) -> None:
    """End the run at a sample that is not delayed; the next one begins there."""
    elapsed = stamp_ns - evidence["start_ns"]
    if evidence["samples"] > 0.0 and elapsed < MAX_RUN_NS:
        compare(evidence, (deflection - evidence["start_deflection"]) / elapsed)
    evidence["start_ns"], evidence["start_deflection"] = stamp_ns, deflection
    evidence["samples"] = evidence["xx"] = evidence["xs"] = evidence["ss"] = evidence["xc"] = evidence["cc"] = 0.0


@compiled
def compare(evidence: Any, velocity: float) -> None:
    """Add the log likelihood ratio of a run with a uniform motion [m/ns] between the samples before and after it.

    The residuals of n samples are correlated, since they share those two: they count as sqrt(n) independent ones.
    """
    if velocity == 0.0:
        return
    by_stamp = evidence["xx"] - 2.0 * velocity * evidence["xs"] + velocity * velocity * evidence["ss"]
    by_clock = evidence["xx"] - 2.0 * velocity * evidence["xc"] + velocity * velocity * evidence["cc"]
    best = max(min(by_stamp, by_clock) / evidence["samples"], MIN_RESIDUAL * MIN_RESIDUAL)
    gain = 1.0 / RESIDUAL_RUNS if evidence["residual"] > 0.0 else 1.0
    evidence["residual"] += gain * (best - evidence["residual"])
    ratio = 0.5 * (by_stamp - by_clock) / (math.sqrt(evidence["samples"]) * evidence["residual"])
    evidence["llr"] += min(max(ratio, -LLR_CAP), LLR_CAP) - evidence["llr"] / LLR_RUNS
    if abs(evidence["llr"]) > DECISION_LLR:
        evidence["decision"] = 1 if evidence["llr"] > 0.0 else -1
