# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults in a simulated recording: failures of the rig's sensors, late stamps, a changed transmission."""

from dataclasses import replace

import numpy as np
from vsa_bench.faults.cases import BURST_S, CHANGED, DEFAULT, FAULTS, TRANSMISSIONS, FaultCase
from vsa_bench.faults.motions import Simulated, simulate
from vsa_common.types import Integers
from vsa_simulator.faults.recorded import with_failure, with_pauses
from vsa_simulator.rig.recording import Recording

BEGIN_S = 30.0  # of the fault
PAUSE_PERIOD_S = 0.2  # between two bursts of late stamps


def faulty(case: FaultCase, seed: int, duration: float, transmission: str = DEFAULT) -> Simulated:
    """A recording of `duration` [s] of one of TRANSMISSIONS, with the fault from BEGIN_S on."""
    variant = TRANSMISSIONS[transmission]
    healthy = simulate(variant, case.motion, duration, case.rate_hz, seed)
    recording, count = healthy.recording, len(healthy.stiffness)
    first = round(BEGIN_S * case.rate_hz)
    end = min(count, first + round(min(case.duration, duration) * case.rate_hz))
    if case.fault in CHANGED:
        changed = replace(variant, transmission=CHANGED[case.fault])
        return _changed(healthy, simulate(changed, case.motion, duration, case.rate_hz, seed), first)
    if FAULTS[case.fault].failure:
        return healthy._replace(recording=_failing(recording, case, range(first, end), seed))
    return healthy._replace(recording=replace(recording, stamp_ns=_late(recording.stamp_ns, first, end)))


def _failing(recording: Recording, case: FaultCase, samples: range, seed: int) -> Recording:
    """The recording with the sensor failure of a case at `samples`."""
    failure, rate_hz = FAULTS[case.fault].failure, case.rate_hz
    if failure.startswith("force"):
        return replace(recording, force=with_failure(recording.force, failure, samples, rate_hz, seed))
    return replace(recording, deflection=with_failure(recording.deflection, failure, samples, rate_hz, seed))


def _changed(one: Simulated, other: Simulated, first: int) -> Simulated:
    """`one` up to the sample `first`, then `other`."""
    after = np.arange(len(one.stiffness)) >= first
    force = np.where(after, other.recording.force, one.recording.force)
    deflection = np.where(after, other.recording.deflection, one.recording.deflection)
    stiffness = np.where(after, other.stiffness, one.stiffness)
    return Simulated(Recording(one.recording.stamp_ns, force, deflection), stiffness, one.start)


def _late(stamp_ns: Integers, first: int, end: int) -> Integers:
    """Stamps of samples `first` to `end` in bursts: all samples of BURST_S are received at its end."""
    span = 1e-9 * float(stamp_ns[end - 1] - stamp_ns[first])
    offsets = np.arange(0.0, max(span - BURST_S, 0.0) + 1e-9, PAUSE_PERIOD_S)
    begins = stamp_ns[first] + np.round(1e9 * offsets).astype(np.int64)
    return with_pauses(stamp_ns, begins, np.full(len(begins), round(1e9 * BURST_S)))
