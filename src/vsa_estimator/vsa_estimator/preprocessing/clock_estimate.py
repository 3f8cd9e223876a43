# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimate of the sensor's sample clock from stamps that a busy host delays.

The sensor samples at a constant period. A stamp is never early, so the least delayed stamps follow the sensor's clock:
the lower envelope of one-way clock synchronisation. A phase-locked loop on the minimum delays estimates the period and
the phase.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.lost_samples import elapsed_periods, relock
from vsa_estimator.preprocessing.records import CLOCK
from vsa_estimator.tuning.preprocessing import (
    CATCH_UP_HOLD,
    CATCH_UP_RATIO,
    COUNTED_LOOP_WINDOW,
    INTEGER_TOLERANCE,
    IRREGULAR_RECOVERY,
    JITTER_GATE,
    JITTER_WINDOW,
    LOCKED_DRIFT,
    LOCKED_GAIN,
    MAX_GAP_NS,
    MAX_INTERVAL_NS,
    MAX_IRREGULAR,
    MAX_JITTER,
    MAX_LOOP_WINDOW,
    MAX_OVERLOAD_NS,
    MIN_JITTER,
    MIN_LOOP_WINDOW,
    MIN_PERIOD_RATIO,
    MISCOUNT_ADVANCE,
    OVERLOAD_DELAY,
    PERIOD_WINDOW,
)


def initial_clock() -> NDArray[Any]:
    """(1,) CLOCK before the first stamp."""
    state = np.zeros(1, CLOCK)
    state["period_ns"], state["last_stamp_ns"] = np.inf, -np.inf
    return state


@compiled
def update_clock(clock: Any, stamp_ns: int) -> float:
    """Instant [ns] of the sample with this stamp by the sensor's clock, never later than the stamp.

    `clock`: a CLOCK record; the stamp counts from the first one.
    """
    step = stamp_ns - clock["last_stamp_ns"]
    clock["last_stamp_ns"] = stamp_ns
    overdue = clock["window_count"] - clock["window"]
    if clock["irregular_count"] > MAX_IRREGULAR or overdue > MAX_OVERLOAD_NS / clock["period_ns"]:
        clock["period_ns"], clock["interval_count"] = np.inf, 0.0
        synchronise(clock, stamp_ns)
    elif not 0.0 <= step <= (MAX_GAP_NS if clock["is_counted"] else MAX_INTERVAL_NS):
        clock["queued"] = step / clock["period_ns"] if 0.0 < step < np.inf else 0.0
        synchronise(clock, stamp_ns)
    elif clock["queued"] >= 1.0 and step < CATCH_UP_RATIO * clock["period_ns"]:
        clock["queued"] -= 1.0
        synchronise(clock, stamp_ns)
    elif clock["period_ns"] == np.inf:
        initialize_period(clock, step)
        synchronise(clock, stamp_ns)
    else:
        update_jitter(clock, step)
        passed = elapsed_periods(clock, stamp_ns, step)
        count_irregular(clock, step / clock["period_ns"], passed)
        expected = clock["instant_ns"] + passed * clock["period_ns"]
        delay = stamp_ns - expected
        clock["instant_ns"] = min(expected, stamp_ns)
        count_relock(clock, delay)
        correct_phase(clock, delay)
    return float(clock["instant_ns"])


@compiled
def synchronise(clock: Any, stamp_ns: int) -> None:
    """Set the phase to this stamp."""
    clock["instant_ns"] = stamp_ns
    clock["catch_up_hold"] = clock["lost"] = 0
    clock["irregular_count"] = 0.0
    clock["window"] = MIN_LOOP_WINDOW
    begin_window(clock)
    relock(clock)


@compiled
def initialize_period(clock: Any, step: float) -> None:
    """Take one interval [ns]; the median of PERIOD_WINDOW intervals is the period."""
    clock["intervals_ns"][int(clock["interval_count"])] = step
    clock["interval_count"] += 1.0
    if clock["interval_count"] == PERIOD_WINDOW:
        clock["period_ns"] = np.median(clock["intervals_ns"])
        clock["jitter_ns"] = MAX_JITTER * clock["period_ns"]


@compiled
def update_jitter(clock: Any, step: float) -> None:
    """Mean deviation of regular intervals from the period."""
    period, jitter = clock["period_ns"], clock["jitter_ns"]
    deviation = abs(step - period)
    if deviation < min(JITTER_GATE * jitter, MAX_JITTER * period):
        clock["interval_count"] = min(clock["interval_count"] + 1.0, JITTER_WINDOW)
        clock["jitter_ns"] += (max(deviation, MIN_JITTER * period) - jitter) / clock["interval_count"]
    else:
        clock["jitter_ns"] += min(jitter, MAX_JITTER * period) / JITTER_WINDOW


@compiled
def count_irregular(clock: Any, interval: float, passed: float) -> None:
    """Count the samples that show another rate: by an `interval` [periods] in which so many have `passed`.

    Where the driver counts, all of the intervals are longer then; delayed samples catch up.
    """
    count, longer = clock["irregular_count"], interval - passed
    irregular = longer > MAX_JITTER if clock["is_counted"] else passed != 1.0
    if clock["is_counted"] and longer < -MAX_JITTER:
        count = 0.0
    else:
        count = count + 1.0 if irregular else max(0.0, count - IRREGULAR_RECOVERY)
    clock["irregular_count"] = count


@compiled
def count_relock(clock: Any, delay: float) -> None:
    """Count a return from a delay [ns] with catch-up: it proves a sample clock behind the stamps."""
    if delay > 1.5 * clock["period_ns"]:
        clock["was_delayed"] = True
    elif clock["was_delayed"] and delay < 0.5 * clock["period_ns"]:
        clock["was_delayed"] = False
        if clock["catch_up_hold"] == CATCH_UP_HOLD and clock["jitter_ns"] < INTEGER_TOLERANCE * clock["period_ns"]:
            clock["relock_count"] += 1


@compiled
def correct_phase(clock: Any, delay: float) -> None:
    """Phase-locked loop: at the end of a window correct phase and period by the minimum delays [ns] of its halves.

    A long window, which exists where the driver counts, is no measurement while all samples of a half are late.
    """
    half = 0 if clock["window_count"] < 0.5 * clock["window"] else 1
    if delay < -MISCOUNT_ADVANCE * clock["period_ns"]:
        clock["is_miscounted"] = True
    min_delay = clock["min_delay_ns"]
    min_delay[half] = min(min_delay[half], delay - clock["advance_ns"])
    clock["advance_ns"] += max(-delay, 0.0)
    clock["window_count"] += 1.0
    if clock["window_count"] < clock["window"]:
        return
    if clock["window"] > MAX_LOOP_WINDOW:
        latest = OVERLOAD_DELAY * clock["period_ns"] - clock["advance_ns"]
        if min_delay[1] > latest:  # an overload: the window lasts until it ends
            return
        if min_delay[0] > latest:
            begin_window(clock)
            return
    window, drift = clock["window"], min_delay[1] - min_delay[0]
    locked = abs(drift) < LOCKED_DRIFT * clock["period_ns"]
    if not clock["is_miscounted"] or window == MIN_LOOP_WINDOW:
        clock["instant_ns"] += max(0.0, min_delay[1] + clock["advance_ns"])
        period = clock["period_ns"] + (LOCKED_GAIN if locked else 1.0) * drift / (0.5 * clock["window_count"])
        clock["period_ns"] = max(period, MIN_PERIOD_RATIO * clock["period_ns"])
    longest = COUNTED_LOOP_WINDOW if clock["is_counted"] else MAX_LOOP_WINDOW
    clock["window"] = min(2.0 * window, longest) if locked else max(0.5 * window, MIN_LOOP_WINDOW)
    begin_window(clock)


@compiled
def begin_window(clock: Any) -> None:
    """Begin a window of the phase-locked loop."""
    clock["window_count"] = clock["advance_ns"] = 0.0
    clock["is_miscounted"] = False
    clock["min_delay_ns"][:] = np.inf
