"""Start values from the first seconds: a grid over k2, and for each of its values a linear regression of the force.

With k2 given, the force of eq. (6) is linear in the other coefficients but for the damper's clip at v*.
Every pass is one slice of work, so that no sample has to wait for the whole of it.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from vsa_estimator.filter import REST_SPEED
from vsa_estimator.model import COULOMB_SPEED, UNBOUNDED_SPEED, Array
from vsa_estimator.settings import Initial

REVERSAL_FORCE = 0.3  # the Coulomb law's error in a row near a reversal [N] ...
REVERSAL_SPEED = 0.3e-3  # ... which is this wide [m/s]
MEMBERS = 15
_MASS = 3  # place of the mass among the regression's columns
SPAN = 0.7  # half-width of the first grid, in ln k2
PASSES = 6
INFLATION = 1.5  # of the regression's covariance: neighbouring rows share samples
LEAST_ROWS = 8
MOST_ROWS = 400


@dataclass(frozen=True)
class Rows:
    """Smoothed motion and force, one row for each place of the smoothing window."""

    deflection: Array
    velocity: Array
    acceleration: Array
    force: Array
    smoothing: Array  # (n, 4): |c0|^2, |c1|^2, |c2|^2, c0.c2 of the smoothing and derivative weights
    half_width: float  # [s]


@dataclass(frozen=True)
class Fit:
    """Posterior of [s k2 d1 d2 M F0 d0] given all rows."""

    mean: Array
    covariance: Array
    ln_k2_std: float
    stroke: float  # [m]


Work = Generator[None, None, Fit | None]


def smooth(
    time: Array, deflection: Array, force: Array, period: float, noise_std: float, jerk_density: float
) -> Rows | None:
    """Local cubics through deflection and force over one window; None where there is too little data.

    The window is as long as the motion allows: its bias and its noise meet near the frequency w_c.
    """
    w_c = (jerk_density / (noise_std**2 * period)) ** (1.0 / 6.0)
    half = int(np.clip(round(min(0.5, 3.3 / w_c) / period), 3, max(3, time.size // 4)))
    stride = max(1, half // 2, -(-time.size // MOST_ROWS))
    centre = np.arange(half, time.size - half, stride)
    if centre.size == 0:
        return None
    centre = centre[time[centre + half] - time[centre - half] < (2 * half + 0.5) * period * 1.1]
    if centre.size < LEAST_ROWS:
        return None
    pick = centre[:, None] + np.arange(-half, half + 1)
    scale = half * period
    u = (time[pick] - time[centre][:, None]) / scale
    basis = np.stack([np.ones_like(u), u, u * u, u * u * u], axis=1)
    inverse = np.linalg.inv(basis @ basis.transpose(0, 2, 1))
    weights = inverse[:, :3] @ basis
    weights[:, 1] /= scale
    weights[:, 2] *= 2.0 / scale**2
    motion = np.einsum("nij,nj->ni", weights, deflection[pick])
    squares = np.einsum("nij,nij->ni", weights, weights)
    mixed = np.einsum("nj,nj->n", weights[:, 0], weights[:, 2])
    return Rows(
        motion[:, 0], motion[:, 1], motion[:, 2], np.einsum("nj,nj->n", weights[:, 0], force[pick]),
        np.column_stack([squares, mixed]), half * period,
    )  # fmt: skip


@dataclass(frozen=True)
class _Problem:
    """Rows that move, and what does not change between passes."""

    rows: Rows
    dx: Array
    force_variance: Array
    deflection_variance: float
    reversal_variance: Array

    @classmethod
    def of(cls, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float) -> "_Problem | None":
        moving = np.abs(rows.velocity) > REST_SPEED
        if np.count_nonzero(moving) < LEAST_ROWS:
            return None
        v, a, smoothing = rows.velocity[moving], rows.acceleration[moving], rows.smoothing[moving]
        kept = Rows(rows.deflection[moving], v, a, rows.force[moving], smoothing, rows.half_width)
        # A smoothed reversal is as wide as the window's change of speed.
        width = REVERSAL_SPEED**2 + (0.7 * a * rows.half_width) ** 2
        reversal = (REVERSAL_FORCE * np.exp(-(v**2) / width)) ** 2
        return cls(
            kept, kept.deflection - reference, force_noise_std**2 * smoothing[:, 0], deflection_noise_std**2, reversal
        )

    def variance(self, sigma: Array, damping: Array, mass: float) -> Array:
        """Of a row's force [N^2], given the slopes by which noise of the motion enters it."""
        c0, c1, c2, mixed = self.rows.smoothing.T
        through_motion = sigma**2 * c0 + damping**2 * c1 + mass**2 * c2 + 2.0 * sigma * mass * mixed
        return self.force_variance + self.deflection_variance * through_motion + self.reversal_variance


def _maximum_speed(d1: float, d2: float) -> float:
    return float(min(np.sqrt(d1 / (-3.0 * d2)), UNBOUNDED_SPEED)) if d2 < -1e5 else UNBOUNDED_SPEED


class _Bank:
    """Members over k2, refined pass by pass from one assumption of v*."""

    def __init__(self, prior: "Regression", problem: _Problem, speed: float) -> None:
        self._prior = prior
        self._problem = problem
        self._speed = speed
        self._ln_k2 = prior.ln_k2 + np.linspace(-SPAN, SPAN, MEMBERS)
        self._variance = problem.variance(np.full_like(problem.dx, 1e4), np.full_like(problem.dx, 4e3), 0.0)
        self.cost = np.inf
        self._std = prior.std.copy()

    def refine(self, last: bool) -> None:
        """Regress for every member, weigh them, then zoom in and refresh v*, slopes and row variances."""
        prior, rows, dx = self._prior, self._problem.rows, self._problem.dx
        v, a, n = rows.velocity, rows.acceleration, rows.velocity.size
        c = np.clip(v, -self._speed, self._speed)
        linear = np.column_stack([c, c**3, a, np.ones(n), np.tanh(v / COULOMB_SPEED)])
        growth = np.exp(np.clip(np.exp(self._ln_k2)[:, None] * dx, -30.0, 12.0))
        design = np.empty((MEMBERS, n, 6))
        design[:, :, 0] = growth
        design[:, :, 1:] = linear
        # Columns in units of the prior's standard deviations: the normal equations stay well conditioned.
        design *= self._std / np.sqrt(self._variance)[:, None]
        target = rows.force / np.sqrt(self._variance)
        self._normal = design.transpose(0, 2, 1) @ design + np.eye(6)
        right = design.transpose(0, 2, 1) @ target + prior.mean / self._std
        scaled = np.linalg.solve(self._normal, right[:, :, None])[:, :, 0]
        residual = target - np.einsum("bij,bj->bi", design, scaled)
        chi2 = (residual**2).sum(1) + ((scaled - prior.mean / self._std) ** 2).sum(1)
        self._members = scaled * self._std
        self._inflation = INFLATION * max(1.0, float(chi2.min()) / max(n - 6, 1))
        distance = (self._ln_k2 - prior.ln_k2) / prior.ln_k2_std
        cost = chi2 / self._inflation + distance**2 + np.where(self._members[:, 0] > 0.0, 0.0, 1e6)
        best = int(np.argmin(cost))
        self._weights = np.exp(-0.5 * (cost - cost[best]))
        self._weights /= self._weights.sum()
        mean, std = self._moments(cost, best)
        self.cost = float(cost[best] + np.log(self._variance).sum() / self._inflation)
        self._used = self._ln_k2
        self.ln_k2_std = std

        if self._mass_is_hidden(best):
            self._std[_MASS] = 1e-3 * prior.std[_MASS]
        k1, d1, d2, mass = self._members[best, :4]
        sigma = k1 * np.exp(self._ln_k2[best]) * growth[best] if k1 > 0.0 else np.full(n, 1e4)
        self._speed = _maximum_speed(max(d1, 300.0), d2)
        damping = np.clip(d1 + 3.0 * d2 * np.clip(v, -self._speed, self._speed) ** 2, 0.0, 2e4)
        self._variance = self._problem.variance(sigma, damping, max(mass, 0.0))
        if not last:
            step = self._ln_k2[1] - self._ln_k2[0]
            width = min(3.0 * std + 0.3 * step, SPAN)
            self._ln_k2 = mean + width * np.linspace(-1.0, 1.0, MEMBERS)

    def _mass_is_hidden(self, best: int) -> bool:
        """Whether noise of the acceleration counts where the acceleration itself says no more than the deflection.

        Noise in a regressor pulls its coefficient to zero, with confidence: then the mass keeps its start value.
        """
        noise = self._problem.deflection_variance * self._problem.rows.smoothing[:, 2]
        from_noise = float(np.sum(noise / self._variance)) * self._std[_MASS] ** 2
        beside_the_others = 1.0 / float(np.linalg.inv(self._normal[best])[_MASS, _MASS]) - 1.0
        return from_noise > 0.1 * beside_the_others

    def _moments(self, cost: Array, best: int) -> tuple[float, float]:
        """Mean and standard deviation of ln k2; from the parabola where the grid is too coarse to tell."""
        ln_k2, step = self._ln_k2, self._ln_k2[1] - self._ln_k2[0]
        mean = float(self._weights @ ln_k2)
        std = float(np.sqrt(self._weights @ (ln_k2 - mean) ** 2))
        if 0 < best < MEMBERS - 1 and std < step:
            bend = (cost[best + 1] - 2.0 * cost[best] + cost[best - 1]) / step**2
            slope = (cost[best + 1] - cost[best - 1]) / (2.0 * step)
            if bend > 0.0:
                mean = float(ln_k2[best] - np.clip(slope / bend, -step, step))
                std = max(float(np.sqrt(2.0 / bend)), 1e-4)
        return mean, std

    def fit(self) -> Fit:
        """Mean and covariance of [s k2 d1 d2 M F0 d0], matched to the moments of all members."""
        k2 = np.exp(self._used)
        k1 = np.maximum(self._members[:, 0], 1e-6)
        states = np.column_stack([np.log(k1 * k2), k2, self._members[:, 1:]])
        mean = self._weights @ states
        apart = states - mean
        covariance = (self._weights[:, None] * apart).T @ apart
        inner = np.linalg.inv(self._normal) * self._inflation * np.outer(self._std, self._std)
        for weight, scale, member in zip(self._weights, k1, inner, strict=True):
            gradient = np.zeros((7, 6))
            gradient[0, 0] = 1.0 / scale
            gradient[2:, 1:] = np.eye(5)
            covariance += weight * gradient @ member @ gradient.T
        if self._std[_MASS] < self._prior.std[_MASS]:
            covariance[1 + _MASS, 1 + _MASS] = self._prior.std[_MASS] ** 2
        return Fit(mean, covariance, self.ln_k2_std, float(np.ptp(self._problem.rows.deflection)))


class Regression:
    """The bank: `work` yields after every slice and returns the Fit, or None where the rows do not suffice."""

    def __init__(self, initial: Initial) -> None:
        """The start values with their standard deviations are the prior."""
        self.mean = np.array(
            [0.0, initial.d1, initial.d2, initial.inertia, initial.force_offset, initial.coulomb_friction]
        )
        self.std = np.array(
            [1e3, initial.d1_std, initial.d2_std, initial.inertia_std, initial.force_offset_std,
             initial.coulomb_friction_std]
        )  # fmt: skip
        self.ln_k2 = float(np.log(initial.k2))
        self.ln_k2_std = initial.k2_std / initial.k2

    def work(self, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float) -> Work:
        """Generator of slices; its return value is the best of two starts, one for each side of v*."""
        problem = _Problem.of(rows, reference, force_noise_std, deflection_noise_std)
        if problem is None:
            return None
        widest = _maximum_speed(self.mean[1], self.mean[2])
        best: _Bank | None = None
        for speed in (widest, 0.5 * widest):
            bank = _Bank(self, problem, speed)
            for index in range(PASSES):
                bank.refine(last=index == PASSES - 1)
                yield
            if best is None or bank.cost < best.cost:
                best = bank
        assert best is not None
        return best.fit()
