"""Start values from the first seconds: a grid over k2, and for each of its values a linear regression of the force.

With k2 given, the force of eq. (6) is linear in the other coefficients but for the damper's clip at v*. Rows come from
overlapping windows, so that they share noise; generalised least squares weighs them by their exact covariance. What
noise of the motion alone pretends to know is taken off the normal equations again (corrected least squares, Fuller,
"Measurement error models", 1987): on a single sweep of the stroke it would settle the damper, wrongly.
All of it is cut into slices of a fraction of a millisecond: no sample has to wait for more.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from vsa_common.types import Array
from vsa_estimator.initialization.problem import Problem
from vsa_estimator.initialization.windows import DRAWS, Rows, Slices, whiten
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.force_law import UNBOUNDED_SPEED

MEMBERS = 15
SPAN = 0.7  # half-width of the first grid, in ln k2
PASSES = 6
INFLATION = 1.2  # of the regression's covariance: the damper's clip and the smoothing are known only so well
PRETENCE = 0.1  # share of noise in what is known of a direction, above which nothing is ...
GUESSED = 0.25  # ... and above which it does not even count in favour of a k2
LEAP = 2.5  # standard deviations of stiffness or k2, from one fit to the next, that no chance explains ...
FADING = 0.7  # ... and share of the doubt about it that is left one fit later


@dataclass(frozen=True)
class Fit:
    """Posterior of [s k2 d1 d2 M F0 d0] given all rows."""

    mean: Array
    covariance: Array
    ln_k2_std: float
    stroke: float  # [m]
    acceleration: float  # root mean square [m/s^2]
    doubt: Array = field(default_factory=lambda: np.zeros(7))  # what a leap may have changed wrongly

    def after(self, before: "Fit | None") -> "Fit":
        """This fit; where it leaps from the one `before`, over all but the last of the same rows, as wide as the leap.

        What more rows tell lies within what fewer left open, but for chance. Where a first sweep of the stroke ends a
        regression may take the damper for the spring, and be sure of it for some seconds: so long the doubt lasts.
        """
        if before is None:
            return self
        leap = self.mean - before.mean
        leaps = np.any(np.abs(leap[:2]) > LEAP * np.sqrt(np.diag(before.covariance)[:2]))
        doubt = leap if leaps else FADING * before.doubt
        ln_k2_std = float(np.hypot(self.ln_k2_std, doubt[1] / self.mean[1]))
        covariance = self.covariance + np.outer(doubt, doubt)
        return replace(self, covariance=covariance, ln_k2_std=ln_k2_std, doubt=doubt)


def _maximum_speed(d1: float, d2: float) -> float:
    return float(min(np.sqrt(d1 / (-3.0 * d2)), UNBOUNDED_SPEED)) if d2 < -1e5 else UNBOUNDED_SPEED


class _Bank:
    """Members over k2, refined pass by pass from one assumption of v*."""

    def __init__(self, prior: "Regression", problem: Problem, speed: float) -> None:
        self._prior = prior
        self._problem = problem
        self._speed = speed
        self._ln_k2 = prior.ln_k2 + np.linspace(-SPAN, SPAN, MEMBERS)
        self._covariance = problem.covariance(np.full_like(problem.dx, 1e4), 4e3, 0.0)
        self.cost = np.inf

    def refine(self, last: bool) -> Slices[None]:
        """Regress for every member, weigh them, then zoom in and refresh v*, slopes and row variances."""
        k2 = np.exp(self._ln_k2)
        growth = np.exp(np.clip(k2[:, None] * self._problem.dx, -30.0, 12.0))
        yield
        design, pretended, target = yield from self._whitened(growth, k2)
        yield
        chi2, chi2_of_truth = yield from self._solve(design, pretended, target)
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
        """Design (n, MEMBERS + 5), what noise of its own pretends to know (MEMBERS, 6, 6), and the force (n,).

        The members' designs differ in their first column: a growth each, then five columns that all share.
        """
        rows, v = self._problem.rows, self._problem.rows.velocity
        c = np.clip(v, -self._speed, self._speed)
        wide = MEMBERS + 5
        columns = np.empty((v.size, wide + 1 + DRAWS * wide))
        columns[:, :MEMBERS] = growth.T
        columns[:, MEMBERS:wide] = np.column_stack(
            [c, c**3, rows.acceleration, np.ones(v.size), self._problem.friction]
        )  # fmt: skip
        columns[:, wide] = rows.force
        drawn = columns[:, wide + 1 :].reshape(v.size, DRAWS, wide)
        yield
        self._draw(drawn, growth, k2, c)
        yield
        whiten(self._covariance, columns)
        yield
        pretended = np.mean([self._normal_of(drawn[:, draw]) for draw in range(DRAWS)], axis=0)
        return columns[:, :wide], pretended, columns[:, wide]

    def _solve(self, design: Array, pretended: Array, target: Array) -> Slices[tuple[Array, Array]]:
        """Corrected least squares with the prior; chi2 of each member, and what it would be without pretence.

        A direction of which noise pretends to know too much stays at the prior. But for what a member is worth it is
        free: else the members that suit the prior's mass win, and k2 is sure of what nothing has told.
        """
        measured = self._normal_of(design)
        values, vectors = np.linalg.eigh(measured - pretended)
        yield
        told = (vectors * (measured @ vectors)).sum(1)
        right = np.empty((MEMBERS, 6))
        right[:, 0], right[:, 1:] = np.split(target @ design, [MEMBERS])
        right *= self._prior.std
        free, _, _ = self._solved(values, vectors, values > (1.0 - GUESSED) * told, right)
        scaled, self._normal, projector = self._solved(values, vectors, values > (1.0 - PRETENCE) * told, right)
        yield
        self._spread = projector @ measured @ projector + np.eye(6)
        self._members = scaled * self._prior.std
        found = free * self._prior.std
        own, shared = design[:, :MEMBERS] * found[:, 0], design[:, MEMBERS:] @ found[:, 1:].T
        residual = target[:, None] - own - shared
        chi2 = (residual**2).sum(0) + ((free - self._prior.scaled) ** 2).sum(1)
        faked = np.einsum("bi,bij,bj->b", free, pretended, free)
        return chi2, chi2 - faked + faked[int(np.argmin(chi2))]

    def _solved(
        self, values: Array, vectors: Array, kept: NDArray[np.bool_], right: Array
    ) -> tuple[Array, Array, Array]:
        """Solution within the directions `kept` and the prior's elsewhere, its normal matrix and the projector."""
        basis = vectors * kept[:, None, :]
        projector = basis @ basis.transpose(0, 2, 1)
        normal = (basis * np.maximum(values, 0.0)[:, None, :]) @ basis.transpose(0, 2, 1) + np.eye(6)
        within = np.einsum("bij,bj->bi", projector, right) + self._prior.scaled
        return np.linalg.solve(normal, within[:, :, None])[:, :, 0], normal, projector

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
        damping = min(max(d1 + 2.0 * d1_std, 300.0), 2e4)
        self._covariance = self._problem.covariance(sigma, damping, max(mass, 0.0))

    def _normal_of(self, design: Array) -> Array:
        """Each member's design times itself (MEMBERS, 6, 6), in units of the prior's standard deviations."""
        own, shared = design[:, :MEMBERS], design[:, MEMBERS:]
        normal = np.empty((MEMBERS, 6, 6))
        normal[:, 0, 0] = np.einsum("nb,nb->b", own, own)
        normal[:, 0, 1:] = normal[:, 1:, 0] = own.T @ shared
        normal[:, 1:, 1:] = shared.T @ shared
        return normal * np.outer(self._prior.std, self._prior.std)

    def _draw(self, columns: Array, growth: Array, k2: Array, c: Array) -> None:
        """Into (n, DRAWS, MEMBERS + 5) what white noise of the deflection does to the design."""
        problem = self._problem
        dx, dv, da = problem.noise
        moving = (np.abs(problem.rows.velocity) < self._speed).astype(float)
        steep = (k2[:, None] * growth).T
        np.multiply(steep[:, None, :], dx[:, :, None], out=columns[:, :, :MEMBERS])
        columns[:, :, MEMBERS] = moving[:, None] * dv
        columns[:, :, MEMBERS + 1] = (3.0 * c * c * moving)[:, None] * dv
        columns[:, :, MEMBERS + 2] = da
        columns[:, :, MEMBERS + 3] = 0.0
        columns[:, :, MEMBERS + 4] = problem.friction_noise

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
        self.scaled = self.mean / self.std
        self.ln_k2 = float(np.log(initial.k2))
        self.ln_k2_std = initial.k2_std / initial.k2

    def work(
        self, rows: Rows, reference: float, force_noise_std: float, deflection_noise_std: float
    ) -> Slices[Fit | None]:
        """Generator of slices; its return value holds what two starts found, one for each side of v*.

        Both count by how well they explain the force: where a damper at its maximum explains it as well as one below,
        the fit is as wide as the two are apart.
        """
        problem = Problem.of(rows, reference, force_noise_std, deflection_noise_std)
        if problem is None:
            return None
        widest = _maximum_speed(self.mean[1], self.mean[2])
        banks = []
        for speed in (widest, 0.5 * widest):
            yield
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
