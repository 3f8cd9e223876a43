"""Noise of force, force rate and deflection of a recording at rest or on a slow ramp (section VI)."""

import numpy as np
from vsa_common.types import Array
from vsa_estimator.force_rate.rate_filter import filtered_rate
from vsa_estimator.offline.allan import Allan, allan
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.tuning.force_rate import RATE_FILTER
from vsa_estimator.tuning.offline import INDEPENDENT_TIMES, MIN_NOISE_SAMPLES, SETTLING_TIMES


def analyse(recording: Recording) -> dict[str, Allan]:
    """Allan deviations of force [N], force rate [N/s] and deflection [m]; a constant slope (a ramp) is removed first.

    The force rate is that of the paper's first-order filter, at times so far apart that the filter does not correlate
    them. Raises RecordingError for a recording that is too short or too uneven.
    """
    finite = np.isfinite(recording.stamp) & np.isfinite(recording.force) & np.isfinite(recording.deflection)
    time, force, deflection = (a[finite] for a in (recording.stamp, recording.force, recording.deflection))
    steps = np.diff(time)
    if len(time) < MIN_NOISE_SAMPLES:
        raise RecordingError(f"{recording.source}: expected at least {MIN_NOISE_SAMPLES} samples, found {len(time)}")
    step = float(np.median(steps))
    uneven = np.flatnonzero(np.abs(steps - step) > 0.5 * step)
    if step <= 0.0 or len(uneven):
        line = int(np.flatnonzero(finite)[uneven[0] + 1]) + 2 if len(uneven) else 3
        raise RecordingError(f"{recording.source}: line {line}: expected samples {step:g} s apart")
    stride = max(1, round(INDEPENDENT_TIMES * RATE_FILTER / step))
    rate = filtered_rate(force, step)[round(SETTLING_TIMES * RATE_FILTER / step) :: stride]
    signals = {"force": (force, step), "force_rate": (rate, step * stride), "deflection": (deflection, step)}
    return {name: allan(_without_ramp(signal), 1.0 / period) for name, (signal, period) in signals.items()}


def _without_ramp(signal: Array) -> Array:
    line = np.linspace(-1.0, 1.0, len(signal))
    return np.asarray(signal - signal.mean() - line * float(line @ signal) / float(line @ line))
