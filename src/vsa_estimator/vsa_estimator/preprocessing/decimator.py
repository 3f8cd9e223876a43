# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Block averages of fast samples at the filter's rate; at or below that rate a sample is a block by itself."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.records import DECIMATOR
from vsa_estimator.tuning.preprocessing import (
    BLOCK_GAP,
    BLOCK_SPAN,
    MAX_GAP_NS,
    PERIOD_GAIN,
    PERIOD_GROWTH,
    REGULAR_RATIO,
)


class Decimated(NamedTuple):
    """Mean of consecutive samples."""

    stamp_ns: int  # mean stamp
    deflection: float  # [m]
    force: float  # of the same samples; 0 without a usable one [N]
    samples: int
    forces: int  # as `samples`; 0 without a usable force
    max_increment: float  # greatest change of the deflection from one sample to the next [m]
    min_increment: float  # least such change [m]


def initial_decimator(rate: float) -> NDArray[Any]:
    """(1,) DECIMATOR before the first sample; `rate` of the filter [Hz]."""
    state = np.zeros(1, DECIMATOR)
    state["span_ns"] = BLOCK_SPAN * 1e9 / rate
    for increment in ("last_deflection", "max_increment", "min_increment"):
        state[increment] = np.nan
    return state


def finished_blocks(decimator: Any, count: int) -> list[Decimated]:
    """The first `count` blocks that the last sample has finished; `decimator`: a DECIMATOR record."""
    return [Decimated(*block) for block in decimator["finished"][:count].tolist()]


@compiled
def is_decimating(period_ns: float, span_ns: float) -> bool:
    """Whether samples of this period come at least twice in the span of a block."""
    return bool(0.0 < 2.0 * period_ns <= span_ns)


@compiled
def add_sample(
    decimator: Any, stamp_ns: int, deflection: float, force: float, deflection_usable: bool, force_usable: bool
) -> int:
    """Add a sample [ns, m, N]; count of blocks that it finishes, at most two.

    A block collects samples until their stamps span one period of the filter. Its means are over the same samples:
    a force of another mean stamp would be that of another deflection. Deflections alone count in a block without force.
    """
    step = stamp_ns - decimator["last_stamp_ns"]
    gap = decimator["first_stamp_ns"] > 0 and step > BLOCK_GAP * decimator["span_ns"]
    update_period(decimator, step)
    decimator["last_stamp_ns"] = stamp_ns
    finished = 0
    if gap:
        if decimator["samples"]:
            finish_block(decimator, 0)
            finished = 1
        clear_block(decimator)
    if not decimator["first_stamp_ns"]:
        decimator["first_stamp_ns"] = stamp_ns
    if deflection_usable:
        update_increments(decimator, deflection)
    is_pair = deflection_usable and force_usable
    if is_pair and decimator["forces"] == 0:
        clear_sums(decimator)
    if is_pair or (deflection_usable and decimator["forces"] == 0):
        decimator["offset_sum_ns"] += stamp_ns - decimator["first_stamp_ns"]
        decimator["deflection_sum"] += deflection
        decimator["samples"] += 1
    if is_pair:
        decimator["force_sum"] += force
        decimator["forces"] += 1
    period, first = decimator["period_ns"], decimator["first_stamp_ns"]
    if decimator["samples"] and period and stamp_ns - first + period >= decimator["span_ns"]:
        finish_block(decimator, finished)
        finished += 1
    return finished


@compiled
def update_period(decimator: Any, step: int) -> None:
    """Running mean of the sample period after an interval [ns]."""
    period = decimator["period_ns"]
    if period == 0.0:
        decimator["period_ns"] = step if decimator["last_stamp_ns"] else 0.0
    elif step < REGULAR_RATIO * period:
        decimator["period_ns"] += PERIOD_GAIN * (step - period)
    elif step < MAX_GAP_NS:
        decimator["period_ns"] *= PERIOD_GROWTH


@compiled
def update_increments(decimator: Any, deflection: float) -> None:
    """Greatest and least change of the deflection [m] from one sample of the block to the next."""
    increment = deflection - decimator["last_deflection"]
    decimator["last_deflection"] = deflection
    decimator["max_increment"] = np.fmax(decimator["max_increment"], increment)
    decimator["min_increment"] = np.fmin(decimator["min_increment"], increment)


@compiled
def finish_block(decimator: Any, index: int) -> None:
    """Store the mean of the collected samples as finished block `index`."""
    block = decimator["finished"][index]
    samples, forces = decimator["samples"], decimator["forces"]
    block["stamp_ns"] = decimator["first_stamp_ns"] + decimator["offset_sum_ns"] // samples
    block["deflection"] = decimator["deflection_sum"] / samples
    block["force"] = decimator["force_sum"] / forces if forces else 0.0
    block["samples"] = samples
    block["forces"] = forces
    block["max_increment"], block["min_increment"] = decimator["max_increment"], decimator["min_increment"]
    clear_block(decimator)


@compiled
def clear_block(decimator: Any) -> None:
    """Begin a new block."""
    decimator["first_stamp_ns"] = 0
    decimator["max_increment"] = decimator["min_increment"] = np.nan
    clear_sums(decimator)


@compiled
def clear_sums(decimator: Any) -> None:
    """Discard the collected samples."""
    decimator["deflection_sum"] = decimator["force_sum"] = 0.0
    decimator["offset_sum_ns"] = decimator["samples"] = decimator["forces"] = 0
