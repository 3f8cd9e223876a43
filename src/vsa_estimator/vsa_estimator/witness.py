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
from vsa_common.accel import compiled
from vsa_estimator.model import COULOMB_SPEED, Array, ln_stiffness, maximum_speed

WINDOWS = (0.12, 0.5, 3.0)  # means of the residual force are taken over these [s]
DECIDES = 1  # which of them says that all is well again
LEAST_ROWS = 5
PERIOD = 0.05  # between two looks [s]
BASE = 0.1  # a speed is a difference over so long [s]
LIMIT = 6.0  # times the usual size of a mean
CALM = 0.5  # share of the limit under which both sensors agree with what was learnt
USUAL = (0.3, 0.15, 0.1)  # first idea of it, worth so many looks [N]
USUAL_WORTH, USUAL_LOOKS = 15, 400
LEAST_USUAL = 0.01  # [N]
VAGUE = 3.0  # times the usual mean that uncertain coefficients may explain; beyond that they are no witness
POOR = 0.4  # nor are any whose usual mean is greater [N]
BEYOND = 0.05  # nor beyond the travel that they were learnt on, by more than so much of 1 / k2
FAST = 0.85  # share of v* up to which a mean speed tells the damper's force
BLURRED = 2.0  # error of the damper's force by a speed that changes within BASE, from which on it tells nothing [N]
SLOW = 0.25e-3  # around a reversal friction is anything up to itself [m/s]
STICTION = 1.3  # breaking away takes more than sliding
COVERED = 0.5  # share of a window's forces that must tell something: the mean of a few is mostly noise of the speed
SHIFT_TIME = 2.5  # of contradiction before it is explained by a shift [s]
CLEARLY = 2.5  # times better one explanation must be than the other


class Coefficients(NamedTuple):
    """[s k2 d1 d2 M F0 d0] with covariance, and the place at which s is meant [m]."""

    mean: Array
    covariance: Array
    reference: float


class Shift(NamedTuple):
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


class Witness:
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

    def forget(self) -> None:
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
    def kept(self) -> Coefficients | None:
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
    def vague(self) -> bool:
        """Whether the coefficients are too uncertain, here, to be held against anybody."""
        usual, (low, high), place = math.sqrt(self._usual[DECIDES]), self._travel, float(self._rows.view[1, -1])
        margin = BEYOND / float(self._kept[0].mean[1])
        uncertain = self._doubtful > VAGUE * usual or usual > POOR
        return uncertain or self.silent or not low - margin < place < high + margin

    @property
    def silent(self) -> bool:
        """Whether the motion tells nothing about the force."""
        return self._means[DECIDES] is None

    @property
    def contradicts(self) -> bool:
        """Whether the force is not what it should be."""
        return any(share is not None and share > 1.0 for share in map(self._share, range(len(WINDOWS))))

    @property
    def agrees(self) -> bool:
        """Whether the force has been what it should be for long enough."""
        short = [self._share(index) for index in range(DECIDES + 1)]
        return all(share is not None and share < CALM for share in short)

    def trust(self) -> None:
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

    def explain(self) -> Shift | None:
        """A constant shift of one sensor that explains the last seconds, if it does and the other's does not."""
        time, residual, stiffness, moving, *_ = self._residuals()
        if self.kept is None or not time.size or time[-1] - time[0] < SHIFT_TIME or moving.mean() < 0.5:
            return None
        residual, stiffness = residual[moving], stiffness[moving]
        offset = float(residual.mean())
        slope = float(residual @ stiffness / (stiffness @ stiffness))  # -(1 - exp(-k2 dx)) / k2
        k2, width = float(self.kept.mean[1]), max(1, residual.size // 10)
        by_force, by_deflection = (_ripple(rest, width) for rest in (residual - offset, residual - slope * stiffness))
        limit = LIMIT * math.sqrt(self._usual[DECIDES])
        if by_force < limit and by_force * CLEARLY < by_deflection:
            return Shift(offset, 0.0, by_force)
        if by_deflection < limit and by_deflection * CLEARLY < by_force and 1.0 + k2 * slope > 0.0:
            shift = -math.log1p(k2 * slope) / k2
            return Shift(0.0, shift, by_deflection / float(np.sqrt(np.mean(stiffness**2))))
        return None

    def _share(self, index: int) -> float | None:
        mean = self._means[index]
        if mean is None:
            return None
        return abs(mean) / (LIMIT * math.hypot(math.sqrt(self._usual[index]), self._doubtful))

    def _look(self) -> None:
        found = np.array([math.nan] * len(WINDOWS) + [0.0])
        if self._rows.view.shape[1] >= LEAST_ROWS:
            look(self._rows.view, *self._kept[0], found)
        *means, self._doubtful = found.tolist()
        self._means = [None if math.isnan(mean) else mean for mean in means]

    def _residuals(self) -> tuple[Array, Array, Array, NDArray[np.bool_], Array, Array]:
        """`residuals` of the last seconds; empty where there is nothing to compare."""
        if self.kept is None or self._rows.view.shape[1] < LEAST_ROWS:
            nothing = np.zeros(0)
            return nothing, nothing, nothing, nothing.astype(bool), np.zeros((3, 0)), nothing
        return residuals(self._rows.view, self.kept.mean, self.kept.reference)


@compiled
def residuals(
    rows: Array, mean: Array, reference: float
) -> tuple[Array, Array, Array, NDArray[np.bool_], Array, Array]:
    """Where a fresh force tells something: time, measured minus expected force, stiffness, whether it moves; x, v, a.

    Last the times of all fresh forces. The force is that of eq. (6), the stiffness that of eq. (3); beyond v*
    the damper holds its greatest force.
    """
    time, deflection, force = rows[0], rows[1], rows[2]
    half = max(1, round(0.5 * BASE * (time.size - 1) / (time[-1] - time[0])))
    around, count = half // 2, max(0, time.size - 2 * half)
    s, k2, d1, d2, mass, offset, coulomb = mean
    speed = maximum_speed(d1, d2)
    motion, residual, sigma = np.empty((3, count)), np.empty(count), np.empty(count)
    good, brisk, moving = np.empty(count, np.bool_), np.empty(count, np.bool_), np.empty(count, np.bool_)
    for i in range(count):
        span = time[i + 2 * half] - time[i]
        v = (deflection[i + 2 * half] - deflection[i]) / span
        a = 4.0 * (deflection[i + 2 * half] - 2.0 * deflection[i + half] + deflection[i]) / span**2
        x = 0.0
        for near in range(i + half - around, i + half + around + 1):
            x += deflection[near]
        x /= 2 * around + 1
        sigma[i] = np.exp(ln_stiffness(s, k2, x - reference))
        c = min(max(v, -speed), speed)
        friction = coulomb * np.tanh(v / COULOMB_SPEED)
        residual[i] = force[i + half] - (sigma[i] / k2 + d1 * c + d2 * c**3 + mass * a + offset + friction)
        blur = 0.25 * BASE * abs(a)
        brisk[i] = abs(v) + blur >= FAST * speed or blur * d1 > BLURRED
        good[i] = np.isfinite(residual[i]) and span < 2.0 * BASE
        moving[i] = abs(v) > SLOW
        motion[0, i], motion[1, i], motion[2, i] = x, v, a
    time = time[half : half + count]
    fresh = time[good]
    until = -1  # brisk tells of what comes before and after it, too
    for i in range(count):
        if brisk[i]:
            good[max(0, i - 2 * half) : i] = False
            until = i + 2 * half
        if i <= until:
            good[i] = False
    return time[good], residual[good], sigma[good], moving[good], motion[:, good], fresh


@compiled
def mean_residual(
    time: Array, residual: Array, moving: NDArray[np.bool_], fresh: Array, friction: float, window: float
) -> tuple[int, float]:
    """The first row in the last `window` [s], -1 for too few, and their mean [N]; at rest, friction [N] hides some.

    `fresh` are the times of all forces, also of those that tell nothing.
    """
    if time.size == 0:
        return -1, 0.0
    begin = fresh[-1] - window
    first = int(np.searchsorted(time, begin))
    least = max(3.0, COVERED * (fresh.size - np.searchsorted(fresh, begin)))
    if time.size - first < least or time[-1] - time[first] <= 0.8 * window - 2.0 * PERIOD:
        return -1, 0.0
    total = 0.0
    for i in range(first, time.size):
        rest = residual[i]
        total += rest if moving[i] else np.sign(rest) * max(abs(rest) - friction, 0.0)
    return first, total / (time.size - first)


@compiled
def doubt(mean: Array, covariance: Array, reference: float, motion: Array, first: int) -> float:
    """Standard deviation of the mean expected force from row `first` on that the coefficients' own makes [N]."""
    gradient = np.zeros(7)
    for i in range(first, motion.shape[1]):
        x, v, a = motion[:, i]
        dx = x - reference
        spring = np.exp(ln_stiffness(mean[0], mean[1], dx)) / mean[1]
        gradient[0] += spring
        gradient[1] += spring * (dx - 1.0 / mean[1])
        gradient[2] += v
        gradient[3] += v**3
        gradient[4] += a
        gradient[5] += 1.0
        gradient[6] += np.tanh(v / COULOMB_SPEED)
    gradient /= motion.shape[1] - first
    return float(np.sqrt(max(float(gradient @ covariance @ gradient), 0.0)))


@compiled
def look(rows: Array, mean: Array, covariance: Array, reference: float, found: Array) -> None:
    """Mean residual force of each of WINDOWS [N], as it is where it tells something, and `doubt` of DECIDES."""
    time, residual, _, moving, motion, fresh = residuals(rows, mean, reference)
    friction = STICTION * mean[6]
    for index in range(len(WINDOWS)):
        first, average = mean_residual(time, residual, moving, fresh, friction, WINDOWS[index])
        if first >= 0:
            found[index] = average
            if index == DECIDES:
                found[len(WINDOWS)] = doubt(mean, covariance, reference, motion, first)


def _ripple(values: Array, width: int) -> float:
    """Root mean square of running means [same unit]."""
    return float(np.sqrt(np.mean(np.convolve(values, np.full(width, 1.0 / width), "valid") ** 2)))
