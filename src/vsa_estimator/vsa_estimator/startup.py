"""Start values from the first seconds: a grid over k2, and for each of its values a linear regression of the force.

With k2 given, the force of eq. (6) is linear in the other coefficients but for the damper's clip at v*. Rows come from
overlapping windows, so that they share noise; generalised least squares weighs them by their exact covariance. What
noise of the motion alone pretends to know is taken off the normal equations again (corrected least squares, Fuller,
"Measurement error models", 1987): on a single sweep of the stroke it would settle the damper, wrongly.
All of it is cut into slices of a fraction of a millisecond: no sample has to wait for more.
"""

from dataclasses import dataclass

import numpy as np
from vsa_estimator.filter import REST_SPEED
from vsa_estimator.model import COULOMB_SPEED, UNBOUNDED_SPEED, Array
from vsa_estimator.rows import BAND, DRAWS, LEAST_ROWS, Rows, Slices, whiten
from vsa_estimator.settings import Initial

REVERSAL_FORCE = 0.3  # the Coulomb law's error in a row near a reversal [N] ...
REVERSAL_SPEED = 0.3e-3  # ... which is this wide [m/s]
MEMBERS = 15
SPAN = 0.7  # half-width of the first grid, in ln k2
PASSES = 6
INFLATION = 1.2  # of the regression's covariance: the damper's clip and the smoothing are known only so well
PRETENCE = 0.1  # share of noise in what is known of a direction, above which nothing is


@dataclass(frozen=True)
class Fit:
    """Posterior of [s k2 d1 d2 M F0 d0] given all rows."""

    mean: Array
    covariance: Array
    ln_k2_std: float
    stroke: float  # [m]
    acceleration: float  # root mean square [m/s^2]


@dataclass(frozen=True)
class _Problem:
    """Rows that move, and what does not change between passes."""

    rows: Rows
    dx: Array
    force_variance: float
    deflection_variance: float
    reversal_variance: Array
    blur: Array  # width of a reversal, with what smoothing and noise add [m/s]
    friction: Array  # expected sign of the speed, as far as the rows tell it

    @classmethod
    def of(cls, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float) -> "_Problem | None":
        moving = np.abs(rows.velocity) > REST_SPEED
        if np.count_nonzero(moving) < LEAST_ROWS:
            return None
        kept = rows.part(moving)
        # A smoothed reversal is as wide as the window's change of speed.
        width = REVERSAL_SPEED**2 + (0.7 * kept.acceleration * kept.half_width) ** 2
        reversal = (REVERSAL_FORCE * np.exp(-(kept.velocity**2) / width)) ** 2
        speed_variance = deflection_noise_std**2 * kept.shared[:, 0, 1, 1]
        blur = np.sqrt(COULOMB_SPEED**2 + 1.5 * speed_variance + (0.5 * kept.acceleration * kept.half_width) ** 2)
        friction = np.tanh(kept.velocity / blur)
        return cls(
            kept, kept.deflection - reference, force_noise_std**2, deflection_noise_std**2, reversal, blur, friction
        )  # fmt: skip

    def covariance(self, sigma: Array, damping: Array, mass: float) -> Array:
        """Of the rows' forces [N^2] as `whiten` takes it, given the slopes by which noise of the motion enters them."""
        rows = self.rows
        slopes = np.column_stack([sigma, damping, np.full_like(sigma, mass)])
        result = np.zeros((sigma.size, BAND + 1))
        for b in range(min(BAND + 1, sigma.size)):
            later, earlier = slopes[b:], slopes[: sigma.size - b]
            apart = rows.place[b:] - rows.place[: sigma.size - b]
            shared = rows.shared[np.arange(b, sigma.size), np.minimum(apart, BAND)]
            through_motion = np.einsum("ni,nij,nj->n", later, shared, earlier)
            found = self.force_variance * shared[:, 0, 0] + self.deflection_variance * through_motion
            result[b:, b] = np.where(apart <= BAND, found, 0.0)
        result[:, 0] += self.reversal_variance
        return result


def _maximum_speed(d1: float, d2: float) -> float:
    return float(min(np.sqrt(d1 / (-3.0 * d2)), UNBOUNDED_SPEED)) if d2 < -1e5 else UNBOUNDED_SPEED


class _Bank:
    """Members over k2, refined pass by pass from one assumption of v*."""

    def __init__(self, prior: "Regression", problem: _Problem, speed: float) -> None:
        self._prior = prior
        self._problem = problem
        self._speed = speed
        self._ln_k2 = prior.ln_k2 + np.linspace(-SPAN, SPAN, MEMBERS)
        self._covariance = problem.covariance(np.full_like(problem.dx, 1e4), np.full_like(problem.dx, 4e3), 0.0)
        self.cost = np.inf

    def refine(self, last: bool) -> Slices[None]:
        """Regress for every member, weigh them, then zoom in and refresh v*, slopes and row variances."""
        k2 = np.exp(self._ln_k2)
        growth = np.exp(np.clip(k2[:, None] * self._problem.dx, -30.0, 12.0))
        yield
        design, pretended, target = yield from self._whitened(growth, k2)
        yield
        chi2, chi2_of_truth = self._solve(design, pretended, target)
        yield
        self._inflation = INFLATION * max(1.0, float(chi2.min()) / max(target.size - 6, 1))
        best, mean, std = self._weigh(chi2, chi2_of_truth)
        self._used = self._ln_k2
        self.ln_k2_std = std
        self._refresh(best, growth[best])
        if not last:
            step = self._ln_k2[1] - self._ln_k2[0]
            width = min(3.0 * std + 0.3 * step, SPAN)
            self._ln_k2 = mean + width * np.linspace(-1.0, 1.0, MEMBERS)

    def _whitened(self, growth: Array, k2: Array) -> Slices[tuple[Array, Array, Array]]:
        """Design (MEMBERS, n, 6), what noise of its own pretends to know (MEMBERS, 6, 6), and the force (n,)."""
        rows, v = self._problem.rows, self._problem.rows.velocity
        c = np.clip(v, -self._speed, self._speed)
        linear = np.column_stack([c, c**3, rows.acceleration, np.ones(v.size), self._problem.friction])
        noise = yield from self._regressor_noise(growth, k2, c)
        columns = np.column_stack([growth.T, linear, rows.force, *noise])
        yield
        whiten(self._covariance, columns)
        pretended = np.zeros((MEMBERS, 6, 6))
        for draw in range(DRAWS):
            first = MEMBERS + 6 + draw * (MEMBERS + 5)
            yield
            faked = self._designs(columns[:, first : first + MEMBERS + 5])
            pretended += faked.transpose(0, 2, 1) @ faked / DRAWS
        yield
        return self._designs(columns[:, : MEMBERS + 5]), pretended, columns[:, MEMBERS + 5]

    def _solve(self, design: Array, pretended: Array, target: Array) -> tuple[Array, Array]:
        """Corrected least squares with the prior; chi2 of each member, and what it would be without pretence."""
        prior = self._prior.mean / self._prior.std
        measured = design.transpose(0, 2, 1) @ design
        values, vectors = np.linalg.eigh(measured - pretended)
        told = np.einsum("bij,bik,bkj->bj", vectors, measured, vectors)
        basis = vectors * (values > (1.0 - PRETENCE) * told)[:, None, :]
        projector = basis @ basis.transpose(0, 2, 1)
        right = np.einsum("bij,bj->bi", projector, design.transpose(0, 2, 1) @ target) + prior
        self._normal = (basis * np.maximum(values, 0.0)[:, None, :]) @ basis.transpose(0, 2, 1) + np.eye(6)
        self._spread = projector @ measured @ projector + np.eye(6)
        scaled = np.linalg.solve(self._normal, right[:, :, None])[:, :, 0]
        self._members = scaled * self._prior.std
        residual = target - np.einsum("bij,bj->bi", design, scaled)
        chi2 = (residual**2).sum(1) + ((scaled - prior) ** 2).sum(1)
        faked = np.einsum("bi,bij,bj->b", scaled, pretended, scaled)
        return chi2, chi2 - faked + faked[int(np.argmin(chi2))]

    def _weigh(self, chi2: Array, chi2_of_truth: Array) -> tuple[int, float, float]:
        """The best member, mean and standard deviation of ln k2."""
        distance = ((self._ln_k2 - self._prior.ln_k2) / self._prior.ln_k2_std) ** 2
        cost = chi2_of_truth / self._inflation + distance + np.where(self._members[:, 0] > 0.0, 0.0, 1e6)
        best = int(np.argmin(cost))
        self._weights = np.exp(-0.5 * (cost - cost[best]))
        self._weights /= self._weights.sum()
        self.cost = float(chi2[best] + distance[best])
        return best, *self._moments(cost, best)

    def _refresh(self, best: int, growth: Array) -> None:
        """v* and the rows' covariance by the best member, whose spring grows by `growth` at each row."""
        k1, d1, d2, mass = self._members[best, :4]
        sigma = k1 * np.exp(self._ln_k2[best]) * growth if k1 > 0.0 else np.full(growth.size, 1e4)
        self._speed = _maximum_speed(max(d1, 300.0), d2)
        # Noise of the speed counts by the damping at its most, or a fit too sure of a soft damper would believe itself.
        d1_std = float(np.sqrt(self._covariances()[best, 1, 1]))
        damping = np.full(growth.size, min(max(d1 + 2.0 * d1_std, 300.0), 2e4))
        self._covariance = self._problem.covariance(sigma, damping, max(mass, 0.0))

    def _designs(self, columns: Array) -> Array:
        """Design of each member, in units of the prior's standard deviations, from a growth each and what all share."""
        design = np.empty((MEMBERS, columns.shape[0], 6))
        design[:, :, 0] = columns[:, :MEMBERS].T
        design[:, :, 1:] = columns[:, MEMBERS:]
        design *= self._prior.std
        return design

    def _regressor_noise(self, growth: Array, k2: Array, c: Array) -> Slices[list[Array]]:
        """What white noise of the deflection does to the columns, one (n, MEMBERS + 5) a draw."""
        deflection, velocity, acceleration = np.sqrt(self._problem.deflection_variance) * self._problem.rows.noise
        v, blur = self._problem.rows.velocity, self._problem.blur
        moving = np.abs(v) < self._speed
        found = []
        for dx, dv, da in zip(deflection.T, velocity.T, acceleration.T, strict=True):
            yield
            nothing = np.zeros_like(dx)
            friction = 0.5 * (np.tanh((v + dv) / blur) - np.tanh((v - dv) / blur))
            linear = np.column_stack([moving * dv, 3.0 * c * c * moving * dv, da, nothing, friction])
            found.append(np.column_stack([(k2[:, None] * growth * dx).T, linear]))
        return found

    def _covariances(self) -> Array:
        """Of every member's coefficients [k1 d1 d2 M F0 d0], (MEMBERS, 6, 6)."""
        inverse = np.linalg.inv(self._normal)
        scale = self._inflation * np.outer(self._prior.std, self._prior.std)
        return np.asarray(inverse @ self._spread @ inverse * scale)

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
        for weight, scale, member in zip(self._weights, k1, self._covariances(), strict=True):
            gradient = np.zeros((7, 6))
            gradient[0, 0] = 1.0 / scale
            gradient[2:, 1:] = np.eye(5)
            covariance += weight * gradient @ member @ gradient.T
        rows = self._problem.rows
        acceleration = float(np.sqrt(np.mean(rows.acceleration**2)))
        return Fit(mean, covariance, self.ln_k2_std, float(np.ptp(rows.deflection)), acceleration)


class Regression:
    """The bank over k2."""

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

    def work(
        self, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float
    ) -> Slices[Fit | None]:
        """Generator of slices; its return value holds what two starts found, one for each side of v*.

        Both count by how well they explain the force: where a damper at its maximum explains it as well as one below,
        the fit is as wide as the two are apart.
        """
        problem = _Problem.of(rows, reference, force_noise_std, deflection_noise_std)
        if problem is None:
            return None
        widest = _maximum_speed(self.mean[1], self.mean[2])
        banks = []
        for speed in (widest, 0.5 * widest):
            bank = _Bank(self, problem, speed)
            for index in range(PASSES):
                yield from bank.refine(last=index == PASSES - 1)
                yield
            banks.append(bank)
        costs = np.array([bank.cost for bank in banks])
        weights = np.exp(-0.5 * (costs - costs.min()))
        fits = []
        for bank in banks:
            fits.append(bank.fit())
            yield
        return _mixed(fits, weights / weights.sum())


def _mixed(fits: list[Fit], weights: Array) -> Fit:
    """One fit with the mean and the covariance of several."""
    mean = np.einsum("f,fi->i", weights, [fit.mean for fit in fits])
    apart = np.array([fit.mean for fit in fits]) - mean
    covariance = np.einsum("f,fij->ij", weights, [fit.covariance for fit in fits])
    covariance = covariance + np.einsum("f,fi,fj->ij", weights, apart, apart)
    ln_k2_std = float(np.sqrt(weights @ [fit.ln_k2_std**2 for fit in fits] + weights @ (apart[:, 1] / mean[1]) ** 2))
    return Fit(mean, covariance, ln_k2_std, fits[0].stroke, fits[0].acceleration)
