"""Coefficients of a transmission from whole recordings, eqs. (18) and (19).

All but k2 enter the force, eqs. (2) to (6), linearly: k2 is found by nonlinear least squares over the fit of the rest
(variable projection), the rest by weighted pseudo-inverse. Positions, velocities and accelerations are smoothed, hence
noisy and coloured: their noise is taken out of the normal equations (errors in variables) and into the covariance.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from vsa_common.types import Array
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.offline.smoothed import LEAST_SAMPLES, Piece, prepare, smooth

NAMES = ("k2", "k1", "force_offset", "coulomb_friction", "d1", "d2", "inertia")
UNITS = ("1/m", "N", "N", "N", "N s/m", "N s^3/m^3", "kg")

PIECE = 6000  # samples smoothed at once
BENDING = (0.05, 30.0)  # k2 times the stroke is sought within [1]
BLOCK = 2.0  # residuals further apart than this are taken for independent [s]
STEPS = 3  # of the bias correction
K2, Q, F0, D0, D1, D2, M = range(7)


@dataclass(frozen=True)
class Identification:
    """Coefficients in the order of NAMES, SI, with covariance; what was left over."""

    values: Array  # (7,)
    covariance: Array  # (7, 7)
    deflection: Array  # of the rows used [m]
    velocity: Array  # [m/s]
    force: Array  # [N]
    residual: Array  # measured minus model [N]
    rows: int
    repeated: int  # force samples that repeated the one before and were left out
    misfit: float  # greatest ratio of a coefficient's variance to what white noise explains [1]

    def value(self, name: str) -> float:
        """One coefficient."""
        return float(self.values[NAMES.index(name)])

    def std(self, name: str) -> float:
        """Its standard deviation."""
        place = NAMES.index(name)
        return float(np.sqrt(self.covariance[place, place]))


def identify(recordings: Sequence[Recording]) -> Identification:
    """Coefficients of one transmission from all `recordings` of it together.

    Raises RecordingError where they hold too little to fit.
    """
    pieces, repeated = [], 0
    for recording in recordings:
        time, force, deflection, dropped = prepare(recording)
        repeated += dropped
        parts = max(1, -(-len(time) // PIECE))
        for part in np.array_split(np.arange(len(time)), parts):
            pieces.append(smooth(time[part], force[part], deflection[part]))
    reference, stroke = _range(pieces)
    theta = _start(pieces, reference, stroke)
    for _ in range(3):  # weights and the damper's greatest force depend on the result
        theta = _refined(pieces, reference, theta)
    covariance, misfit = _covariance(pieces, reference, theta)
    values, to_k1 = theta.copy(), np.eye(7)
    values[Q] = theta[Q] * np.exp(-theta[K2] * reference)
    to_k1[Q, Q], to_k1[Q, K2] = np.exp(-theta[K2] * reference), -reference * values[Q]
    rows = [_rows(piece, theta, reference) for piece in pieces]
    return Identification(
        values,
        to_k1 @ covariance @ to_k1.T,
        np.concatenate([piece.deflection[piece.used] for piece in pieces]),
        np.concatenate([piece.velocity[piece.used] for piece in pieces]),
        np.concatenate([piece.force[piece.used] for piece in pieces]),
        np.concatenate([residual[piece.used] for piece, (_, residual) in zip(pieces, rows, strict=True)]),
        int(sum(piece.used.sum() for piece in pieces)),
        repeated,
        misfit,
    )


def _range(pieces: Sequence[Piece]) -> tuple[float, float]:
    deflection = np.concatenate([piece.deflection[piece.used] for piece in pieces])
    if len(deflection) < LEAST_SAMPLES or np.ptp(deflection) == 0.0:
        raise RecordingError("expected a recording in which the transmission moves, found one at rest")
    return float(np.median(deflection)), float(np.ptp(deflection))


def _start(pieces: Sequence[Piece], reference: float, stroke: float) -> Array:
    """The best of a scan over k2."""
    scan = np.geomspace(*BENDING, 40) / stroke
    guess = np.r_[0.0, 1.0, np.zeros(5)]
    fits = [_project(pieces, reference, np.r_[k2, guess[1:]]) for k2 in scan]
    return min(fits, key=lambda fit: float(fit[1] @ fit[1]))[0]


def _project(pieces: Sequence[Piece], reference: float, theta: Array) -> tuple[Array, Array]:
    """Best linear coefficients for the k2 in `theta`, by weighted pseudo-inverse; the weighted residual."""
    rows, targets = [], []
    for piece in pieces:
        root = np.sqrt(_weights(piece, theta, reference)[0])[piece.used, 0]
        rows.append(_columns(piece, theta, reference)[piece.used, 1:] * root[:, None])
        targets.append(piece.force[piece.used] * root)
    a, f = np.concatenate(rows), np.concatenate(targets)
    scale = np.linalg.norm(a, axis=0)
    scale[scale == 0.0] = 1.0
    linear = np.linalg.lstsq(a / scale, f, rcond=1e-9)[0] / scale
    return np.r_[theta[K2], linear], f - a @ linear


def _refined(pieces: Sequence[Piece], reference: float, theta: Array) -> Array:
    """k2 by nonlinear least squares, the rest by eq. (19), then the bias by noisy motion taken out.

    Noise e of a row's motion is in its weighted columns and, through the force's slopes, in its residual. With
    covariance C their product is on average -d(weighted columns) C slopes (Stein's lemma); that is added back.
    """

    def residual(ln_k2: Array) -> Array:
        return _project(pieces, reference, np.r_[np.exp(ln_k2), theta[1:]])[1]

    solution = least_squares(residual, np.log(theta[:1]), xtol=1e-10, ftol=1e-12)
    theta, _ = _project(pieces, reference, np.r_[np.exp(solution.x), theta[1:]])
    refined = theta
    for _ in range(STEPS):
        step = np.zeros(7)
        for piece in pieces:
            columns, left = _rows(piece, refined, reference)
            weights, by_motion = _weights(piece, refined, reference)
            slopes = np.stack(_force_slopes(piece, refined, reference), axis=1)
            of_weighted = weights[:, 0, None, None] * _by_motion(piece, refined, reference)
            of_weighted += columns[:, :, None] * by_motion[:, None, :]
            step += columns.T @ (weights[:, 0] * left)
            step += np.einsum("ipa,iab,ib->p", of_weighted, piece.motion_covariance, slopes, optimize=True)
        refined = refined + _inverse(_normal(pieces, refined, reference)) @ step
        if not 0.5 * theta[K2] < refined[K2] < 2.0 * theta[K2]:
            return theta
    return refined


def _covariance(pieces: Sequence[Piece], reference: float, theta: Array) -> tuple[Array, float]:
    """Eq. (19) for coloured noise, and how much larger what is left over makes it than white noise would."""
    noise, blocks = np.zeros((7, 7)), []
    for piece in pieces:
        columns, left = _rows(piece, theta, reference)
        weighted = _weighted(piece, columns, theta, reference)
        operators = (piece.polynomials.value, piece.polynomials.slope, piece.polynomials.curvature)
        spread = np.zeros_like(weighted)
        for operator, slope in zip(operators, _force_slopes(piece, theta, reference), strict=True):
            spread += piece.polynomials.transpose(operator, weighted * slope[:, None])
        noise += piece.force_noise**2 * weighted.T @ weighted + piece.deflection_noise**2 * spread.T @ spread
        edges = np.searchsorted(piece.time, np.arange(piece.time[0], piece.time[-1], BLOCK))
        blocks.append(np.add.reduceat(weighted * left[:, None], np.unique(edges), axis=0))
    inverse = _inverse(_normal(pieces, theta, reference))
    sums = np.concatenate(blocks)
    expected, observed = inverse @ noise @ inverse, inverse @ (sums.T @ sums) @ inverse
    misfit = np.maximum(1.0, np.diag(observed) / np.maximum(np.diag(expected), 1e-300))
    return expected * np.sqrt(np.outer(misfit, misfit)), float(misfit.max())


def _normal(pieces: Sequence[Piece], theta: Array, reference: float) -> Array:
    """Normal matrix of eq. (19), less what noisy motion adds to it."""
    result = np.zeros((7, 7))
    for piece in pieces:
        columns = _columns(piece, theta, reference)
        result += _weighted(piece, columns, theta, reference).T @ columns - _compensation(piece, theta, reference)
    return result


def _compensation(piece: Piece, theta: Array, reference: float) -> Array:
    """What the noise of deflection, velocity and acceleration adds to the normal matrix."""
    by_motion = _by_motion(piece, theta, reference)
    weights = _weights(piece, theta, reference)[0][:, 0]
    return np.asarray(
        np.einsum("i,ipa,iab,iqb->pq", weights, by_motion, piece.motion_covariance, by_motion, optimize=True)
    )


def _weighted(piece: Piece, columns: Array, theta: Array, reference: float) -> Array:
    return columns * _weights(piece, theta, reference)[0]


def _inverse(normal: Array) -> Array:
    """Pseudo-inverse of a normal matrix whose columns have any units."""
    scale = np.sqrt(np.abs(np.diag(normal)))
    scale[scale == 0.0] = 1.0
    return np.asarray(
        np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-11, hermitian=True) / np.outer(scale, scale)
    )


def _rows(piece: Piece, theta: Array, reference: float) -> tuple[Array, Array]:
    """Derivatives of the force by all coefficients, (samples, 7), and measured minus modelled force."""
    columns = _columns(piece, theta, reference)
    return columns, piece.force - columns[:, 1:] @ theta[1:]


def _columns(piece: Piece, theta: Array, reference: float) -> Array:
    dx = piece.deflection - reference
    growth = np.exp(theta[K2] * dx)
    held, _ = _held(piece, theta)
    friction, ones = np.sign(piece.velocity), np.ones_like(dx)
    cubic = held**3 - 3.0 * held * piece.motion_covariance[:, 1, 1]  # the cube of a noisy velocity is too large
    return np.stack([theta[Q] * dx * growth, growth, ones, friction, held, cubic, piece.acceleration], axis=1)


def _by_motion(piece: Piece, theta: Array, reference: float) -> Array:
    """Derivatives of the columns by deflection, velocity and acceleration, (samples, 7, 3)."""
    dx = piece.deflection - reference
    growth = np.exp(theta[K2] * dx)
    held, inside = _held(piece, theta)
    result = np.zeros((len(dx), 7, 3))
    result[:, K2, 0] = theta[Q] * growth * (1.0 + theta[K2] * dx)
    result[:, Q, 0] = theta[K2] * growth
    result[:, D1, 1] = inside
    result[:, D2, 1] = 3.0 * held**2 * inside
    result[:, M, 2] = 1.0
    return result


def _force_slopes(piece: Piece, theta: Array, reference: float) -> tuple[Array, Array, Array]:
    """Stiffness, damping and inertia at each sample."""
    held, inside = _held(piece, theta)
    stiffness = theta[K2] * theta[Q] * np.exp(theta[K2] * (piece.deflection - reference))
    return stiffness, (theta[D1] + 3.0 * theta[D2] * held**2) * inside, np.full_like(held, theta[M])


def _held(piece: Piece, theta: Array) -> tuple[Array, Array]:
    """Velocity, kept where the damper's force is greatest; where it is below that."""
    if theta[D1] <= 0.0 or theta[D2] >= 0.0:
        return piece.velocity, np.ones_like(piece.velocity)
    limit = float(np.sqrt(theta[D1] / (-3.0 * theta[D2])))
    return np.clip(piece.velocity, -limit, limit), (np.abs(piece.velocity) < limit).astype(float)


def _weights(piece: Piece, theta: Array, reference: float) -> tuple[Array, Array]:
    """Weights, (samples, 1), and their derivatives by deflection, velocity and acceleration, (samples, 3).

    Eq. (19)'s R_w is force noise and, seen through stiffness, damping and inertia, the motion's; slow rows fade out.
    """
    stiffness, damping, inertia = slopes = _force_slopes(piece, theta, reference)
    by = np.einsum("iab,bi->ai", piece.motion_covariance, np.stack(slopes))
    weights = 1.0 / (piece.force_noise**2 + stiffness * by[0] + damping * by[1] + inertia * by[2])
    held, inside = _held(piece, theta)
    r = np.clip(np.abs(piece.velocity) / piece.slowest - 1.0, 0.0, 1.0)
    fade, fade_slope = r * r * (3.0 - 2.0 * r), 6.0 * r * (1.0 - r) / piece.slowest * np.sign(piece.velocity)
    by_deflection = -2.0 * theta[K2] * stiffness * by[0] * weights**2 * fade
    by_velocity = -12.0 * theta[D2] * held * inside * by[1] * weights**2 * fade + weights * fade_slope
    return (weights * fade)[:, None], np.stack([by_deflection, by_velocity, np.zeros_like(fade)], axis=1)
