# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sample periods between two stamps, by the samples that the driver counts as lost, or by the stamps alone.

By the stamps, delayed samples catch up and lost samples leave a constant lag.
"""

from typing import Any

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.tuning.preprocessing import (
    CATCH_UP_HOLD,
    CATCH_UP_RATIO,
    HOLD_OFF_EXPONENT,
    INTEGER_TOLERANCE,
    JITTER_GATE,
    LOSS_RATE_WINDOW,
    LOSS_RUN,
    MAX_DELAY_NS,
    MAX_DELAYED_NS,
    MAX_JITTER,
    MAX_LOOP_WINDOW,
    MIN_DELAY_GROWTH,
    OFF_GRID_LOSS_RUN,
)


@compiled
def elapsed_periods(clock: Any, stamp_ns: int, step: float) -> float:
    """Periods since the sample before, which is `step` [ns] earlier: one, but for lost or miscounted samples.

    `clock`: a CLOCK record with a period.
    """
    period = clock["period_ns"]
    gap = (stamp_ns - clock["instant_ns"]) / period
    whole = np.rint(gap)
    tolerance = min(INTEGER_TOLERANCE, JITTER_GATE * clock["jitter_ns"] / period)
    if step < CATCH_UP_RATIO * period:
        clock["catch_up_hold"] = CATCH_UP_HOLD
    elif clock["catch_up_hold"] > 0:
        clock["catch_up_hold"] -= 1
    elif step > 1.5 * period and not clock["is_counted"] and abs(gap - whole) < tolerance:
        relock(clock)
        return float(whole)
    if clock["is_counted"]:
        passed, clock["lost"] = min(1.0 + clock["lost"], max(whole, 1.0)), 0  # no more than the elapsed time permits
        return float(passed)
    passed = min(np.floor(gap + MAX_JITTER), 1.0)  # zero or less where earlier periods were miscounted
    delay = gap - passed
    lag = np.rint(delay)
    on_grid = abs(delay - lag) < INTEGER_TOLERANCE and (lag == 0.0 or lag == clock["lag"])
    clock["off_grid_share"] += ((0.0 if on_grid else 1.0) - clock["off_grid_share"]) / MAX_LOOP_WINDOW
    if delay < 0.5:
        if clock["delayed_run"] > 0 or passed < 1.0:
            clock["loss_rate"] -= clock["loss_rate"] / LOSS_RATE_WINDOW
        relock(clock)
        return float(passed)
    clock["same_lag_run"] = clock["same_lag_run"] + 1 if on_grid else 0
    return float(passed + lost_samples(clock, delay, step))


@compiled
def lost_samples(clock: Any, delay: float, step: float) -> float:
    """Samples lost before one with this `delay` [periods], `step` [ns] after the sample before; 0 while undecided."""
    period = clock["period_ns"]
    clock["lag"] = np.rint(delay)
    clock["delayed_run"] += 1
    clock["min_delay"] = min(MIN_DELAY_GROWTH * clock["min_delay"], delay)
    hold_off = (1.0 - clock["loss_rate"]) ** HOLD_OFF_EXPONENT
    lost = 0.0
    if clock["same_lag_run"] >= LOSS_RUN + OFF_GRID_LOSS_RUN * clock["off_grid_share"] * hold_off:
        lost = clock["lag"]
    elif step > CATCH_UP_RATIO * period and (
        clock["delayed_run"] * period > MAX_DELAYED_NS * hold_off
        or (clock["delayed_run"] > LOSS_RUN and clock["min_delay"] * period > MAX_DELAY_NS * hold_off)
    ):
        lost = np.rint(clock["min_delay"])
    if lost > 0.0:
        clock["loss_rate"] += (1.0 - clock["loss_rate"]) / LOSS_RATE_WINDOW
        relock(clock)
    return float(lost)


@compiled
def relock(clock: Any) -> None:
    """End the run of delayed samples: the stamps are in lock with the clock."""
    clock["delayed_run"] = clock["same_lag_run"] = 0
    clock["min_delay"] = np.inf
