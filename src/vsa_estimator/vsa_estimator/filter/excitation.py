"""What the motion of late excites, and what it leaves in doubt of the coefficients beyond their covariance."""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.ekf import REST_SPEED, STROKE_MEMORY
from vsa_estimator.force_law.transmission import ln_stiffness, peak_speed

REST_TIME = 0.5  # without a clear speed for this long the rod stands [s]
KINK = 0.01  # of d1: what noise of the speed does to the damper where it passes its greatest force
NEAR_KINK, OFTEN = 0.9, 0.05  # of v*, and the share of time beyond that from which on all of it counts
SMOOTH_MEMORY = 10.0  # over this long the force shows how smooth the motion is [s]
CLEAR_SPEED = 0.3e-3  # where the friction's form says little [m/s]
PLACE_SHARE, SPEED_SHARE = 0.4, 0.25  # of the claimed variances, what stays however smooth the motion
HIDDEN = 1.5  # with one tone nothing tells a wrong mass from a spring: so much of a learned one's error is hidden there

# What is remembered: travel [m]; leaky means of v^2 and a^2 without the filter's own uncertainty; leaky share of the
# time near or beyond the damper's greatest force; time without a clear speed [s]; leaky weight and sums of
# x, a, x^2, x a; leaky weight and means of the force's variance by place and speed, as claimed and as shown.
HIGH, LOW, SPEED_SQUARE, ACCELERATION_SQUARE, BEYOND, STOOD, WEIGHT, X, A, XX, XA, SMOOTH, CLAIMED, SHOWN = range(14)

# What `appraise` finds: variances of k2, d2 and M, the force that moves M [N], and the doubts of `filter.report`.
K2_VARIANCE, D2_VARIANCE, INERTIA_VARIANCE, INERTIAL_FORCE, DOUBTS = range(5)
SHARES, FINDINGS = DOUBTS + 4, DOUBTS + 6


def initial_excitation() -> Array:
    """Nothing has moved yet."""
    return np.zeros(14)


@compiled
def kinematic_force_variance(z: Array, p: Array, reference: float) -> float:
    """Variance of the force by place and speed as the covariance p claims them [N^2]."""
    elastic, c = np.exp(ln_stiffness(z[3], z[4], z[0] - reference)), z[1]
    damping = z[5] + 3.0 * z[6] * c * c if abs(c) < peak_speed(z[5], z[6]) else 0.0
    return float(elastic * elastic * p[0, 0] + damping * (2.0 * elastic * p[0, 1] + damping * p[1, 1]))


@compiled
def accumulate_matching(motion: Array, speed: float, claimed: float, shown: float, dt: float) -> None:
    """Take the force's variance by place and speed, as claimed and as shown [N^2], `dt` [s] after the last."""
    if abs(speed) > CLEAR_SPEED:
        leak = dt / SMOOTH_MEMORY
        motion[SMOOTH] += leak * (1.0 - motion[SMOOTH])
        motion[CLAIMED] += leak * (claimed - motion[CLAIMED])
        motion[SHOWN] += leak * (shown - motion[SHOWN])


def reset_matching(motion: Array) -> None:
    """The motion has become another: nothing shows any more that it is smooth."""
    motion[SMOOTH] = motion[CLAIMED] = motion[SHOWN] = 0.0


@compiled
def consistency_ratio(motion: Array) -> float:
    """Share of the claimed variance of the speed that the force shows: white jerk is rougher than most motions."""
    if motion[CLAIMED] <= 0.0:
        return 1.0
    share = 1.0 - motion[SMOOTH] + motion[SMOOTH] * motion[SHOWN] / motion[CLAIMED]
    return min(max(share, 0.0), 1.0)


@compiled
def update_stationary(motion: Array, z: Array, p: Array, dt: float) -> bool:
    """Whether the rod stands: then stiction may hold any force, and noise of the speed must not pass for motion."""
    motion[STOOD] = 0.0 if abs(z[1]) > REST_SPEED + 3.0 * np.sqrt(p[1, 1]) else motion[STOOD] + dt
    return bool(motion[STOOD] > REST_TIME)


@compiled
def accumulate_excitation(motion: Array, z: Array, p: Array, reference: float, dt: float) -> None:
    """Take `dt` [s] of motion at state z with covariance p."""
    leak = dt / STROKE_MEMORY
    x, v, a = z[0], z[1], z[2]
    dx = x - reference
    motion[HIGH] = max(x, motion[HIGH] - leak * (motion[HIGH] - x))
    motion[LOW] = min(x, motion[LOW] + leak * (x - motion[LOW]))
    motion[SPEED_SQUARE] += leak * (v * v - p[1, 1] - motion[SPEED_SQUARE])
    motion[ACCELERATION_SQUARE] += leak * (a * a - p[2, 2] - motion[ACCELERATION_SQUARE])
    beyond = 1.0 if abs(v) > NEAR_KINK * peak_speed(z[5], z[6]) else 0.0
    motion[BEYOND] += leak * (beyond - motion[BEYOND])
    motion[WEIGHT] += leak * (1.0 - motion[WEIGHT])
    motion[X] += leak * (dx - motion[X])
    motion[A] += leak * (a - motion[A])
    motion[XX] += leak * (dx * dx - motion[XX])
    motion[XA] += leak * (dx * a - motion[XA])


@compiled
def assess_uncertainty(
    motion: Array, z: Array, p: Array, force_variance: float, inertia_std: float, out: Array
) -> None:
    """What is known of the coefficients beyond the covariance into out (FINDINGS).

    A speed that errs in phase with itself pulls the cubic damper, an acceleration that does the mass; a mass hides in
    the spring where the motion is one tone. `force_variance` [N^2] of the last force, `inertia_std` [kg] at the start.
    """
    weight, spread, together = motion[WEIGHT], 0.0, 0.0  # variance of x, covariance of x and a
    if weight > 0.0:
        mean = motion[X] / weight
        spread, together = motion[XX] / weight - mean * mean, motion[XA] / weight - mean * motion[A] / weight
    spring = max(0.0, -together / spread) if spread > 1e-12 else 0.0
    alike = -together * spring  # square of the acceleration that a spring would do as well ...
    own = motion[ACCELERATION_SQUARE] - alike  # ... and of what none would
    accelerated = max(motion[ACCELERATION_SQUARE], alike)  # noise of a slow acceleration is more than itself
    mass, d2 = z[7], z[6]
    cubic_pull = min(3.0 * p[1, 1] / max(motion[SPEED_SQUARE], 1e-12), 1.0)
    mass_pull = min(p[2, 2] / max(own, 1e-12), 1.0)
    kink = KINK * min(1.0, motion[BEYOND] / OFTEN)
    inertia_variance = p[7, 7] + mass * mass * mass_pull
    felt = inertia_variance * accelerated > force_variance
    learned = inertia_variance * (1.0 if felt else max(0.0, 1.0 - p[7, 7] / inertia_std**2))
    hidden = HIDDEN * z[4] * spring * np.exp(-z[3])
    share = 1.0 if felt else max(consistency_ratio(motion), min(1.0, motion[BEYOND] / OFTEN))
    out[K2_VARIANCE] = p[4, 4] + hidden * hidden * learned
    out[D2_VARIANCE] = p[6, 6] + (d2 * cubic_pull) ** 2 + (2.0 * kink * d2) ** 2
    out[INERTIA_VARIANCE] = inertia_variance
    out[INERTIAL_FORCE] = mass * np.sqrt(accelerated)
    out[DOUBTS] = HIDDEN * spring * np.sqrt(learned)
    out[DOUBTS + 1] = kink * z[5]
    out[DOUBTS + 2] = d2 * cubic_pull
    out[DOUBTS + 3] = inertia_variance
    out[SHARES] = np.sqrt(PLACE_SHARE + (1.0 - PLACE_SHARE) * share)
    out[SHARES + 1] = np.sqrt(max(share, SPEED_SHARE))
