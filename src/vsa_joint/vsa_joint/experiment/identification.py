"""The joint's impedance from external torque and angle alone, with the motors held.

Without friction the response at the excited lines suffices (`from_response`). With friction no amplitude of
a plain response is right, so torque is regressed on spring, damper and friction together where the joint
moves fast enough for the friction to have saturated (`from_motion`).

Both look at what remains when the known parts are taken off: the joint's own damping and inertia, and the
tendons in series, K_s = 2 R^2 K_t. Behind the tendons the rods are Z' = K' + D' s + M' s^2 at phi, and

    K = K' g,  D = D' g^2 + D_joint,  J = M' g^2 - D'^2 g^2 / (K_s + K') + J_joint,  g = K_s / (K_s + K').
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_joint.impedance.reflection import Impedance, Joint

TOP_FREQUENCY = 8.0  # Hz, above it the angle is noise
GRID_RATE = 128.0  # Hz, of the smoothed period
LEAST_SPEED = 0.02  # rad/s, slower samples feel how friction builds up
FRICTION_SPEEDS = np.geomspace(0.003, 0.03, 15)  # rad/s, of the tanh that friction saturates with; the best is taken
LEAST_MOVING = 0.1  # of the period
VARIANTS = ((LEAST_SPEED, False), (LEAST_SPEED, True), (1.5 * LEAST_SPEED, False))  # their spread is the form's error
LUMPING_ERROR = 1e-3  # relative, of taking both tendons as one spring and a mean angle as the place
CORRELATION_TIME = 0.25  # s, over which residuals are taken as one error


@dataclass(frozen=True)
class Period:
    """One period of angle [rad] and torque [N m], the mean of several; `duration` in s."""

    angle: Array
    torque: Array
    duration: float


@dataclass(frozen=True)
class Identified:
    """Impedance of the joint at its mean angle and at rest, with standard deviations.

    `friction` is the torque of the dry friction, `residual` the rms of what stays unexplained [N m].
    """

    impedance: Impedance
    std: Impedance
    friction: float
    residual: float
    samples: int


def average(angle: Array, torque: Array, rate: float, duration: float) -> Period:
    """Mean period of uniformly sampled signals; what does not fill a whole period is left off at the front."""
    length = round(rate * duration)
    count = len(angle) // length
    if count < 1:
        raise ValueError(f"{len(angle)} samples at {rate} Hz: expected a period of {duration} s at least")
    fold = slice(len(angle) - count * length, None)
    return Period(
        np.asarray(angle, dtype=float)[fold].reshape(count, length).mean(axis=0),
        np.asarray(torque, dtype=float)[fold].reshape(count, length).mean(axis=0),
        duration,
    )


def line_response(period: Period, lines: tuple[int, ...]) -> NDArray[np.complex128]:
    """Torque over angle at harmonics of the period [N m/rad]."""
    index = list(lines)
    response: NDArray[np.complex128] = np.fft.rfft(period.torque)[index] / np.fft.rfft(period.angle)[index]
    return response


def from_response(frequency: Array, response: NDArray[np.complex128], joint: Joint) -> Identified:
    """Impedance from Z_theta(j w) of a joint without friction; exact behind equal tendons."""
    s = 2j * np.pi * np.asarray(frequency)
    rest = response - joint.damping * s - joint.inertia * s**2
    series = series_stiffness(joint)
    behind = rest * series / (series - rest)
    weight = 1.0 / np.abs(behind)
    columns = np.stack([np.ones_like(s), s, s**2], axis=1) * weight[:, None]
    rows = np.concatenate([columns.real, columns.imag])
    values, covariance, residual = _least_squares(
        rows, np.concatenate([(behind * weight).real, (behind * weight).imag]), 1
    )
    covariance = covariance + np.diag((LUMPING_ERROR * values) ** 2)
    return _in_front(values, covariance, joint, 0.0, residual, len(rows))


def from_motion(period: Period, joint: Joint) -> Identified:
    """Impedance from a period of motion with dry friction in the rods, by trimmed regression.

    Raises ValueError where the joint hardly moves.
    """
    angle, rate, acceleration = _derivatives(period.angle, period.duration)
    torque = _derivatives(period.torque, period.duration)[0]
    rest = torque - joint.damping * rate - joint.inertia * acceleration
    series = series_stiffness(joint)
    behind = angle - rest / series
    behind = behind - behind.mean()
    motion = _derivatives(behind, period.duration)
    moving = float(np.mean(np.abs(motion[1]) > LEAST_SPEED))
    if moving < LEAST_MOVING:
        raise ValueError(
            f"the joint moves faster than {LEAST_SPEED} rad/s in {moving:.0%} of the period: "
            f"expected {LEAST_MOVING:.0%}; use more torque"
        )
    fits = [_regress(rest, motion, trim, extra, period.duration) for trim, extra in VARIANTS]
    values, covariance, residual, samples = fits[0]
    others = np.array([fit[0][:3] for fit in fits[1:]]) - values[:3]
    covariance = covariance[:3, :3] + others.T @ others / len(others) + np.diag((LUMPING_ERROR * values[:3]) ** 2)
    return _in_front(values[:3], covariance, joint, abs(float(values[-1])), residual, samples)


def _regress(
    torque: Array, motion: tuple[Array, Array, Array], trim: float, extra: bool, duration: float
) -> tuple[Array, Array, float, int]:
    """Coefficients (K', D', M' first, friction last), covariance, rms residual and rows of one trimmed regression."""
    moving = np.abs(motion[1]) > trim
    phi, speed, spin = (signal[moving] for signal in motion)
    columns = [phi, speed, spin, np.ones_like(phi), phi**2, phi**3, speed**3]
    if extra:
        columns += [phi**4, phi**5]
    together = max(1, round(CORRELATION_TIME * len(motion[0]) / duration))
    fits = (
        _least_squares(np.stack([*columns, np.tanh(speed / scale)], axis=1), torque[moving], together)
        for scale in FRICTION_SPEEDS
    )
    return *min(fits, key=lambda fit: fit[2]), len(phi)


def series_stiffness(joint: Joint) -> float:
    """Both tendons with their moving pulleys, seen from the joint [N m/rad]."""
    return sum(2.0 * 0.5 * route.radius**2 * route.tendon_stiffness for route in joint.routes)


def _derivatives(signal: Array, duration: float) -> tuple[Array, Array, Array]:
    """Periodic signal below TOP_FREQUENCY with two derivatives, on a coarser grid."""
    points = round(GRID_RATE * duration)
    spectrum = np.fft.rfft(signal) * (points / len(signal))
    spectrum = np.resize(spectrum, points // 2 + 1) if len(spectrum) < points // 2 + 1 else spectrum[: points // 2 + 1]
    harmonic = np.arange(len(spectrum))
    spectrum[harmonic > TOP_FREQUENCY * duration] = 0.0
    s = 2j * np.pi * harmonic / duration
    value, first, second = (np.fft.irfft(spectrum * s**order, points) for order in (0, 1, 2))
    return value, first, second


def _least_squares(columns: Array, target: Array, together: int) -> tuple[Array, Array, float]:
    """Coefficients, covariance and rms residual; residuals within `together` rows count as one error."""
    scale = np.sqrt((columns**2).mean(axis=0))
    scaled = columns / scale
    values, *_ = np.linalg.lstsq(scaled, target, rcond=None)
    residual = target - scaled @ values
    inverse = np.linalg.pinv(scaled.T @ scaled)
    scores = scaled * residual[:, None]
    blocks = np.add.reduceat(scores, np.arange(0, len(scores), together), axis=0)
    freedom = max(1, len(blocks) - columns.shape[1])
    covariance = inverse @ (blocks.T @ blocks * len(blocks) / freedom) @ inverse
    return values / scale, covariance / np.outer(scale, scale), float(np.sqrt((residual**2).mean()))


def _in_front(
    values: Array, covariance: Array, joint: Joint, friction: float, residual: float, samples: int
) -> Identified:
    """From behind the tendons to the joint, with the covariance through its derivatives."""
    k, d, m = (float(value) for value in values)
    series = series_stiffness(joint)
    g = series / (series + k)
    fall = -g / (series + k)  # of g with K'
    slopes = np.array(
        [
            [g * g, 0.0, 0.0],
            [2.0 * g * fall * d, g * g, 0.0],
            [
                2.0 * g * fall * m - d * d * (2.0 * g * fall / (series + k) - g * g / (series + k) ** 2),
                -2.0 * d * g * g / (series + k),
                g * g,
            ],
        ]
    )
    std = np.sqrt(np.diag(slopes @ covariance @ slopes.T))
    inertia = g * g * m - (d * g) ** 2 / (series + k) + joint.inertia
    return Identified(
        Impedance(k * g, d * g * g + joint.damping, inertia), Impedance(*map(float, std)), friction, residual, samples
    )
