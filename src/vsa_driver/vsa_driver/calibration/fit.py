"""Scale and offset of a force sensor against a reference gauge, section VI of the paper."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from vsa_common.types import Array

_FEWEST = 10  # samples in common
_SPREAD = 20.0  # the force must vary by so many times the sensor's noise


class GaugeError(ValueError):
    """The two logs do not determine a calibration; the text says why."""


@dataclass(frozen=True)
class GaugeFit:
    """reference = scale * force + offset, with what is left over."""

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
    """Straight line from force [N] to reference [N], taken at the same instants.

    Standard deviations allow for residuals that are correlated in time, as hysteresis and filters make them
    (Newey and West, 1987). Raises GaugeError.
    """
    finite = np.isfinite(force) & np.isfinite(reference)
    x, y = force[finite], reference[finite]
    if x.size < _FEWEST:
        raise GaugeError(f"{x.size} samples in common, expected at least {_FEWEST}")
    noise = float(np.std(np.diff(x, 2))) / np.sqrt(6.0)  # a second difference of white noise has six times its variance
    if not np.std(x) > _SPREAD * noise:
        spread = f"force varies by {np.std(x):.3g} N only, at {noise:.3g} N of noise"
        raise GaugeError(f"{spread}; load the sensor over its range, slowly")
    mean = x.mean()
    design = np.column_stack([x - mean, np.ones_like(x)])
    (scale, level), *_ = np.linalg.lstsq(design, y, rcond=None)
    residual = y - design @ np.array([scale, level])
    covariance = _sandwich(design, residual)
    back = np.array([[1.0, 0.0], [-mean, 1.0]])  # offset = level - scale * mean
    covariance = back @ covariance @ back.T
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
    """As `fit`, for a gauge that was logged elsewhere, at its own rate, with a clock off by up to `max_lag` [s].

    The lag is the one that leaves least over. Raises GaugeError, also where the best lag is at the end of its range.
    """
    if np.any(np.diff(gauge_stamp) <= 0.0):
        row = int(np.argmax(np.diff(gauge_stamp) <= 0.0)) + 1
        raise GaugeError(f"stamp {float(gauge_stamp[row])!r} of the reference is not later than the one before")

    def paired(lag: float) -> tuple[Array, Array]:
        at = stamp + lag
        inside = (at >= gauge_stamp[0]) & (at <= gauge_stamp[-1]) & np.isfinite(force)
        return force[inside], np.interp(at[inside], gauge_stamp, gauge)

    lag = _least(lambda lag: _left_over(*paired(lag)), max_lag) if max_lag > 0.0 else 0.0
    if max_lag > 0.0 and abs(lag) > 0.99 * max_lag and paired(lag)[0].size >= _FEWEST:
        raise GaugeError(f"the logs fit best {lag:+.3g} s apart, at the end of the range searched; align their stamps")
    return replace(fit(*paired(lag)), lag=lag)


def _left_over(x: Array, y: Array) -> float:
    """Variance of y that no straight line in x explains."""
    if x.size < _FEWEST:
        return float("inf")
    (xx, xy), (_, yy) = np.cov(x, y)
    return float(yy - xy**2 / xx) if xx > 0.0 else float("inf")


def _least(cost: Callable[[float], float], reach: float) -> float:
    """Where `cost` is least within +-reach: grids, each a tenth as wide as the last."""
    centre, width = 0.0, reach
    for _ in range(4):
        grid = np.clip(np.linspace(centre - width, centre + width, 41), -reach, reach)
        centre = float(grid[np.argmin([cost(float(lag)) for lag in grid])])
        width /= 10.0
    return centre


def _sandwich(design: Array, residual: Array) -> Array:
    bread = np.linalg.inv(design.T @ design)
    score = design * residual[:, None]
    meat = score.T @ score
    reach = _memory(residual)
    for lag in range(1, reach + 1):
        weight = 1.0 - lag / (reach + 1.0)
        cross = score[lag:].T @ score[:-lag]
        meat += weight * (cross + cross.T)
    share = reach / residual.size  # of the record that is remembered; widens as Kiefer and Vogelsang (2005) tabulate
    wider = 1.0 + (2.9694 * share + 0.4160 * share**2 - 0.5324 * share**3) / 1.96
    return np.asarray(bread @ meat @ bread) * wider**2


def _memory(residual: Array) -> int:
    """How many samples residuals remember: eight times the lag at which their correlation has fallen to 1/e."""
    size = residual.size
    spectrum = np.abs(np.fft.rfft(residual, 2 * size)) ** 2
    correlation = np.fft.irfft(spectrum)[: size // 4 + 1]
    if correlation[0] <= 0.0:
        return 0
    below = np.flatnonzero(correlation < correlation[0] / np.e)
    return int(min(8 * (below[0] if below.size else size // 4), size // 4))
