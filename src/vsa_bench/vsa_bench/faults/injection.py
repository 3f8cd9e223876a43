# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults in a simulated recording: failures of the rig's sensors, late stamps, a changed transmission."""

import math
from dataclasses import replace

import numpy as np
from vsa_bench.faults.cases import BURST_S, CHANGED, FAULTS, FaultCase
from vsa_bench.faults.motions import motion
from vsa_bench.faults.stamps import delivered, with_pauses
from vsa_common.types import Array, Integers
from vsa_simulator.faults.failure import parse
from vsa_simulator.faults.injection import Faults
from vsa_simulator.rig.config import SensorConfig
from vsa_simulator.rig.recording import Recording, Simulation, TransmissionVariant
from vsa_simulator.rig.sensors import ENCODER_COUNTS

BEGIN_S = 30.0  # of the fault
PAUSE_PERIOD_S = 0.2  # between two bursts of late stamps


def faulty(case: FaultCase, healthy: Simulation, seed: int, duration: float) -> tuple[Recording, Array]:
    """The recording with the fault, and the true stiffness [N/m] at its samples."""
    recording, stiffness = healthy.recording(seed), healthy.stiffness
    first = round(BEGIN_S * case.rate_hz)
    end = min(len(stiffness), first + round(min(case.duration, duration) * case.rate_hz))
    if case.fault in CHANGED:
        variant = TransmissionVariant(transmission=CHANGED[case.fault])
        changed = Simulation(variant, motion(case.motion, duration, seed), duration, case.rate_hz)
        other, after = changed.recording(seed), np.arange(len(stiffness)) >= first
        force = np.where(after, other.force, recording.force)
        deflection = np.where(after, other.deflection, recording.deflection)
        return Recording(recording.stamp_ns, force, deflection), np.where(after, changed.stiffness, stiffness)
    if not FAULTS[case.fault].failure:
        return replace(recording, stamp_ns=_late(recording.stamp_ns, first, end)), stiffness
    return with_failure(recording, FAULTS[case.fault].failure, range(first, end), seed), stiffness


def with_failure(recording: Recording, failure: str, samples: range, seed: int) -> Recording:
    """The recording with a failure of the rig's sensors at `samples`, in the syntax of `./vsa demo`.

    >>> made = Recording(np.arange(3), np.zeros(3), np.zeros(3))
    >>> with_failure(made, "force wrong -v 2", range(1, 2), 0).force.tolist()
    [0.0, 2.0, 0.0]
    """
    sensors, parsed = SensorConfig(), parse(failure)
    faults = Faults(round(_rate(recording)), sensors, seed)
    faults.inject(parsed, samples.start)
    name = "force" if parsed.component == "force" else "deflection"
    unit = 1.0 if parsed.component == "force" else sensors.deflection_resolution
    values = getattr(recording, name).copy()
    for k in samples:
        reading = faults.reading(parsed.component, 1, values[k] / unit, k)
        values[k] = unit * (_signed(reading) if parsed.component == "encoder" else reading)
    return replace(recording, **{name: values})


def _signed(counts: float) -> float:
    """Encoder counts about zero."""
    return (counts + ENCODER_COUNTS // 2) % ENCODER_COUNTS - ENCODER_COUNTS // 2


def _rate(recording: Recording) -> float:
    period = 1e-9 * float(np.median(np.diff(recording.stamp_ns)))
    return 1.0 / period if period > 0.0 and math.isfinite(period) else 1.0


def _late(stamp_ns: Integers, first: int, end: int) -> Integers:
    """Stamps of samples `first` to `end` in bursts: all samples of BURST_S are received at its end."""
    span = 1e-9 * float(stamp_ns[end - 1] - stamp_ns[first])
    offsets = np.arange(0.0, max(span - BURST_S, 0.0) + 1e-9, PAUSE_PERIOD_S)
    begins = stamp_ns[first] + np.round(1e9 * offsets).astype(np.int64)
    return delivered(with_pauses(stamp_ns, begins, np.full(len(begins), round(1e9 * BURST_S))))
