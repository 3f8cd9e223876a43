# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Noise of force, force rate and deflection of a recording at rest or on a slow ramp (section VI)."""

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_rate.rate_filter import filtered_rate
from vsa_estimator.offline.allan import Allan, allan
from vsa_estimator.offline.instants import Timing, corrected
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.tuning.force_rate import RATE_FILTER
from vsa_estimator.tuning.offline import INDEPENDENT_TIMES, MAX_MISSING_SHARE, MIN_NOISE_SAMPLES, SETTLING_TIMES


def analyse(recording: Recording) -> tuple[dict[str, Allan], Timing]:
    """Allan deviations of force [N], force rate [N/s] and deflection [m], and the timing of the recording.

    A constant slope (a ramp) is removed first. Delays of the stamps are corrected; the samples then count as
    even, without interpolation, which would smooth their noise. The force rate is that of the paper's first-order
    filter, at times so far apart that the filter does not correlate them. Raises RecordingError for a recording that is
    too short or lacks too many samples.
    """
    even, timing = corrected(recording)
    time, force, deflection = even.stamp - even.stamp[0], even.force, even.deflection
    if len(time) < MIN_NOISE_SAMPLES:
        raise RecordingError(f"{recording.source}: expected at least {MIN_NOISE_SAMPLES} samples, found {len(time)}")
    step = timing.period
    if timing.missing > MAX_MISSING_SHARE * len(time):
        at = float(time[int(np.argmax(np.diff(time)))])  # stamps of a live system count from 1970
        text = f"gaps of {timing.missing} samples, the longest {at:.3f} s after the first; expected {step:.4g} s apart"
        raise RecordingError(f"{recording.source}: {text}")
    stride = max(1, round(INDEPENDENT_TIMES * RATE_FILTER / step))
    rate = filtered_rate(force, step)[round(SETTLING_TIMES * RATE_FILTER / step) :: stride]
    signals = {"force": (force, step), "force_rate": (rate, step * stride), "deflection": (deflection, step)}
    return {name: allan(_without_ramp(signal), 1.0 / period) for name, (signal, period) in signals.items()}, timing


def _without_ramp(signal: Array) -> Array:
    line = np.linspace(-1.0, 1.0, len(signal))
    return np.asarray(signal - signal.mean() - line * float(line @ signal) / float(line @ line))
