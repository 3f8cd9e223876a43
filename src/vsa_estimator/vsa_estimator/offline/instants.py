# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Instants of recorded samples by the live estimator's timestamp correction, and how uneven the stamps were."""

from dataclasses import dataclass, replace

import numpy as np
from vsa_common.stamps import NANOSECONDS
from vsa_common.types import Booleans, Integers
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.preprocessing.timestamp_filter import corrected_stamp, initial_timestamps

UNEVEN_SHARE = 0.01  # of the period: below this deviation of the intervals stamps count as even
MISSING_PERIODS = 1.5  # interval from which samples are missing in between


@dataclass(frozen=True)
class Timing:
    """Intervals of the stamps of a recording, and what the correction changed."""

    period: float  # mean interval of the corrected instants without gaps [s]
    jitter: float  # standard deviation of the intervals between stamps [s]
    longest: float  # longest interval between stamps [s]
    delay: float  # greatest correction [s]
    missing: int  # samples that fit into the gaps of the corrected instants: lost ones, or later than the clock follows

    def __str__(self) -> str:
        """One line for a reader.

        >>> str(Timing(0.002, 0.0005, 0.011, 0.009, 3))
        'stamps 2 ms apart, standard deviation 0.5 ms, longest 11 ms; corrected by up to 9 ms; gaps of 3 samples'
        """
        line = f"stamps {1e3 * self.period:.4g} ms apart"
        if self.jitter <= UNEVEN_SHARE * self.period:
            line += ", even"
        else:
            line += f", standard deviation {1e3 * self.jitter:.2g} ms, longest {1e3 * self.longest:.4g} ms"
        line += f"; corrected by up to {1e3 * self.delay:.3g} ms" if self.delay > 0.0 else ""
        return line + (f"; gaps of {self.missing} samples" if self.missing else "")


def corrected(recording: Recording) -> tuple[Recording, Timing]:
    """A recording with the corrected instants as stamps, and its timing.

    Samples that are not finite, late or repeated are left out, as in the live estimator. Raises RecordingError for
    fewer than two samples.
    """
    used = _increasing(recording)
    if np.count_nonzero(used) < 2:
        raise RecordingError(f"{recording.source}: expected at least 2 usable samples, found {np.count_nonzero(used)}")
    stamp_ns, deflection = recording.stamp_ns[used], recording.deflection[used]
    timestamps = initial_timestamps()[0]
    samples = zip(stamp_ns.tolist(), deflection.tolist(), strict=True)
    instant_ns = np.array([corrected_stamp(timestamps, *sample) for sample in samples], np.int64)
    stamp = recording.stamp[used] - (stamp_ns - instant_ns) / NANOSECONDS
    better = replace(recording, stamp_ns=instant_ns, stamp=stamp, force=recording.force[used], deflection=deflection)
    return better, _timing(stamp_ns, instant_ns)


def _timing(stamp_ns: Integers, instant_ns: Integers) -> Timing:
    steps, raw = np.diff(instant_ns) / NANOSECONDS, np.diff(stamp_ns) / NANOSECONDS
    typical = float(np.median(steps))
    regular = steps[steps < MISSING_PERIODS * typical]
    gaps = steps[steps >= MISSING_PERIODS * typical]
    return Timing(
        period=float(regular.mean()) if len(regular) else typical,
        jitter=float(raw.std()),
        longest=float(raw.max()),
        delay=float(np.max(stamp_ns - instant_ns)) / NANOSECONDS,
        missing=int(np.sum(np.round(gaps / typical) - 1.0)),
    )


def _increasing(recording: Recording) -> Booleans:
    """Finite samples with a stamp after all earlier ones."""
    finite = np.isfinite(recording.stamp) & np.isfinite(recording.force) & np.isfinite(recording.deflection)
    usable = np.where(finite, recording.stamp_ns, np.iinfo(np.int64).min)
    newest = np.maximum.accumulate(usable)
    return np.asarray(finite & (np.r_[True, usable[1:] > newest[:-1]] if len(usable) else finite))
