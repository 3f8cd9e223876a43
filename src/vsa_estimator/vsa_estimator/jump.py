"""Deflections that the gate rejects one after another: an encoder that jumped, or a rod that nobody believed."""

import math

import numpy as np
from vsa_estimator.blocks import Block

GROWTH = 1.2  # from one rejected offset to the next, three in a row: a rod that sets off
STAYED = 0.5  # share of the elastic force of a move, under which the force says that there was none


class Jump:
    """The rejected offsets since the last accepted deflection, and the force before."""

    def __init__(self) -> None:
        """Nothing rejected yet."""
        self._rejected: list[tuple[float, float]] = []
        self._force = math.nan

    def reject(self, block: Block, offset: float) -> None:
        """The deflection is off by so much from where the filter expected it [m]."""
        self._rejected.append((offset, block.force if block.forces else math.nan))

    def accept(self, block: Block) -> None:
        """All is well."""
        self._rejected.clear()
        if block.forces:
            self._force = block.force

    def clear(self) -> None:
        """The motion has a gap."""
        self._rejected.clear()

    @property
    def sets_off(self) -> bool:
        """Whether the offsets grow from one to the next: nothing has jumped, the rod moves."""
        if len(self._rejected) < 3:
            return False
        first, second, third = (offset for offset, _ in self._rejected[-3:])
        return second / first > GROWTH and third / second > GROWTH

    @property
    def size(self) -> float:
        """By how much the encoder jumped [m]."""
        return float(np.median([offset for offset, _ in self._seen]))

    @property
    def variance(self) -> float:
        """Of the size, by the scatter of what was rejected [m^2]."""
        return float(np.var([offset for offset, _ in self._seen]))

    def stayed(self, elastic: float) -> bool:
        """Whether the force, just after it, says that the rod did not move; `elastic` is what moving would cost [N]."""
        change = self._seen[0][1] - self._force
        return not abs(change) > STAYED * abs(elastic)  # an absent force says nothing against it

    @property
    def _seen(self) -> list[tuple[float, float]]:
        # the first may be half of one place, half of the other; later ones suffer from the prediction
        return self._rejected[1:4] or self._rejected
