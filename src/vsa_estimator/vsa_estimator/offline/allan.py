# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Allan deviation of a sensor's record: magnitude of its noise, and a test for white noise (section VI).

White noise has an Allan variance that falls as 1/tau; drift bends it up.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri  # scipy.stats takes a second to import
from vsa_common.types import Array
from vsa_estimator.tuning.offline import BAND_MARGIN, CONFIDENCE, MIN_MEANS, SLOPE_TOLERANCE

WHITE_SLOPE = -1.0  # of ln(Allan variance) over ln(tau), Fig. 6


@dataclass(frozen=True)
class Allan:
    """Allan deviation of one signal over averaging time."""

    tau: Array  # [s]
    deviation: Array  # in the signal's unit
    std: float  # of one sample's white noise
    slope: float  # of ln(Allan variance) over ln(tau)
    white: bool

    @property
    def classification(self) -> str:
        """Result of the test for white noise as text."""
        return "white" if self.white else "not white"

    @property
    def density(self) -> float:
        """Standard deviation of the mean over one second, if white."""
        return float(self.std * np.sqrt(self.tau[0]))


def allan(signal: Array, rate: float) -> Allan:
    """Allan deviation of an evenly sampled signal (`rate` in Hz) at averaging times of 1, 2, 4, ... samples.

    It is white where the Allan variance stays within the band of a finite white record at all averaging times, and
    falls with a slope near -1.
    """
    longest = max(1, len(signal) // MIN_MEANS)
    sizes = 2 ** np.arange(int(np.log2(longest)) + 1)
    tau, deviation = sizes / rate, overlapping_deviation(signal, rate, sizes)
    std = float(np.sqrt(0.5 * np.mean(np.diff(signal) ** 2)))
    freedom = np.maximum(len(signal) / sizes - 1.0, 1.0)
    x, y = np.log(tau), 2.0 * np.log(np.maximum(deviation, 1e-300))
    centred = x - np.average(x, weights=freedom)
    slope = float(np.sum(freedom * centred * y) / max(np.sum(freedom * centred**2), 1e-300))
    ratio = deviation**2 * (tau * rate) / max(std, 1e-150) ** 2
    low, high = (chdtri(freedom, above) / freedom for above in (0.5 + CONFIDENCE / 2.0, 0.5 - CONFIDENCE / 2.0))
    inside = bool(np.all((ratio > (1.0 - BAND_MARGIN) * low) & (ratio < (1.0 + BAND_MARGIN) * high)))
    white = std > 0.0 and inside and abs(slope - WHITE_SLOPE) < SLOPE_TOLERANCE
    # A white record determines its noise by all samples; another record by the shortest averaging time.
    return Allan(tau, deviation, float(np.std(signal)) if white else std, slope, white)


def overlapping_deviation(signal: Array, rate: float, sizes: NDArray[np.int64]) -> Array:
    """Overlapping Allan deviation of means over `sizes` samples, in the signal's unit.

    Means of m samples are differences of the signal's integral, NIST SP 1065, eq. (11); 2 m must not exceed the
    length. The mean is subtracted first: it has no effect and costs digits.
    """
    integral = np.concatenate([[0.0], np.cumsum(signal - np.mean(signal)) * (1.0 / rate)])
    differences = (integral[2 * m :] - 2.0 * integral[m:-m] + integral[: -2 * m] for m in sizes)
    return np.array(
        [np.sqrt(np.sum(d * d) / (2.0 * len(d))) / m * rate for m, d in zip(sizes, differences, strict=True)]
    )
