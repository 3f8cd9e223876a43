# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of the fault detection: delay, isolation, undetected error, recovery, rate of false alarms."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri  # scipy.stats takes a second to import
from vsa_bench.faults.hypotheses import NOT_DETECTED, NOT_ISOLATED, hypothesis
from vsa_bench.faults.observation import Report
from vsa_common.types import Array, Booleans

BEFORE_S = 1.0  # a text that is active within this time before a fault does not detect it
VALID_FOR_S = 1.0  # stiffness counts as valid again once it stays valid for this time
SAME_ALARM_S = 1.0  # detections that follow each other within this time are one alarm
CONFIDENCE = 0.95


class Detection(NamedTuple):
    """First report of a fault, and the hypothesis that the reports name first; times after the fault's begin [s]."""

    delay: float | None
    named: str
    named_after: float | None


def detect(reports: Sequence[Report], begin: float) -> Detection:
    """Detection of a fault that begins at `begin` [s] by texts that were not active in the second before."""
    before = frozenset().union(*(texts for time, texts in reports if begin - BEFORE_S <= time < begin))
    new = [(time - begin, texts - before) for time, texts in reports if time >= begin and texts - before]
    if not new:
        return Detection(None, NOT_DETECTED, None)
    named = ((after, sorted({hypothesis(text) for text in texts} - {NOT_ISOLATED})) for after, texts in new)
    after, names = next(((after, names) for after, names in named if names), (None, [NOT_ISOLATED]))
    return Detection(new[0][0], names[0], after)


def longest(flags: Booleans, period: float) -> float:
    """Duration [s] of the longest run of true flags, one each `period` [s].

    >>> longest(np.array([True, False, True, True, False]), 0.5)
    1.0
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    return float(max(np.diff(edges)[::2], default=0)) * period


def time_to_valid(time: Array, valid: Booleans, begin: float) -> float | None:
    """Time after `begin` [s] from which on stiffness stays valid for VALID_FOR_S; None if it does not."""
    late = time >= begin
    time, valid = time[late], valid[late]
    changes = np.flatnonzero(np.diff(valid.astype(np.int8), prepend=0))
    if len(changes) % 2:
        changes = np.append(changes, len(valid) - 1)
    for first, end in changes.reshape(-1, 2):
        if time[end] - time[first] >= VALID_FOR_S:
            return float(max(0.0, time[first] - begin))
    return None


def alarms(time: Array, degraded: Booleans, resets: Booleans) -> list[float]:
    """Begin [s] of each alarm: status DEGRADED or a reset by innovation or deflection."""
    flagged = time[degraded | resets]
    return flagged[np.diff(flagged, prepend=-np.inf) > SAME_ALARM_S].tolist()


def poisson_interval(count: int, hours: float) -> tuple[float, float]:
    """Exact interval of the rate per hour [1/h] of a Poisson process with `count` events (Garwood 1936).

    >>> [round(one, 4) for one in poisson_interval(0, 1.0)]
    [0.0, 3.6889]
    """
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.5 * float(chdtri(2 * count, 1.0 - tail)) if count else 0.0
    return low / hours, 0.5 * float(chdtri(2 * count + 2, tail)) / hours


def isolation_matrix(named: Iterable[tuple[str, str]]) -> dict[str, dict[str, int]]:
    """Runs by fault and by the hypothesis that was named first, from pairs of both."""
    result: dict[str, dict[str, int]] = {}
    for (fault, name), count in Counter(named).items():
        result.setdefault(fault, {})[name] = count
    return result
