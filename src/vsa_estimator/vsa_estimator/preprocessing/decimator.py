"""Averages fast samples down to the filter's rate; at or below that rate a sample passes as it is."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array

SPAN = 0.95  # of the filter's period: samples that span it make a block

# What is remembered: usual time between two samples and time of a block [ns]; sums of the unfinished block.
PERIOD, SPAN_NS, DEFLECTION_SUM, FORCE_SUM, MEANS = range(5)  # deflection and force of up to two finished ones: MEANS
MEMORY = 9
# In whole numbers: the last stamp and the block's first [ns], sum of the offsets from it, samples, forces.
LAST, FIRST, OFFSET_SUM, COUNT, FORCES, FINISHED = range(6)  # stamp, samples and forces of up to two blocks: FINISHED
STAMPS = 12

Stamps = NDArray[np.int64]


class Decimated(NamedTuple):
    """Mean of consecutive samples."""

    stamp_ns: int  # mean stamp of the deflections
    deflection: float  # [m]
    force: float  # mean of the fresh forces; 0 where there was none [N]
    samples: int
    forces: int  # fresh ones among them


def no_samples(rate: float) -> Array:
    """Memory before the first sample; `rate` of the filter [Hz]."""
    memory = np.zeros(MEMORY)
    memory[SPAN_NS] = SPAN * 1e9 / rate
    return memory


@compiled
def averages(memory: Array) -> bool:
    """Whether samples come at least twice as fast as the filter steps."""
    return bool(0.0 < 2.0 * memory[PERIOD] <= memory[SPAN_NS])


@compiled
def clear(memory: Array, stamps: Stamps) -> None:
    """Forget the unfinished block."""
    memory[DEFLECTION_SUM] = memory[FORCE_SUM] = 0.0
    stamps[FIRST:FINISHED] = 0


@compiled
def finish(memory: Array, stamps: Stamps, which: int) -> None:
    """The block is complete."""
    count, forces = stamps[COUNT], stamps[FORCES]
    memory[MEANS + 2 * which] = memory[DEFLECTION_SUM] / count
    memory[MEANS + 2 * which + 1] = memory[FORCE_SUM] / forces if forces else 0.0
    stamps[FINISHED + 3 * which] = stamps[FIRST] + stamps[OFFSET_SUM] // count
    stamps[FINISHED + 3 * which + 1] = count
    stamps[FINISHED + 3 * which + 2] = forces
    clear(memory, stamps)


@compiled
def collect(
    memory: Array, stamps: Stamps, stamp_ns: int, deflection: float, force: float, placed: bool, fresh: bool
) -> int:
    """Take a sample, deflection and force if they are `placed` and `fresh`; how many blocks it finishes, at most two.

    Samples are collected until they span one period of the filter, by their stamps.
    """
    step = stamp_ns - stamps[LAST]
    gap = stamps[FIRST] > 0 and step > 2.0 * memory[SPAN_NS]
    if memory[PERIOD] == 0.0:
        memory[PERIOD] = step if stamps[LAST] else 0.0
    elif step < 3.0 * memory[PERIOD]:
        memory[PERIOD] += 0.02 * (step - memory[PERIOD])
    elif step < 1e9:
        memory[PERIOD] *= 1.02
    stamps[LAST] = stamp_ns
    finished = 0
    if gap:
        if stamps[COUNT]:
            finish(memory, stamps, 0)
            finished = 1
        clear(memory, stamps)
    if not stamps[FIRST]:
        stamps[FIRST] = stamp_ns
    if placed:
        stamps[OFFSET_SUM] += stamp_ns - stamps[FIRST]
        memory[DEFLECTION_SUM] += deflection
        stamps[COUNT] += 1
    if fresh:
        memory[FORCE_SUM] += force
        stamps[FORCES] += 1
    if stamps[COUNT] and memory[PERIOD] and stamp_ns - stamps[FIRST] + memory[PERIOD] >= memory[SPAN_NS]:
        finish(memory, stamps, finished)
        finished += 1
    return finished


def finished_blocks(memory: Array, stamps: Stamps, count: int) -> list[Decimated]:
    """The blocks that the last sample has finished."""
    blocks = []
    for which in range(count):
        deflection, force = memory[MEANS + 2 * which : MEANS + 2 * which + 2].tolist()
        stamp_ns, samples, forces = stamps[FINISHED + 3 * which : FINISHED + 3 * which + 3].tolist()
        blocks.append(Decimated(stamp_ns, deflection, force, samples, forces))
    return blocks
