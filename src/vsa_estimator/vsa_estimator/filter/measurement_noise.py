"""White noise of a stream from its third differences: smooth motion leaves almost none of itself there."""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array

_SPREAD = 20.0  # variance of a third difference of unit white noise: 1 + 9 + 9 + 1
_MEDIAN = 0.455  # median of chi-square with one degree of freedom
_OUTLIER = 4.0  # squared differences are capped at this multiple of the variance ...
_CAPPED = 0.9205  # ... and then have this mean, if they are Gaussian and the variance is 1
RUN, TAKEN = 3, 4


@compiled
def take_mean(memory: Array, squares: Array, mean: float, count: int) -> None:
    """Take the mean of `count` samples. memory: the last three means, how many are in a row, squares so far."""
    difference = mean - 3.0 * memory[2] + 3.0 * memory[1] - memory[0]
    memory[0], memory[1], memory[2] = memory[1], memory[2], mean
    memory[RUN] += 1.0
    if memory[RUN] >= 4.0:
        squares[int(memory[TAKEN]) % squares.size] = count * difference * difference / _SPREAD
        memory[TAKEN] += 1.0


@compiled
def robust_mean(squares: Array) -> float:
    """Mean of squared Gaussian values, of which outliers count for little."""
    mean = float(np.median(squares)) / _MEDIAN + 1e-300
    for _ in range(4):
        most, total = _OUTLIER * mean, 0.0
        for square in squares:
            total += min(square, most)
        mean = total / (_CAPPED * squares.size)
    return mean


class NoiseLevel:
    """Running standard deviation of one sample's white noise over the last `capacity` means of samples."""

    def __init__(self, given: float, least: float, capacity: int) -> None:
        """Start from the standard deviation `given`; the level stays within a quarter (and `least`) and four times."""
        self.std = given
        self._low = max(given / 4.0, least)
        self._high = 4.0 * given
        self._squares = np.zeros(capacity)
        self._memory = np.zeros(5)

    def add(self, value: float, count: int = 1) -> None:
        """Take the mean of `count` samples, from an evenly sampled stretch."""
        take_mean(self._memory, self._squares, value, count)

    def interrupt(self) -> None:
        """A sample is missing: differences must not reach across the gap."""
        self._memory[RUN] = 0.0

    def refresh(self) -> float:
        """Recompute `std` [same unit as the samples] from what is remembered."""
        squares = self._squares[: int(self._memory[TAKEN])]
        if squares.size >= 50:
            self.std = float(np.clip(np.sqrt(robust_mean(squares)), self._low, self._high))
        return self.std
