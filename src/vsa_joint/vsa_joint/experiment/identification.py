# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of the joint from external torque and angle alone, with held motors.

Without friction the response at the excited lines suffices (`from_response`). Dry friction biases a linear response at
every amplitude; `from_motion` regresses the torque on spring, damper and friction, over the samples at which the
friction is saturated.

Both subtract the known terms: the joint's own damping and inertia, and the tendons in series, K_s = 2 R^2 K_t. On the
tendon side the transmissions are Z' = K' + D' s + M' s^2 at phi. On the joint side

    K = K' g,  D = D' g^2 + D_joint,  J = M' g^2 - D'^2 g^2 / (K_s + K') + J_joint,  g = K_s / (K_s + K').
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_joint.geometry import Joint
from vsa_joint.impedance.reflection import Impedance
from vsa_joint.tuning import (
    CORRELATION_TIME,
    FRICTION_SPEED_COUNT,
    FRICTION_SPEED_MAX,
    FRICTION_SPEED_MIN,
    GRID_RATE,
    LUMPING_ERROR,
    MIN_MOVING_SHARE,
    MIN_SPEED,
    TOP_FREQUENCY,
    WIDER_TRIM,
)

# saturation speeds of the friction model [rad/s]; the one with the least residual is used
FRICTION_SPEEDS = np.geomspace(FRICTION_SPEED_MIN, FRICTION_SPEED_MAX, FRICTION_SPEED_COUNT)
# least speed [rad/s] and order of the spring of each regression; the spread over them is the model error
VARIANTS = ((MIN_SPEED, 3), (MIN_SPEED, 5), (WIDER_TRIM * MIN_SPEED, 3))


@dataclass(frozen=True)
class Period:
    """Mean period of angle [rad] and torque [N m], uniformly sampled; `duration` in s."""

    angle: Array
    torque: Array
    duration: float


@dataclass(frozen=True)
class Identified:
    """Impedance of the joint at its mean angle and at rest, with standard deviations.

    `friction` is the torque of the dry friction, `residual` the rms of the residual torque [N m].
    """

    impedance: Impedance
    std: Impedance
    friction: float
    residual: float
    samples: int


class _Fit(NamedTuple):
    """Least-squares coefficients with their covariance, the rms residual and the number of rows."""

    values: Array
    covariance: Array
    residual: float
    samples: int


def average(angle: Array, torque: Array, rate: float, duration: float) -> Period:
    """Mean period of signals at `rate` [Hz]; an incomplete period at the front is discarded.

    Raises ValueError for less than one period of `duration` [s].
    """
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
    """Torque over angle at harmonics of the period [N m/rad]; one value per line."""
    index = list(lines)
    response: NDArray[np.complex128] = np.fft.rfft(period.torque)[index] / np.fft.rfft(period.angle)[index]
    return response


def from_response(frequency: Array, response: NDArray[np.complex128], joint: Joint) -> Identified:
    """Impedance from Z_theta(j w) of a joint without friction; exact for equal tendons."""
    s = 2j * np.pi * np.asarray(frequency)
    remainder = response - joint.damping * s - joint.inertia * s**2
    series = series_stiffness(joint)
    tendon_side = remainder * series / (series - remainder)
    weight = 1.0 / np.abs(tendon_side)
    columns = np.stack([np.ones_like(s), s, s**2], axis=1) * weight[:, None]
    rows = np.concatenate([columns.real, columns.imag])
    target = np.concatenate([(tendon_side * weight).real, (tendon_side * weight).imag])
    fit = _least_squares(rows, target, 1)
    covariance = fit.covariance + np.diag((LUMPING_ERROR * fit.values) ** 2)
    return _joint_side(fit._replace(covariance=covariance), joint, 0.0)


def from_motion(period: Period, joint: Joint) -> Identified:
    """Impedance from a period of motion with dry friction, by trimmed regression.

    Raises ValueError where less than MIN_MOVING_SHARE of the period is faster than MIN_SPEED.
    """
    angle, rate, acceleration = _derivatives(period.angle, period.duration)
    torque = _derivatives(period.torque, period.duration)[0]
    remainder = torque - joint.damping * rate - joint.inertia * acceleration
    series = series_stiffness(joint)
    tendon_side = angle - remainder / series
    tendon_side = tendon_side - tendon_side.mean()
    motion = _derivatives(tendon_side, period.duration)
    moving = float(np.mean(np.abs(motion[1]) > MIN_SPEED))
    if moving < MIN_MOVING_SHARE:
        raise ValueError(
            f"the joint moves faster than {MIN_SPEED} rad/s in {moving:.0%} of the period: "
            f"expected {MIN_MOVING_SHARE:.0%}; use more torque"
        )
    fits = [_regress(remainder, motion, trim, order, period.duration) for trim, order in VARIANTS]
    fit = fits[0]
    others = np.array([other.values[:3] for other in fits[1:]]) - fit.values[:3]
    model_error = others.T @ others / len(others)
    covariance = fit.covariance[:3, :3] + model_error + np.diag((LUMPING_ERROR * fit.values[:3]) ** 2)
    return _joint_side(fit._replace(values=fit.values[:3], covariance=covariance), joint, abs(float(fit.values[-1])))


def _regress(torque: Array, motion: tuple[Array, Array, Array], trim: float, order: int, duration: float) -> _Fit:
    """Regression over the samples faster than `trim`: K', D', M' first, friction last; `order` of the spring."""
    moving = np.abs(motion[1]) > trim
    phi, speed, acceleration = (signal[moving] for signal in motion)
    columns = [phi, speed, acceleration, np.ones_like(phi), phi**2, phi**3, speed**3]
    columns += [phi**power for power in range(4, order + 1)]
    block = max(1, round(CORRELATION_TIME * len(motion[0]) / duration))
    fits = (
        _least_squares(np.stack([*columns, np.tanh(speed / scale)], axis=1), torque[moving], block)
        for scale in FRICTION_SPEEDS
    )
    return min(fits, key=lambda fit: fit.residual)


def series_stiffness(joint: Joint) -> float:
    """Stiffness of both tendons with their moving pulleys, at the joint [N m/rad]."""
    return sum(2.0 * 0.5 * path.radius**2 * path.tendon_stiffness for path in joint.paths)


def _derivatives(signal: Array, duration: float) -> tuple[Array, Array, Array]:
    """Periodic signal below TOP_FREQUENCY with two derivatives, at GRID_RATE."""
    points = round(GRID_RATE * duration)
    spectrum = np.fft.rfft(signal) * (points / len(signal))
    spectrum = np.resize(spectrum, points // 2 + 1) if len(spectrum) < points // 2 + 1 else spectrum[: points // 2 + 1]
    harmonic = np.arange(len(spectrum))
    spectrum[harmonic > TOP_FREQUENCY * duration] = 0.0
    s = 2j * np.pi * harmonic / duration
    value, first, second = (np.fft.irfft(spectrum * s**order, points) for order in (0, 1, 2))
    return value, first, second


def _least_squares(columns: Array, target: Array, block: int) -> _Fit:
    """Ordinary least squares; residuals within `block` rows count as one error in the robust covariance."""
    scale = np.sqrt((columns**2).mean(axis=0))
    scaled = columns / scale
    values, *_ = np.linalg.lstsq(scaled, target, rcond=None)
    residual = target - scaled @ values
    inverse = np.linalg.pinv(scaled.T @ scaled)
    scores = scaled * residual[:, None]
    blocks = np.add.reduceat(scores, np.arange(0, len(scores), block), axis=0)
    freedom = max(1, len(blocks) - columns.shape[1])
    covariance = inverse @ (blocks.T @ blocks * len(blocks) / freedom) @ inverse
    rms = float(np.sqrt((residual**2).mean()))
    return _Fit(values / scale, covariance / np.outer(scale, scale), rms, len(target))


def _joint_side(fit: _Fit, joint: Joint, friction: float) -> Identified:
    """Impedance on the joint side from (K', D', M') on the tendon side; linearized propagation of the covariance."""
    k, d, m = (float(value) for value in fit.values)
    series = series_stiffness(joint)
    g = series / (series + k)
    g_by_k = -g / (series + k)
    inertia_by_k = 2.0 * g * g_by_k * m - d * d * (2.0 * g * g_by_k / (series + k) - g * g / (series + k) ** 2)
    jacobian = np.array(
        [
            [g * g, 0.0, 0.0],
            [2.0 * g * g_by_k * d, g * g, 0.0],
            [inertia_by_k, -2.0 * d * g * g / (series + k), g * g],
        ]
    )
    std = np.sqrt(np.diag(jacobian @ fit.covariance @ jacobian.T))
    inertia = g * g * m - (d * g) ** 2 / (series + k) + joint.inertia
    return Identified(
        impedance=Impedance(k * g, d * g * g + joint.damping, inertia),
        std=Impedance(*map(float, std)),
        friction=friction,
        residual=fit.residual,
        samples=fit.samples,
    )
