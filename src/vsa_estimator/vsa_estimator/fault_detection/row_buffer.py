# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The recent filter steps, for the parity residuals, and which of their forces are outliers or a vibration."""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.tuning.fault_detection import MAX_DAMPER_ERROR


class RowBuffer:
    """The last filter steps: time [s], deflection [m], force [N], 1 after a rejection, as rows of a (4, n) view."""

    def __init__(self, capacity: int) -> None:
        """Keep the last `capacity` steps."""
        self._capacity = capacity
        self._buffer = np.empty((4, 2 * capacity))
        self._begin = self._end = 0

    @property
    def view(self) -> Array:
        """The steps (4, n), oldest first; valid until the next `append`."""
        return self._buffer[:, self._begin : self._end]

    @property
    def deflection(self) -> Array:
        """Deflections of the steps (n,) [m]."""
        return self.view[1]

    def append(self, time: float, deflection: float, force: float, after_rejection: bool) -> None:
        """Add a step."""
        if self._end == 2 * self._capacity:
            recent = self.view.copy()
            self._begin, self._end = 0, recent.shape[1]
            self._buffer[:, : self._end] = recent
        self._buffer[:, self._end] = time, deflection, force, after_rejection
        self._end += 1
        self._begin = max(self._begin, self._end - self._capacity)

    def drop_before(self, time: float) -> None:
        """Drop the steps before `time` [s]."""
        self._begin += int(np.searchsorted(self.view[0], time))

    def clear(self) -> None:
        """Drop all steps."""
        self._begin = self._end = 0


@compiled
def is_confirmed(force: Array, i: int) -> bool:
    """Whether force i is no single outlier: within MAX_DAMPER_ERROR [N] of the range of the forces before and after.

    NaN is no force. One without a force before and after is not confirmed.
    """
    before, after = i - 1, i + 1
    while before > 0 and np.isnan(force[before]):
        before -= 1
    while after < force.size - 1 and np.isnan(force[after]):
        after += 1
    low, high = np.fmin(force[before], force[after]), np.fmax(force[before], force[after])
    return bool(low - MAX_DAMPER_ERROR < force[i] < high + MAX_DAMPER_ERROR)


@compiled
def vibrates(force: Array, i: int, width: int) -> bool:
    """Whether force i and another one within `width` rows of it are unconfirmed: the rod vibrates with its tendon.

    It does beyond v*, where nothing damps it: faster than v* within some micrometres, which the encoder does not show.
    """
    if np.isnan(force[i]) or is_confirmed(force, i):
        return False
    vibrating = False
    for k in range(max(1, i - width), min(force.size - 1, i + width + 1)):
        vibrating |= k != i and not np.isnan(force[k]) and not is_confirmed(force, k)
    return vibrating
