# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Diagnostics of the estimator of one transmission."""

import time
from collections.abc import Mapping

from vsa_common.ros.diagnostics import ERROR, OK, WARN, CounterDelta, Health, format_increases
from vsa_common.types import ResetReason, Status
from vsa_estimator.output.estimate import State

ESTIMATION = "estimation"  # task
NO_SAMPLES = "no samples"  # reason of STALE

_COUNTERS = ("samples_fused", "samples_dropped", "force_rejected", "deflection_rejected", "force_repeated")
_FAULTS = _COUNTERS[1:4]  # counters whose increase is a warning
_LEVEL = {Status.VALID: OK, Status.STALE: ERROR, Status.FAULT: ERROR}


class EstimatorHealth:
    """Level, text and key values from the state and the counters of the node."""

    def __init__(self) -> None:
        """Without increases of counters."""
        self._increases = CounterDelta()

    def assess(self, state: State, status: Status, refused: Mapping[str, int], counts: Mapping[str, int]) -> Health:
        """Health of the last second.

        `status` is the published one, `refused` the refused stamps by topic, `counts` further counters; an increase of
        `unpaired` among them is a warning.
        """
        values: dict[str, object] = {"status": status.name, "mode": state.mode.name} | {
            name: getattr(state, name) for name in _COUNTERS
        }
        values |= {**counts, "resets": state.reset_count, "last_reset": ResetReason(state.reset_reason).name}
        refusals = {f"refused_stamps {topic}": count for topic, count in refused.items()}
        values |= refusals
        faults = {name: getattr(state, name) for name in _FAULTS}
        faults |= {"unpaired": counts["unpaired"], "resets": state.reset_count}
        increases = self._increases.increases(faults | refusals, time.monotonic())
        wrong = [topic for topic in refused if f"refused_stamps {topic}" in increases]
        if wrong:
            return WARN, f"stamps of {' and '.join(wrong)} are zero or in the future", values
        if status is Status.STALE:
            return ERROR, NO_SAMPLES, values
        texts = [state.reason] if state.reason else []
        texts += [format_increases(increases)] if increases else []
        level = WARN if increases and status is Status.VALID else _LEVEL.get(status, WARN)
        return level, "; ".join(texts) or "active", values
