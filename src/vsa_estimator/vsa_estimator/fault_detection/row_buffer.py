# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The recent filter steps, for the parity residuals."""

import numpy as np
from vsa_common.types import Array


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
