# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Raw signal to SI: scale, offset, sign, and the tare of a force sensor."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean, pstdev

from vsa_driver.tuning import TARE_SAMPLES


class TareError(ValueError):
    """A force sensor cannot be tared; the text states the reason."""


@dataclass(frozen=True)
class Calibration:
    """Affine map from a signal to a quantity in SI: `gain * value + offset`.

    >>> Calibration.of(scale=2.0, offset=0.5, reverse=True)(10.0)
    -19.5
    """

    gain: float
    offset: float

    @classmethod
    def of(cls, scale: float, offset: float, reverse: bool) -> "Calibration":
        """Calibration of the parameters; `reverse` changes the sign of the signal, not of the offset."""
        return cls(-scale if reverse else scale, offset)

    def __call__(self, value: float) -> float:
        return self.gain * value + self.offset

    def inverse(self, quantity: float) -> float:
        """Value of the signal that gives `quantity`."""
        return (quantity - self.offset) / self.gain


class Tare:
    """Subtracts an offset [N] from every force; `take_tares` sets it to the mean of the last forces.

    The mean is of consecutive samples: it restarts where the stamps of two samples are more than `max_gap_ns` apart.
    """

    def __init__(self, max_std: float, max_gap_ns: int) -> None:
        self.offset = 0.0  # [N]
        self._max_std = max_std  # [N]
        self._max_gap_ns = max_gap_ns
        self._stamp_ns = 0
        self._recent: deque[float] = deque(maxlen=TARE_SAMPLES)

    def set_limits(self, max_std: float, max_gap_ns: int) -> None:
        """Apply another greatest standard deviation [N] and gap [ns]."""
        self._max_std, self._max_gap_ns = max_std, max_gap_ns

    def add(self, stamp_ns: int, force: float) -> float:
        """Take a calibrated force and return the tared one [N]."""
        if not 0 <= stamp_ns - self._stamp_ns <= self._max_gap_ns:  # negative: the clock was set back
            self.restart()
        self._stamp_ns = stamp_ns
        self._recent.append(force)
        return force - self.offset

    def restart(self) -> None:
        """Discard the collected forces; the offset stays."""
        self._recent.clear()

    def mean(self) -> float:
        """Mean of the last forces [N]. Raises TareError if they vary or are too few."""
        if len(self._recent) < TARE_SAMPLES:
            raise TareError(f"{len(self._recent)} of {TARE_SAMPLES} consecutive samples so far; repeat the call")
        recent = list(self._recent)
        std = pstdev(recent)
        if std > self._max_std:
            raise TareError(f"the force is not stationary: standard deviation {std:.3g} N, limit {self._max_std:g} N")
        return fmean(recent)


def take_tares(tares: Sequence[Tare]) -> list[float]:
    """Set the offset of each to the mean of its last forces, or of none; offsets [N]. Raises TareError like `mean`."""
    offsets = [tare.mean() for tare in tares]
    for tare, offset in zip(tares, offsets, strict=True):
        tare.offset = offset
    return offsets
