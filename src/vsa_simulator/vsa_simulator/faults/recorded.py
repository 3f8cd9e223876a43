# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Failures in a recorded sensor signal, and stamps of samples that are late."""

import numpy as np
from vsa_common.types import Array, Integers
from vsa_simulator.faults.failure import parse
from vsa_simulator.faults.injection import Faults
from vsa_simulator.rig.config import SensorConfig
from vsa_simulator.rig.sensors import ENCODER_COUNTS

SPACING_NS = 40_000  # between two samples of a backlog
DELAY_S = 3e-4  # mean of the exponential delay


def with_failure(values: Array, failure: str, samples: range, rate_hz: int, seed: int) -> Array:
    """Measured forces [N] or deflections [m] with a failure of their sensor at `samples`, as Failure writes it.

    >>> with_failure(np.zeros(3), "force wrong -v 2", range(1, 2), 100, 0).tolist()
    [0.0, 2.0, 0.0]
    """
    sensors, parsed = SensorConfig(), parse(failure)
    faults = Faults(rate_hz, sensors, seed)
    faults.inject(parsed, samples.start)
    encoder = parsed.component == "encoder"
    unit = sensors.deflection_resolution if encoder else 1.0
    result = values.copy()
    for k in samples:
        reading = faults.reading(parsed.component, 1, float(values[k]) / unit, k)
        result[k] = unit * (_signed(reading) if encoder else reading)
    return result


def _signed(counts: float) -> float:
    """Encoder counts about zero."""
    half = ENCODER_COUNTS // 2
    return (counts + half) % ENCODER_COUNTS - half


def delivered(ready_ns: Integers) -> Integers:
    """Stamps of samples that are ready at `ready_ns` [ns] and arrive in order, SPACING_NS apart at least.

    >>> delivered(np.array([0, 100_000, 50_000])).tolist()
    [0, 100000, 140000]
    """
    backlog = SPACING_NS * np.arange(len(ready_ns))
    return np.asarray(backlog + np.maximum.accumulate(ready_ns - backlog))


def delayed(sent_ns: Integers, random: np.random.Generator) -> Integers:
    """Stamps [ns] with exponential delays of the mean DELAY_S."""
    return delivered(sent_ns + np.round(1e9 * DELAY_S * random.standard_exponential(len(sent_ns))).astype(np.int64))


def with_pauses(stamp_ns: Integers, begins_ns: Integers, lengths_ns: Integers) -> Integers:
    """Stamps [ns] of samples that are received after the pause if they are ready in one; `stamp_ns` increases."""
    ready = stamp_ns.copy()
    for begin, length in zip(begins_ns.tolist(), lengths_ns.tolist(), strict=True):
        paused = slice(*np.searchsorted(stamp_ns, (begin, begin + length)))
        ready[paused] = np.maximum(ready[paused], begin + length)
    return delivered(ready)
