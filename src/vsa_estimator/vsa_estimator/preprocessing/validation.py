"""What may reach the filter: finite numbers with stamps that go forward. All else is counted."""

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array

IMPLAUSIBLE_RATIO = 10.0  # multiple of a sensor's limit that is no measurement
LATE_NS = 1_000_000_000  # a stamp further back than this is a clock that was set back, not a late sample
LATE_RUN = 50  # and so is a run of this many late samples

ACCEPT, DROP, TIME_RESET = range(3)  # what to do with a sample; JUMP: time went back, start again with this sample

LAST, LATE = range(2)  # stamps that are remembered: the last one taken [ns], late ones in turn
STAMPS = 2


@compiled
def validate(bounds: Array, stamps: NDArray[np.int64], stamp_ns: int, force: float, deflection: float) -> int:
    """TAKE, DROP or JUMP for a sample. Magnitudes beyond the bounds [N, m] are no measurements at all.

    A sample that made time JUMP is taken when it comes again.
    """
    plausible = abs(force) < bounds[0] and abs(deflection) < bounds[1]
    if stamp_ns <= 0 or not plausible:  # a NaN is not plausible either
        return DROP
    last = stamps[LAST]
    if stamp_ns > last:
        stamps[LAST] = stamp_ns
        stamps[LATE] = 0
        return ACCEPT
    if stamp_ns < last:
        stamps[LATE] += 1
    if last - stamp_ns > LATE_NS or stamps[LATE] >= LATE_RUN:
        stamps[LAST] = stamp_ns - 1
        stamps[LATE] = 0
        return TIME_RESET
    return DROP
