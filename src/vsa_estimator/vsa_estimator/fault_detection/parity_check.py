"""Whether force and encoder still tell the story that was learnt.

The filter trusts its sensors sample by sample, so a slow lie of either is learnt instead of noticed. Here the measured
force is held against coefficients of some seconds ago on the motion that the encoder alone shows. Noise of the speed
telescopes: its mean over a window is the noise of two places over the window's length.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.fault_detection.residual import DECIDES, LEAST_ROWS, PERIOD, WINDOWS, look, residuals

LIMIT = 5.5  # times the usual size of a mean
CALM = 0.5  # share of the limit under which both sensors agree with what was learnt
USUAL = (0.3, 0.15, 0.1)  # first idea of it, worth so many looks [N]
USUAL_WORTH, USUAL_LOOKS = 15, 400
LEAST_USUAL = 0.01  # [N]
VAGUE = 3.0  # times the usual mean that uncertain coefficients may explain; beyond that they are no witness
POOR = 0.4  # nor are any whose usual mean is greater [N]
BEYOND = 0.05  # nor beyond the travel that they were learnt on, by more than so much of 1 / k2
SHIFT_TIME = 2.5  # of contradiction before it is explained by a shift [s]
CLEARLY = 2.5  # times better one explanation must be than the other


class Coefficients(NamedTuple):
    """[s k2 d1 d2 M F0 d0] with covariance, and the place at which s is meant [m]."""

    mean: Array
    covariance: Array
    reference: float


class SensorShift(NamedTuple):
    """What would explain the contradiction; one of the two is zero."""

    force: float  # the force reads so much more than it did [N]
    deflection: float  # the encoder does [m]
    std: float  # of the one that is not zero


class Rows:
    """The last blocks: time [s], deflection [m], force [N], each a row of `view`."""

    def __init__(self, capacity: int) -> None:
        """`capacity` of them are kept."""
        self._capacity = capacity
        self._buffer = np.empty((3, 2 * capacity))
        self._begin = self._end = 0

    @property
    def view(self) -> Array:
        """What is kept, oldest first; good until the next is appended."""
        return self._buffer[:, self._begin : self._end]

    def append(self, time: float, deflection: float, force: float) -> None:
        """Keep one more."""
        if self._end == 2 * self._capacity:
            kept = self.view.copy()
            self._begin, self._end = 0, kept.shape[1]
            self._buffer[:, : self._end] = kept
        self._buffer[:, self._end] = time, deflection, force
        self._end += 1
        self._begin = max(self._begin, self._end - self._capacity)

    def drop_before(self, time: float) -> None:
        """Forget what is older [s]."""
        self._begin += int(np.searchsorted(self.view[0], time))

    def clear(self) -> None:
        """Forget all."""
        self._begin = self._end = 0


class ParityCheck:
    """Coefficients of a few seconds ago and what the sensors say against them."""

    def __init__(self, rate: float) -> None:
        """`rate` of the blocks [Hz]."""
        self._kept: deque[Coefficients] = deque(maxlen=2)
        self._rows = Rows(int(WINDOWS[-1] * rate) + 1)
        self._usual = [value * value for value in USUAL]
        self._looks = USUAL_WORTH
        self._looked = 0.0
        self._means: list[float | None] = [None] * len(WINDOWS)
        self._doubtful = 0.0  # what uncertain coefficients explain [N]
        self._travel = (math.inf, -math.inf)  # [m]

    def reset(self) -> None:
        """Nothing is known any more."""
        self._kept.clear()
        self._travel = (math.inf, -math.inf)
        self.interrupt()

    def interrupt(self) -> None:
        """The motion has a gap."""
        self._rows.clear()
        self._means = [None] * len(WINDOWS)

    def keep(self, coefficients: Coefficients) -> None:
        """Remember what is known now; the one before it is what the sensors are held against."""
        self._kept.append(coefficients)
        places = self._rows.view[1].tolist()
        self._travel = min((self._travel[0], *places)), max((self._travel[1], *places))

    def replace(self, coefficients: Coefficients) -> None:
        """Hold the sensors against these from now on."""
        if self._kept:
            shift = coefficients.reference - self._kept[0].reference
            self._travel = self._travel[0] + shift, self._travel[1] + shift
        self._kept.clear()
        self.keep(coefficients)

    @property
    def checkpoint(self) -> Coefficients | None:
        """What the sensors are held against."""
        return self._kept[0] if self._kept else None

    def add(self, time: float, deflection: float, force: float) -> bool:
        """Take a block [s, m, N], NaN for no force; whether there is something new to tell."""
        self._rows.append(time, deflection, force)
        if not self._kept or time - self._looked < PERIOD:
            return False
        self._looked = time
        self._look()
        return True

    @property
    def is_insensitive(self) -> bool:
        """Whether the coefficients are too uncertain, here, to be held against anybody."""
        usual, (low, high), place = math.sqrt(self._usual[DECIDES]), self._travel, float(self._rows.view[1, -1])
        margin = BEYOND / float(self._kept[0].mean[1])
        uncertain = self._doubtful > VAGUE * usual or usual > POOR
        return uncertain or not low - margin < place < high + margin

    @property
    def no_evidence(self) -> bool:
        """Whether the motion tells nothing about the force."""
        return self._means[DECIDES] is None

    @property
    def exceeds_threshold(self) -> bool:
        """Whether the force is not what it should be."""
        return any(share is not None and share > 1.0 for share in map(self._share, range(len(WINDOWS))))

    @property
    def is_consistent(self) -> bool:
        """Whether the force has been what it should be for long enough."""
        short = [self._share(index) for index in range(DECIDES + 1)]
        return all(share is not None and share < CALM for share in short)

    def accept(self) -> None:
        """All was well at this look: its means are usual ones. Larger ones count for little."""
        self._looks = min(self._looks + 1, USUAL_LOOKS)
        for index, mean in enumerate(self._means):
            if mean is not None:
                usual = self._usual[index]
                usual += (min(mean * mean, 4.0 * usual) - usual) / self._looks
                self._usual[index] = max(usual, LEAST_USUAL**2)

    def settle(self) -> None:
        """What was contradicted is over: older rows say nothing more."""
        self._rows.drop_before(self._looked - WINDOWS[DECIDES])

    def isolate_fault(self) -> SensorShift | None:
        """A constant shift of one sensor that explains the last seconds, if it does and the other's does not."""
        time, residual, stiffness, moving, *_ = self._residuals()
        if self.checkpoint is None or not time.size or time[-1] - time[0] < SHIFT_TIME or moving.mean() < 0.5:
            return None
        residual, stiffness = residual[moving], stiffness[moving]
        offset = float(residual.mean())
        slope = float(residual @ stiffness / (stiffness @ stiffness))  # -(1 - exp(-k2 dx)) / k2
        k2, width = float(self.checkpoint.mean[1]), max(1, residual.size // 10)
        by_force, by_deflection = (_ripple(rest, width) for rest in (residual - offset, residual - slope * stiffness))
        limit = LIMIT * math.sqrt(self._usual[DECIDES])
        if by_force < limit and by_force * CLEARLY < by_deflection:
            return SensorShift(offset, 0.0, by_force)
        if by_deflection < limit and by_deflection * CLEARLY < by_force and 1.0 + k2 * slope > 0.0:
            shift = -math.log1p(k2 * slope) / k2
            return SensorShift(0.0, shift, by_deflection / float(np.sqrt(np.mean(stiffness**2))))
        return None

    def _share(self, index: int) -> float | None:
        mean = self._means[index]
        if mean is None:
            return None
        return abs(mean) / (LIMIT * math.hypot(math.sqrt(self._usual[index]), self._doubtful))

    def _look(self) -> None:
        found = np.array([math.nan] * len(WINDOWS) + [self._doubtful])
        if self._rows.view.shape[1] >= LEAST_ROWS:
            look(self._rows.view, *self._kept[0], found)
        *means, self._doubtful = found.tolist()
        self._means = [None if math.isnan(mean) else mean for mean in means]

    def _residuals(self) -> tuple[Array, Array, Array, NDArray[np.bool_], Array, Array]:
        """`residuals` of the last seconds; empty where there is nothing to compare."""
        if self.checkpoint is None or self._rows.view.shape[1] < LEAST_ROWS:
            nothing = np.zeros(0)
            return nothing, nothing, nothing, nothing.astype(bool), np.zeros((3, 0)), nothing
        return residuals(self._rows.view, self.checkpoint.mean, self.checkpoint.reference)


def _ripple(values: Array, width: int) -> float:
    """Root mean square of running means [same unit]."""
    return float(np.sqrt(np.mean(np.convolve(values, np.full(width, 1.0 / width), "valid") ** 2)))
