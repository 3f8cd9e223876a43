"""Deflections that the gate rejects one after another: an encoder that jumped, or a rod that nobody believed."""

import math

import numpy as np

GROWTH = 1.2  # from one rejected offset to the next, three in a row: a rod that sets off
BACK = 0.5  # share of what was rejected, within which a deflection is back where it was expected
ENOUGH, ALIKE = 6, 0.25  # rejected offsets in a row, and their scatter as a share of the jump, that prove one
STAYED = 0.5  # share of the elastic force of a move, under which the force says that there was none


class OffsetHypothesis:
    """The rejected offsets since the last accepted deflection, and what of the force the expected place leaves open."""

    def __init__(self) -> None:
        """Nothing rejected yet."""
        self._rejected: list[tuple[float, float, float]] = []

    def reject(self, deflection: float, offset: float, unexplained: float) -> None:
        """A deflection [m], so far off from where the filter expected it [m]; the force by so much [N] or NaN."""
        self._rejected.append((offset, unexplained, deflection))

    def clear(self) -> None:
        """All is well, or the motion has a gap."""
        self._rejected.clear()

    def is_repeated(self, offset: float) -> bool:
        """Whether a deflection so far off [m] repeats what was rejected: that time goes by is no proof."""
        return bool(self._rejected) and abs(offset) > BACK * abs(self.size)

    @property
    def is_motion_onset(self) -> bool:
        """Whether the offsets grow from one to the next: nothing has jumped, the rod moves."""
        if len(self._rejected) < 3:
            return False
        first, second, third = (offset for offset, *_ in self._rejected[-3:])
        return second / first > GROWTH and third / second > GROWTH

    @property
    def is_confirmed(self) -> bool:
        """Whether several are off by the same: those of a noisy encoder are not, nor those of one that stands still."""
        offsets, alike = [offset for offset, *_ in self._rejected[:ENOUGH]], ALIKE * abs(self.size)
        if len(offsets) < ENOUGH or offsets[0] * self.size < 0.0 or float(np.std(offsets[1:])) > alike:
            return False
        (first, _, began), (last, _, ended) = self._rejected[1], self._rejected[-1]
        return abs(last - first) < max(abs(ended - began), alike)

    @property
    def size(self) -> float:
        """By how much the encoder jumped [m]."""
        return float(np.median([offset for offset, *_ in self._seen]))

    @property
    def variance(self) -> float:
        """Of the size, by the scatter of what was rejected [m^2]."""
        return float(np.var([offset for offset, *_ in self._seen]))

    def supported_by_force(self, elastic: float) -> bool:
        """Whether the force says that the rod did not move; `elastic` is what moving would cost [N]."""
        heard = [force for _, force, _ in self._seen if not math.isnan(force)]
        return not heard or abs(heard[0] / elastic) < STAYED  # an absent force says nothing against it

    @property
    def _seen(self) -> list[tuple[float, float, float]]:
        # the first may be half of one place, half of the other; later ones suffer from the prediction
        return self._rejected[1:4] or self._rejected
