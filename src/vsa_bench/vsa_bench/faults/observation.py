# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The estimator on a recording: its estimates, and its fault texts over time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from vsa_bench.estimation.score import WRONG_SHARE, WRONG_STDS
from vsa_common.config.configuration import build
from vsa_common.types import Array, Booleans, Integers, ResetReason, Status
from vsa_estimator.filter.records import Record
from vsa_estimator.formulations import create_estimator
from vsa_estimator.output.estimate import State
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.rig.recording import START_NS, Recording

Report = tuple[float, frozenset[str]]  # time of a reading [s], texts that are active then


@dataclass(frozen=True)
class Observation:
    """Used samples of a run: (samples,) stamps since the start [s], ROW, index in the recording; fault texts."""

    time: Array
    rows: Record
    index: Integers
    reports: tuple[Report, ...]

    @property
    def valid(self) -> Booleans:
        """Whether stiffness is valid, (samples,)."""
        return np.asarray(self.rows["stiffness_valid"] > 0)

    @property
    def degraded(self) -> Booleans:
        """Whether the status is DEGRADED: a fault is active, or updates are suspended, (samples,)."""
        return np.asarray(self.rows["status"] == Status.DEGRADED)

    @property
    def fault_resets(self) -> Booleans:
        """Whether a reset with reason INNOVATION or DEFLECTION is counted, (samples,)."""
        counted = np.diff(self.rows["reset_count"], prepend=0.0) > 0
        reason = np.isin(self.rows["reset_reason"], (ResetReason.INNOVATION, ResetReason.DEFLECTION))
        return np.asarray(counted & reason)

    def wrong(self, stiffness: Array) -> Booleans:
        """Whether stiffness is valid and off the true one of the recording by 4 standard deviations and 1 %."""
        true = stiffness[self.index]
        error = np.abs(self.rows["stiffness"] - true)
        exceeds = (error > WRONG_STDS * np.sqrt(self.rows["stiffness_variance"])) & (error > WRONG_SHARE * true)
        return np.asarray(self.valid & exceeds)


def observe(recording: Recording, parameters: Mapping[str, object], period: float, rate_hz: int) -> Observation:
    """Run the estimator in the default configuration but for `parameters`; texts are read each `period` [s].

    They are read where the status was not VALID since the last reading: no text is active otherwise.
    """
    estimator = create_estimator(build(EstimatorConfig, parameters))
    width = max(1, round(period * rate_hz))
    parts, reports = [], []
    for first in range(0, len(recording.stamp_ns), width):
        part = slice(first, first + width)
        rows = estimator.add_many(recording.stamp_ns[part], recording.force[part], recording.deflection[part])
        parts.append(rows)
        if (rows["status"] != Status.VALID).any():
            reports.append((1e-9 * float(recording.stamp_ns[part][-1] - START_NS), fault_texts(estimator.state())))
    rows = np.concatenate(parts)
    index = np.flatnonzero(np.isfinite(rows["status"]))
    time: Array = np.asarray(1e-9 * (recording.stamp_ns[index] - START_NS), dtype=np.float64)
    return Observation(time, rows[index], index, tuple(one for one in reports if one[1]))


def fault_texts(state: State) -> frozenset[str]:
    """Texts of the active faults; `reason` is a line of `observability` where there is none."""
    return frozenset() if state.reason in ("", *state.observability) else frozenset(state.reason.split("; "))
