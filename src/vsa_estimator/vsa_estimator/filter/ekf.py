"""One step of the extended Kalman filter: predict, then deflection and force in turn, each with its gate.

One source: compiled where numba is there, plain numpy where it is not.
"""

import math

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.force_law.transmission import (
    COULOMB_SPEED,
    SIZE,
    force,
    friction_model_std,
    ln_stiffness,
    peak_speed,
)

SOFT_GATE = 16.0  # normalised innovation squared from which a measurement counts for less
HARD_GATE = 100.0  # and from which it is rejected

# Drift of [s k2 d1 d2 M F0 d0] a second: what keeps the filter awake over hours, far below what it knows in one.
DRIFT = np.array([2.5e-11, 2.5e-7, 0.0025, 2.5e7, 0.0, 2.5e-8, 2.5e-9])

REST_SPEED = 0.1e-3  # below it the transmission counts as standing still [m/s]
REVERSAL_SPEED = 0.10e-3  # around a reversal the Coulomb law is wrong within this speed [m/s] ...
REVERSAL_SHARE = 0.3  # ... by this share of the friction ...
LEAST_REVERSAL_FORCE = 0.015  # ... and by this at least [N] ...
REVERSAL_TIME = 0.01  # ... and stays so for this long at least, and for as long as no clear speed is seen [s]

OWN_NOISE = 0.5  # share of the encoder's noise, through the stiffness, by which a force counts for less

KNOWN_SPEED = 0.2  # of v*: greatest standard deviation of a speed for which the kink there is softened
EITHER_SIDE = 6.0  # standard deviations of a speed within which it may be on either side of v*: then no force ...
MOST_TOLD = 0.1  # ... tells more than this share of the variance of d2: it might be no greatest force

MIN_STROKE = 0.6  # k2 x stroke under which a bent spring looks like a straight one
STROKE_MEMORY = 20.0  # time constant of the stroke that the filter remembers [s]


@compiled
def predict(z: Array, p: Array, dt: float, jerk_density: float) -> None:
    """Carry state z and covariance p on by dt [s]: constant acceleration, white jerk of jerk_density [m^2/s^5]."""
    half = 0.5 * dt * dt
    z[0] += dt * z[1] + half * z[2]
    z[1] += dt * z[2]
    p[0] += dt * p[1] + half * p[2]
    p[1] += dt * p[2]
    p[:, 0] += dt * p[:, 1] + half * p[:, 2]
    p[:, 1] += dt * p[:, 2]
    q = jerk_density
    p[0, 0] += q * dt**5 / 20.0
    p[0, 1] += q * dt**4 / 8.0
    p[0, 2] += q * dt**3 / 6.0
    p[1, 1] += q * dt**3 / 3.0
    p[1, 2] += q * dt**2 / 2.0
    p[2, 2] += q * dt
    for i in range(3):
        p[i + 1 :, i] = p[i, i + 1 :]


@compiled
def propagate_bias(pull: Array, dt: float) -> None:
    """Carry a systematic error of the state on by dt [s]."""
    pull[0] += dt * pull[1] + 0.5 * dt * dt * pull[2]
    pull[1] += dt * pull[2]


@compiled
def add_parameter_process_noise(p: Array, dt: float) -> None:
    """Let the coefficients drift for dt [s] of motion."""
    for i in range(DRIFT.size):
        p[3 + i, 3 + i] += DRIFT[i] * dt


@compiled
def apply_correction(z: Array, p: Array, ph: Array, gain: Array, innovation: float, variance: float) -> None:
    """Joseph form for any gain: p becomes p - K (PH)' - (PH) K' + K S K', symmetric to the bit."""
    z += gain * innovation
    for i in range(SIZE):
        p[i] += gain[i] * (variance * gain - ph) - ph[i] * gain
    for i in range(SIZE):
        p[i + 1 :, i] = p[i, i + 1 :]


@compiled
def inflate_innovation(nis: float, variance: float, steepness: float) -> float:
    """Innovation variance, enlarged for an innovation beyond the soft gate: by (nis / gate)^steepness.

    With 1/2 the influence stays what it is at the gate; beyond that it falls again.
    """
    return variance * (nis / SOFT_GATE) ** steepness if nis > SOFT_GATE else variance


@compiled
def partial_update_mask(z: Array, p: Array, stroke: float, gain: Array) -> None:
    """Schmidt: what the present motion cannot tell apart stays as it is, and keeps its uncertainty.

    Of k2 without `stroke` [m], of M without a clear acceleration.
    """
    if z[4] * stroke < MIN_STROKE:
        gain[4] = 0.0
    if z[2] ** 2 < 9.0 * p[2, 2]:
        gain[7] = 0.0


@compiled
def update_deflection(
    z: Array, p: Array, measured: float, noise_variance: float, stroke: float, monitor: Array, pull: Array | None = None
) -> bool:
    """Take one deflection [m] in; False where the gate rejects it. monitor: innovation and its variance.

    pull is what the state would be off by, had the friction another form.
    """
    ph = p[0].copy()
    variance = ph[0] + noise_variance
    innovation = measured - z[0]
    nis = innovation * innovation / variance
    monitor[0] = innovation
    monitor[1] = variance
    if nis > HARD_GATE:
        return False
    variance = inflate_innovation(nis, variance, 0.5)
    gain = ph / variance
    partial_update_mask(z, p, stroke, gain)
    apply_correction(z, p, ph, gain, innovation, variance)
    if pull is not None:
        pull -= gain * pull[0]
    return True


@compiled
def measurement_cross_noise(z: Array, reference: float, deflection_variance: float) -> float:
    """Variance of the encoder, through the stiffness, by which a force counts for less [N^2]."""
    sigma = np.exp(ln_stiffness(z[3], z[4], z[0] - reference))
    return float(OWN_NOISE * sigma * sigma * deflection_variance)


@compiled
def linearize_near_peak(z: Array, speed_std: float, gradient: Array, hessian: Array) -> None:
    """Derivatives of the damper's force by the speed, near v*, in the mean over a speed of that standard deviation.

    The force bends down to v* and is held from there on. Who looks at one speed alone calls it sure just beyond.
    A speed that is hardly known is left as it is: softened, it would explain whatever force there is.
    """
    speed, w = abs(z[1]), peak_speed(z[5], z[6])
    beyond = (speed - w) / max(speed_std, 1e-12)
    if abs(beyond) > 4.0 or speed_std > KNOWN_SPEED * w:
        return
    density = math.exp(-0.5 * beyond * beyond) / math.sqrt(2.0 * math.pi)
    below = 0.5 * math.erfc(beyond / math.sqrt(2.0))
    bend = (1.0 + beyond * beyond) * below - beyond * density - min(beyond, 0.0) ** 2
    slope = density - beyond * below + min(beyond, 0.0)
    side = 1.0 if z[1] > 0.0 else -1.0
    gradient[1] -= 6.0 * z[6] * w * speed_std * slope
    hessian[1, 1] = 6.0 * z[6] * side * w * bend


@compiled
def update_force(
    z: Array, p: Array, reference: float, measured: float, noise_variance: float, deflection_variance: float,
    dt: float, stroke: float, monitor: Array, pull: Array | None = None, stood: float = 0.0,
) -> bool:  # fmt: skip
    """Take one force [N] in; False where the gate rejects it. monitor: innovation, its variance, NIS.

    pull is what the state would be off by, had the friction another form: no noise, it never averages out. `stood` [s]
    is how long there has been no clear speed: forces of that time share one error of the friction.

    Second order: the mean and the variance of the law's curvature under p go into innovation and noise. A force counts
    for less by the encoder's noise through the stiffness: else the stiffness drifts off by 0.1 % on a short stroke. The
    covariance is that of the gain so found, with the noise that there is.
    """
    gradient = np.zeros(SIZE)
    hessian = np.zeros((SIZE, SIZE))
    blur = np.sqrt(COULOMB_SPEED**2 + 1.5 * (p[1, 1] + (z[2] * dt) ** 2 / 12.0))  # speeds that a step spans, too
    expected = force(z, reference, blur, gradient, hessian)
    speed_std, w = np.sqrt(p[1, 1]), peak_speed(z[5], z[6])
    linearize_near_peak(z, speed_std, gradient, hessian)
    curvature = hessian @ p
    mean = 0.0
    for i in range(SIZE):
        mean += curvature[i, i]
    spread = np.sum(curvature * curvature.T)
    unexplained = max(REVERSAL_SHARE * (z[9] + np.sqrt(p[9, 9])), LEAST_REVERSAL_FORCE)
    reversal = unexplained * np.exp(-(z[1] ** 2) / (REVERSAL_SPEED**2 + 2.0 * p[1, 1]))
    own = measurement_cross_noise(z, reference, deflection_variance)
    alike = max(1.0, max(REVERSAL_TIME, stood) / dt)  # forces that share one error of the friction
    noise = noise_variance + reversal * reversal * alike + 0.5 * max(spread, 0.0)
    innovation = measured - expected - 0.5 * mean
    ph = p @ gradient
    variance = gradient @ ph + noise + own
    nis = innovation * innovation / variance
    monitor[0] = innovation
    monitor[1] = variance
    monitor[2] = nis
    if nis > HARD_GATE:
        return False
    variance = inflate_innovation(nis, variance, 2.0)
    gain = ph / variance
    partial_update_mask(z, p, stroke, gain)
    if abs(z[2]) * np.sqrt(p[7, 7]) < 0.2 * np.sqrt(noise_variance):
        gain[7] = 0.0
    if abs(abs(z[1]) - w) < EITHER_SIDE * speed_std and ph[6] * ph[6] > MOST_TOLD * variance * p[6, 6]:
        gain[5:7] = 0.0
    if pull is not None:
        pull -= gain * (gradient @ pull - friction_model_std(z, blur))
    apply_correction(z, p, ph, gain, innovation, variance - own)
    z[4] = max(z[4], 20.0)
    z[5] = max(z[5], 50.0)
    z[7] = max(z[7], 0.0)
    z[9] = max(z[9], 0.0)
    return True


@compiled
def predict_output(
    z: Array, p: Array, pull: Array, reference: float, ahead: float, jerk_density: float, doubts: Array, out: Array
) -> None:  # fmt: skip
    """Impedance and its covariance `ahead` [s] of state z into out (16); z stays as it is.

    Order: x v a each with its variance; stiffness with the variance of its logarithm; damping and inertia with their
    variances; covariances stiffness-damping, stiffness-inertia, damping-inertia; v*.

    Beyond the covariance: what `pull` does counts as one standard deviation; doubts are standard deviations of
    stiffness, d1 and d2, the variance of the inertia, and shares of what is claimed of place and speed.
    Gradients are carried back to z instead of p ahead.
    """
    t, q = ahead, jerk_density
    half = 0.5 * t * t
    x, v = z[0] + t * z[1] + half * z[2], z[1] + t * z[2]
    k2, d1, d2 = z[4], z[5], z[6]
    dx = x - reference
    sigma = np.exp(ln_stiffness(z[3], k2, dx))
    w = peak_speed(d1, d2)
    c = min(max(v, -w), w)
    slope = 6.0 * d2 * c  # of the damping, by the speed
    by_place, by_speed = k2 * doubts[4], slope * doubts[5]
    p_ln = np.empty(SIZE)
    p_damping = np.empty(SIZE)
    for i in range(SIZE):
        row = p[i]
        place = row[0] + t * row[1] + half * row[2]
        p_ln[i] = by_place * place + row[3] + dx * row[4]
        p_damping[i] = by_speed * (row[1] + t * row[2]) + row[5] + 3.0 * c * c * row[6]
    pulled_ln = k2 * (pull[0] + t * pull[1] + half * pull[2]) + pull[3] + dx * pull[4]
    pulled_damping = slope * (pull[1] + t * pull[2]) + pull[5] + 3.0 * c * c * pull[6]
    out[0] = x
    out[1] = p[0, 0] + 2.0 * (t * p[0, 1] + half * p[0, 2]) + t * t * (p[1, 1] + t * p[1, 2]) + half * half * p[2, 2]
    out[1] += q * t**5 / 20.0
    out[2] = v
    out[3] = p[1, 1] + 2.0 * t * p[1, 2] + t * t * p[2, 2] + q * t**3 / 3.0
    out[4] = z[2]
    out[5] = p[2, 2] + q * t
    out[6] = sigma
    out[7] = by_place * (p_ln[0] + t * p_ln[1] + half * p_ln[2]) + p_ln[3] + dx * p_ln[4]
    out[7] += k2 * k2 * q * t**5 / 20.0
    out[7] += pulled_ln * pulled_ln + (doubts[0] / sigma) ** 2
    out[8] = d1 + 3.0 * d2 * c * c
    out[9] = by_speed * (p_damping[1] + t * p_damping[2]) + p_damping[5] + 3.0 * c * c * p_damping[6]
    out[9] += slope * slope * q * t**3 / 3.0 + pulled_damping * pulled_damping
    out[9] += (3.0 * c * c * doubts[2]) ** 2 + doubts[1] ** 2
    out[10] = z[7]
    out[11] = doubts[3]
    covariance = by_speed * (p_ln[1] + t * p_ln[2]) + p_ln[5] + 3.0 * c * c * p_ln[6]
    covariance += k2 * slope * q * t**4 / 8.0
    out[12] = sigma * (covariance + pulled_ln * pulled_damping)
    out[13] = sigma * p_ln[7]
    out[14] = p_damping[7]
    out[15] = w
