# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Scale and offset of a force sensor against a reference gauge, section VI of the paper."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from vsa_common.types import Array
from vsa_driver.tuning import CORRELATION_TIMES, LAG_LIMIT, MIN_COMMON_SAMPLES, MIN_EXCITATION


class GaugeError(ValueError):
    """The two logs do not determine a calibration; the text states the reason."""


@dataclass(frozen=True)
class GaugeFit:
    """reference = scale * force + offset, and its residuals."""

    scale: float  # [1]
    scale_std: float
    offset: float  # [N]
    offset_std: float
    scale_offset_covariance: float  # [N]
    lag: float  # by which the gauge's clock is ahead of the sensor's [s]
    residual_std: float  # [N]
    residual_max: float  # [N]
    samples: int
    force_min: float  # by the gauge [N]
    force_max: float


def fit(force: Array, reference: Array) -> GaugeFit:
    """Least-squares line from force [N] to reference [N], both (n,), taken at the same instants.

    Standard deviations account for residuals that are correlated in time, which hysteresis and filters cause
    (Newey and West, 1987). Raises GaugeError.
    """
    finite = np.isfinite(force) & np.isfinite(reference)
    x, y = force[finite], reference[finite]
    if x.size < MIN_COMMON_SAMPLES:
        raise GaugeError(f"{x.size} samples in common, expected at least {MIN_COMMON_SAMPLES}")
    noise = float(np.std(np.diff(x, 2))) / np.sqrt(6.0)  # a second difference of white noise has six times its variance
    if not np.std(x) > MIN_EXCITATION * noise:
        variation = f"force varies by {np.std(x):.3g} N only, at {noise:.3g} N of noise"
        raise GaugeError(f"{variation}; load the sensor over its range, slowly")
    mean = x.mean()
    design = np.column_stack([x - mean, np.ones_like(x)])
    (scale, level), *_ = np.linalg.lstsq(design, y, rcond=None)
    residual = y - design @ np.array([scale, level])
    covariance = _hac_covariance(design, residual)
    uncentre = np.array([[1.0, 0.0], [-mean, 1.0]])  # offset = level - scale * mean
    covariance = uncentre @ covariance @ uncentre.T
    return GaugeFit(
        scale=float(scale),
        scale_std=float(np.sqrt(covariance[0, 0])),
        offset=float(level - scale * mean),
        offset_std=float(np.sqrt(covariance[1, 1])),
        scale_offset_covariance=float(covariance[0, 1]),
        lag=0.0,
        residual_std=float(np.sqrt(residual @ residual / (x.size - 2))),
        residual_max=float(np.abs(residual).max()),
        samples=int(x.size),
        force_min=float(y.min()),
        force_max=float(y.max()),
    )


def fit_logs(stamp: Array, force: Array, gauge_stamp: Array, gauge: Array, max_lag: float) -> GaugeFit:
    """As `fit`, for a gauge with its own log and rate, whose clock is off by up to `max_lag` [s].

    The lag minimizes the residual variance. Raises GaugeError, also where the best lag is at the end of its range.
    """
    if np.any(np.diff(gauge_stamp) <= 0.0):
        row = int(np.argmax(np.diff(gauge_stamp) <= 0.0)) + 1
        raise GaugeError(f"stamp {float(gauge_stamp[row])!r} of the reference is not later than the one before")

    def paired(lag: float) -> tuple[Array, Array]:
        at = stamp + lag
        inside = (at >= gauge_stamp[0]) & (at <= gauge_stamp[-1]) & np.isfinite(force)
        return force[inside], np.interp(at[inside], gauge_stamp, gauge)

    lag = _minimize(lambda lag: _residual_variance(*paired(lag)), max_lag) if max_lag > 0.0 else 0.0
    if max_lag > 0.0 and abs(lag) > LAG_LIMIT * max_lag and paired(lag)[0].size >= MIN_COMMON_SAMPLES:
        raise GaugeError(f"the logs fit best {lag:+.3g} s apart, at the end of the range searched; align their stamps")
    return replace(fit(*paired(lag)), lag=lag)


def _residual_variance(x: Array, y: Array) -> float:
    """Variance of y about its regression line on x."""
    if x.size < MIN_COMMON_SAMPLES:
        return float("inf")
    (xx, xy), (_, yy) = np.cov(x, y)
    return float(yy - xy**2 / xx) if xx > 0.0 else float("inf")


def _minimize(cost: Callable[[float], float], limit: float) -> float:
    """Minimum of `cost` within +-limit by grids, each a tenth as wide as the one before."""
    centre, width = 0.0, limit
    for _ in range(4):
        grid = np.clip(np.linspace(centre - width, centre + width, 41), -limit, limit)
        centre = float(grid[np.argmin([cost(float(lag)) for lag in grid])])
        width /= 10.0
    return centre


def _hac_covariance(design: Array, residual: Array) -> Array:
    """Covariance of least-squares coefficients under autocorrelated residuals (Newey and West, 1987), (2, 2)."""
    inverse = np.linalg.inv(design.T @ design)
    score = design * residual[:, None]
    spectral = score.T @ score
    bandwidth = _bandwidth(residual)
    for lag in range(1, bandwidth + 1):
        weight = 1.0 - lag / (bandwidth + 1.0)
        cross = score[lag:].T @ score[:-lag]
        spectral += weight * (cross + cross.T)
    fraction = bandwidth / residual.size  # of the record; fixed-b critical value of Kiefer and Vogelsang (2005)
    widening = 1.0 + (2.9694 * fraction + 0.4160 * fraction**2 - 0.5324 * fraction**3) / 1.96
    return np.asarray(inverse @ spectral @ inverse) * widening**2


def _bandwidth(residual: Array) -> int:
    """Lags in the covariance: a multiple of the lag [samples] at which the autocorrelation has fallen to 1/e."""
    size = residual.size
    spectrum = np.abs(np.fft.rfft(residual, 2 * size)) ** 2
    correlation = np.fft.irfft(spectrum)[: size // 4 + 1]
    if correlation[0] <= 0.0:
        return 0
    below = np.flatnonzero(correlation < correlation[0] / np.e)
    return int(min(CORRELATION_TIMES * (below[0] if below.size else size // 4), size // 4))
