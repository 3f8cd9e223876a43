"""From a signal's value to SI: scale, offset, sign, and the tare of a force sensor."""

from collections import deque
from dataclasses import dataclass
from statistics import fmean, pstdev

TARE_SAMPLES = 200


class TareError(ValueError):
    """A force sensor cannot be tared now; the text says why."""


@dataclass(frozen=True)
class Calibration:
    """A straight line from a signal to a quantity in SI: `gain * value + offset`.

    >>> Calibration.of(scale=2.0, offset=0.5, reverse=True)(10.0)
    -19.5
    """

    gain: float
    offset: float

    @classmethod
    def of(cls, scale: float, offset: float, reverse: bool) -> "Calibration":
        """From the words of the parameters; `reverse` turns the sign of the signal, not of the offset."""
        return cls(-scale if reverse else scale, offset)

    def __call__(self, value: float) -> float:
        return self.gain * value + self.offset

    def inverse(self, quantity: float) -> float:
        """Value of the signal that gives `quantity`."""
        return (quantity - self.offset) / self.gain


class Tare:
    """Takes the mean of the last forces as zero."""

    def __init__(self, spread: float) -> None:
        self.offset = 0.0  # subtracted from every force [N]
        self._spread = spread
        self._recent: deque[float] = deque(maxlen=TARE_SAMPLES)

    def add(self, force: float) -> float:
        """The tared force [N] of a calibrated one."""
        self._recent.append(force)
        return force - self.offset

    def forget(self) -> None:
        """Start collecting anew, after a silence."""
        self._recent.clear()

    def take(self) -> float:
        """Make the last forces zero and return the new offset [N]. Raises TareError where they do not rest."""
        if len(self._recent) < TARE_SAMPLES:
            raise TareError(f"{len(self._recent)} of {TARE_SAMPLES} samples so far; wait a moment")
        recent = list(self._recent)
        spread = pstdev(recent)
        if spread > self._spread:
            raise TareError(f"the force moves, standard deviation {spread:.3g} N over the limit of {self._spread:g} N")
        self.offset = fmean(recent)
        return self.offset
