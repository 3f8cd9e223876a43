# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Capture stamps of samples that were taken at even times: exact, jittered, late, of a busy machine, of a burst."""

from collections.abc import Callable

import numpy as np
from vsa_common.types import Array, Integers

SPACING_NS = 40_000  # between two samples of a backlog
JITTER_S = 1e-4  # standard deviation
DELAY_S = 3e-4  # mean of the exponential delay, as in the recording stiffness_steps_false_alarm
PAUSE_RATE_HZ = 1.0
PAUSE_S = (1e-3, 8e-3)  # shortest and longest pause of a busy machine

Stamps = Callable[[Integers, np.random.Generator], Integers]


def delivered(ready_ns: Integers) -> Integers:
    """Stamps of samples that are ready at `ready_ns` [ns] and arrive in order, SPACING_NS apart at least.

    >>> delivered(np.array([0, 100_000, 50_000])).tolist()
    [0, 100000, 140000]
    """
    backlog = SPACING_NS * np.arange(len(ready_ns))
    return np.asarray(backlog + np.maximum.accumulate(ready_ns - backlog))


def with_pauses(ready_ns: Integers, begins_ns: Integers, lengths_ns: Integers) -> Integers:
    """Times at which the samples are ready [ns] if nothing is received in the pauses; `ready_ns` increases."""
    late = ready_ns.copy()
    for begin, length in zip(begins_ns.tolist(), lengths_ns.tolist(), strict=True):
        paused = slice(*np.searchsorted(ready_ns, (begin, begin + length)))
        late[paused] = np.maximum(late[paused], begin + length)
    return late


def exact(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """The times of the samples."""
    return sent_ns


def jittered(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """Normal errors of JITTER_S."""
    return delivered(sent_ns + _ns(JITTER_S * random.standard_normal(len(sent_ns))))


def late(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """Exponential delays with the mean DELAY_S."""
    return delivered(sent_ns + _ns(DELAY_S * random.standard_exponential(len(sent_ns))))


def busy(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """Exponential delays, and pauses in which nothing is received: PAUSE_RATE_HZ, of lengths within PAUSE_S."""
    span = int(sent_ns[-1] - sent_ns[0])
    count = random.poisson(1e-9 * span * PAUSE_RATE_HZ)
    begins = sent_ns[0] + np.sort(random.integers(0, span + 1, count))
    return delivered(with_pauses(late(sent_ns, random), begins, _ns(random.uniform(*PAUSE_S, count))))


def _ns(seconds: Array) -> Integers:
    return np.round(1e9 * seconds).astype(np.int64)


STAMPS: dict[str, Stamps] = {"exact": exact, "jittered": jittered, "late": late, "busy": busy}
