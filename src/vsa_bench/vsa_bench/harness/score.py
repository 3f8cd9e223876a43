# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Counts and delays of a run, from the recorded messages."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"p50": 0.5, "p99": 0.99, "p999": 0.999, "max": 1.0}
BACKLOG_MS = 5.0  # permitted growth of the median delay between the first and the last fifth of a run


@dataclass(frozen=True)
class JointRecord:
    """One joint: samples that its rig sent; joint messages as rows of both sides' stamps and arrival [ns]; the
    number of each sample by its capture stamp [ns], as the driver publishes it for either side."""

    sent: int
    joints: NDArray[np.int64]
    first: Mapping[int, int]
    second: Mapping[int, int]


@dataclass(frozen=True)
class Score:
    """The figures of a run, all joints together."""

    sent: int
    fused: int
    latency_ms: dict[str, float | None]
    sustained: bool

    @property
    def lost(self) -> int:
        """Samples that were sent and are in no joint message."""
        return self.sent - self.fused


def score(joints: Sequence[JointRecord]) -> Score:
    """A sample counts as fused when one joint message carries the stamps of both its frames.

    Sustained: no sample is lost and the delay does not grow.
    """
    delays = [_delays(joint) for joint in joints]
    together = np.concatenate([list(one.values()) for one in delays]) if delays else np.empty(0)
    latency = quantiles(together)
    sent, fused = sum(joint.sent for joint in joints), sum(map(len, delays))
    return Score(sent, fused, latency, 0 < sent == fused and not any(map(_grew, delays)))


def quantiles(milliseconds: NDArray[np.float64]) -> dict[str, Any]:
    """QUANTILES of delays [ms]; None for each where there is no delay."""
    if not milliseconds.size:
        return dict.fromkeys(QUANTILES)
    return {name: round(float(np.quantile(milliseconds, q)), 3) for name, q in QUANTILES.items()}


def _delays(joint: JointRecord) -> dict[int, float]:
    """Delay from the capture of the later frame to the first arrival [ms], by the number of the sample."""
    delays: dict[int, float] = {}
    for first_ns, second_ns, arrival_ns in joint.joints.tolist():
        number = joint.first.get(first_ns)
        if number is not None and number == joint.second.get(second_ns) and number not in delays:
            delays[number] = 1e-6 * (arrival_ns - max(first_ns, second_ns))
    return delays


def _grew(delays: Mapping[int, float]) -> bool:
    fifth = max(len(delays) // 5, 1)
    in_order = [delays[number] for number in sorted(delays)]
    return bool(np.median(in_order[-fifth:]) > np.median(in_order[:fifth]) + BACKLOG_MS)
