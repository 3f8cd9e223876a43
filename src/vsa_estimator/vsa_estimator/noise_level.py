"""White noise of a stream from its third differences: smooth motion leaves almost none of itself there."""

import numpy as np

_SPREAD = 20.0  # variance of a third difference of unit white noise: 1 + 9 + 9 + 1
_MEDIAN = 0.455  # median of chi-square with one degree of freedom
_OUTLIER = 9.0  # squared differences are capped at this multiple of the variance


class NoiseLevel:
    """Running standard deviation of one sample's white noise over the last `capacity` means of samples."""

    def __init__(self, given: float, least: float, capacity: int) -> None:
        """Start from the standard deviation `given`; the level stays within a quarter (and `least`) and four times."""
        self.std = given
        self._low = max(given / 4.0, least)
        self._high = 4.0 * given
        self._squares = np.zeros(capacity)
        self._count = 0
        self._last = np.zeros(4)
        self._run = 0

    def add(self, value: float, count: int = 1) -> None:
        """Take the mean of `count` samples, from an evenly sampled stretch."""
        last = self._last
        last[:3] = last[1:]
        last[3] = value
        self._run += 1
        if self._run >= 4:
            difference = last[3] - 3.0 * last[2] + 3.0 * last[1] - last[0]
            self._squares[self._count % self._squares.size] = count * difference * difference / _SPREAD
            self._count += 1

    def interrupt(self) -> None:
        """A sample is missing: differences must not reach across the gap."""
        self._run = 0

    def refresh(self) -> float:
        """Recompute `std` [same unit as the samples] from what is remembered."""
        squares = self._squares[: min(self._count, self._squares.size)]
        if squares.size >= 50:
            variance = float(np.median(squares)) / _MEDIAN + 1e-300
            for _ in range(4):
                variance = float(np.mean(np.minimum(squares, _OUTLIER * variance)))
            self.std = float(np.clip(np.sqrt(variance), self._low, self._high))
        return self.std
