"""What the measured force has over the one that coefficients and the motion make one expect, and its means."""

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.transmission import COULOMB_SPEED, ln_stiffness, peak_speed

WINDOWS = (0.12, 0.5, 3.0)  # means of the residual force are taken over these [s]
DECIDES = 1  # which of them says that all is well again
LEAST_ROWS = 5
PERIOD = 0.05  # between two looks [s]
BASE = 0.1  # a speed is a difference over so long [s]
FAST = 0.85  # share of v* up to which a mean speed tells the damper's force
BLURRED = 2.0  # error of the damper's force by a speed that changes within BASE, from which on it tells nothing [N]
SLOW = 0.25e-3  # around a reversal friction is anything up to itself [m/s]
STICTION = 1.3  # breaking away takes more than sliding
COVERED = 0.5  # share of a window's forces that must tell something: the mean of a few is mostly noise of the speed


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
    speed = peak_speed(d1, d2)
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
        bend = abs(a)
        if half <= i < count - half:  # over twice the time, a quarter of the noise
            wide = deflection[i + 3 * half] - 2.0 * deflection[i + half] + deflection[i - half]
            bend = min(bend, abs(wide) / span**2)
        blur = 0.25 * BASE * bend
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
