# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Instants of the samples: their stamps, or the sensor's sample clock behind delayed stamps.

The choice is a sequential test on the motion: the deflection is smooth over the true instants and over no others.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.clock_estimate import initial_clock, update_clock
from vsa_estimator.preprocessing.records import TIMESTAMPS
from vsa_estimator.tuning.preprocessing import (
    DECISION_GATE,
    LLR_CAP,
    LLR_CAP_SAMPLES,
    LLR_DECAY,
    MIN_RELOCKS,
    TRACKER_GAP,
    TRACKER_MIN_STEP,
    TRACKER_TIME,
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
    if stamp_ns <= last:
        instant = stamp_ns
    elif instant <= last:
        instant = last + 1
    timestamps["last_instant_ns"] = instant
    return int(instant)


@compiled
def select_instant(timestamps: Any, stamp_ns: int, deflection: float) -> int:
    """Stamp or instant of the clock [ns], whichever the sequential test selects; both count from the first stamp."""
    instant_ns = update_clock(timestamps["clock"], stamp_ns)
    by_stamp = update_tracker(timestamps["by_stamp"], stamp_ns, deflection)
    by_clock = update_tracker(timestamps["by_clock"], instant_ns, deflection)
    update_decision(timestamps["evidence"], by_stamp**2 - by_clock**2)
    decision = timestamps["evidence"]["decision"]
    if decision > 0 or (decision == 0 and timestamps["clock"]["relock_count"] >= MIN_RELOCKS):
        return round(instant_ns)
    return stamp_ns


@compiled
def update_tracker(tracker: Any, instant_ns: float, deflection: float) -> float:
    """Innovation [m] of a deflection at an instant; `tracker`: a TRACKER record of an alpha-beta filter."""
    dt = (instant_ns - tracker["instant_ns"]) * 1e-9
    tracker["instant_ns"] = instant_ns
    if not 0.0 <= dt < TRACKER_GAP * TRACKER_TIME:
        tracker["deflection"] = deflection
        tracker["velocity"] = 0.0
        return 0.0
    innovation = deflection - (tracker["deflection"] + tracker["velocity"] * dt)
    decay = np.exp(-dt / TRACKER_TIME)
    tracker["deflection"] = deflection - decay * decay * innovation
    tracker["velocity"] += (1.0 - decay) * (1.0 - decay) / max(dt, TRACKER_MIN_STEP) * innovation
    return float(innovation)


@compiled
def update_decision(evidence: Any, gain: float) -> None:
    """Add the squared innovation that the clock saves [m^2]; `evidence`: an EVIDENCE record."""
    if gain == 0.0:
        return
    if evidence["samples"] > LLR_CAP_SAMPLES:
        limit = LLR_CAP * np.sqrt(evidence["gain_squares"] / evidence["samples"])
        gain = max(-limit, min(limit, gain))
    fading = 1.0 - LLR_DECAY
    evidence["samples"] = evidence["samples"] * fading + 1.0
    evidence["gain"] = evidence["gain"] * fading + gain
    evidence["gain_squares"] = evidence["gain_squares"] * fading + gain * gain
    if evidence["gain"] * evidence["gain"] > DECISION_GATE * DECISION_GATE * evidence["gain_squares"]:
        evidence["decision"] = 1 if evidence["gain"] > 0.0 else -1
