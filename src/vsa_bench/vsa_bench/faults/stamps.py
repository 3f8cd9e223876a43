# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Capture stamps of samples that were taken at even times: exact, jittered, late, of a busy machine."""

from collections.abc import Callable

import numpy as np
from vsa_common.types import Integers
from vsa_simulator.faults.recorded import delayed, delivered, with_pauses

JITTER_S = 1e-4  # standard deviation
PAUSE_RATE_HZ = 1.0
PAUSE_S = (1e-3, 8e-3)  # shortest and longest pause of a busy machine

Stamps = Callable[[Integers, np.random.Generator], Integers]


def exact(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """The times of the samples."""
    return sent_ns


def jittered(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """Normal errors of JITTER_S."""
    return delivered(sent_ns + np.round(1e9 * JITTER_S * random.standard_normal(len(sent_ns))).astype(np.int64))


def busy(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """Exponential delays, and pauses in which nothing is received: PAUSE_RATE_HZ, of lengths within PAUSE_S."""
    span = int(sent_ns[-1] - sent_ns[0])
    count = random.poisson(1e-9 * span * PAUSE_RATE_HZ)
    begins = sent_ns[0] + np.sort(random.integers(0, span + 1, count))
    lengths = np.round(1e9 * random.uniform(*PAUSE_S, count)).astype(np.int64)
    return with_pauses(delayed(sent_ns, random), begins, lengths)


STAMPS: dict[str, Stamps] = {"exact": exact, "jittered": jittered, "late": delayed, "busy": busy}
