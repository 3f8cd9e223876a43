# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Rate of the sensors' samples from the counter of an estimator."""

from vsa_joint.excitation.tuning import RATE_WINDOW_NS


class SampleRate:
    """Samples a second over the last RATE_WINDOW_NS."""

    def __init__(self) -> None:
        self._first: tuple[int, int] | None = None  # stamp [ns] and samples
        self._rate = 0.0

    def update(self, stamp_ns: int, samples: int) -> float:
        """Take the number of samples at a stamp; the rate [Hz], 0 until it is known."""
        if self._first is None or samples < self._first[1] or stamp_ns < self._first[0]:
            self._first, self._rate = (stamp_ns, samples), 0.0
        elif stamp_ns - self._first[0] >= RATE_WINDOW_NS:
            self._rate = 1e9 * (samples - self._first[1]) / (stamp_ns - self._first[0])
            self._first = stamp_ns, samples
        return self._rate
