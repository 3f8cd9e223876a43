# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Instants of predicted estimates while the sensors are silent."""

WATCHDOG_PERIOD = 0.005  # of the check for silence [s]
STARVED_NS = 20_000_000  # a check later than this was starved: queued samples come first for as long [ns]
MAX_DEFERRAL_NS = 200_000_000  # silence after which predictions are not deferred [ns]
PREDICTION_STEP_NS = 10_000_000  # interval of predicted estimates in silence [ns]
FIRST_STEP = 5  # first predicted estimate after a silence of so many steps: 50 ms, the limit of STALE
MAX_STEPS = 10  # predicted estimates in one call


class Watchdog:
    """Whether a check for silence may predict; after a starved moment queued samples come first."""

    def __init__(self) -> None:
        """Before the first check."""
        self._checked_ns = self._deferred_until_ns = 0

    def may_predict(self, now_ns: int, silence_ns: int) -> bool:
        """Whether the check at `now_ns` of a steady clock may predict after a silence of `silence_ns` [ns]."""
        if now_ns - self._checked_ns > STARVED_NS:
            self._deferred_until_ns = now_ns + STARVED_NS
        self._checked_ns = now_ns
        return now_ns >= self._deferred_until_ns or silence_ns > MAX_DEFERRAL_NS


def prediction_stamps(stamp_ns: int, published_ns: int, silence_ns: int) -> list[int]:
    """Stamps [ns] of the predictions that are due `silence_ns` after the last sample at `stamp_ns`.

    `published_ns` is the stamp of the last estimate.
    """
    first = max(FIRST_STEP, (published_ns - stamp_ns) // PREDICTION_STEP_NS + 1)
    last = min(silence_ns // PREDICTION_STEP_NS, first + MAX_STEPS - 1)
    return [stamp_ns + step * PREDICTION_STEP_NS for step in range(first, last + 1)]
