"""Steps of the filter over what it knows, in one array: prediction, deflection, force."""

from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.ekf import SOFT_GATE, age, carry, correct_deflection, correct_force, own_noise, predict
from vsa_estimator.filter.excitation import FINDINGS, HIGH, LOW, STOOD, by_motion, compare, remember, rests
from vsa_estimator.force_law.transmission import SIZE

# Where in that array, so that a call takes few: state, systematic error, covariance, findings of `appraise`.
PULL, COVARIANCE, FOUND = SIZE, 2 * SIZE, 2 * SIZE + SIZE * SIZE
KNOWN = FOUND + FINDINGS

RESTS, REJECTED, TAKEN = range(3)  # what becomes of a force


@compiled
def parts(known: Array) -> tuple[Array, Array, Array]:
    """State, systematic error and covariance, as views."""
    return known[:PULL], known[PULL:COVARIANCE], known[COVARIANCE:FOUND].reshape((SIZE, SIZE))


@compiled
def advance(known: Array, dt: float, jerk_density: float) -> None:
    """Carry on by dt [s] under a jerk density [m^2/s^5]."""
    z, pull, p = parts(known)
    predict(z, p, dt, jerk_density)
    carry(pull, dt)


@compiled
def take_deflection(known: Array, motion: Array, monitor: Array, measured: float, variance: float) -> bool:
    """Take a deflection [m] in, as `correct_deflection`; False where the gate rejects it."""
    z, pull, p = parts(known)
    return correct_deflection(z, p, measured, variance, motion[HIGH] - motion[LOW], monitor, pull)


@compiled
def take_force(
    known: Array, motion: Array, monitor: Array, reference: float, measured: float, variance: float,
    deflection_variance: float, dt: float,
) -> int:  # fmt: skip
    """Take a force [N] in while moving, as `correct_force`, dt [s] after the last one."""
    z, pull, p = parts(known)
    if rests(motion, z, p, dt):
        return RESTS
    age(p, dt)
    remember(motion, z, p, reference, dt)
    stroke, stood, speed = motion[HIGH] - motion[LOW], motion[STOOD], z[1]
    claimed, own = by_motion(z, p, reference), own_noise(z, reference, deflection_variance)
    taken = correct_force(z, p, reference, measured, variance, deflection_variance, dt, stroke, monitor, pull, stood)
    if monitor[2] < SOFT_GATE:
        compare(motion, speed, claimed, monitor[0] * monitor[0] - monitor[1] + own + claimed, dt)
    return TAKEN if taken else REJECTED
