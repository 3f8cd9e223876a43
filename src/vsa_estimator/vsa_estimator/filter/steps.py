"""Steps of the filter over what it knows, in one array: prediction, deflection, force."""

from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.filter.ekf import (
    SOFT_GATE,
    add_parameter_process_noise,
    measurement_cross_noise,
    predict,
    propagate_bias,
    update_deflection,
    update_force,
)
from vsa_estimator.filter.excitation import (
    FINDINGS,
    HIGH,
    LOW,
    STOOD,
    accumulate_excitation,
    accumulate_matching,
    kinematic_force_variance,
    update_stationary,
)
from vsa_estimator.force_law.transmission import SIZE

# Where in that array, so that a call takes few: state, systematic error, covariance, findings of `appraise`.
PULL, COVARIANCE, FOUND = SIZE, 2 * SIZE, 2 * SIZE + SIZE * SIZE
KNOWN = FOUND + FINDINGS

RESTS, REJECTED, TAKEN = range(3)  # what becomes of a force


@compiled
def views(known: Array) -> tuple[Array, Array, Array]:
    """State, systematic error and covariance, as views."""
    return known[:PULL], known[PULL:COVARIANCE], known[COVARIANCE:FOUND].reshape((SIZE, SIZE))


@compiled
def step_prediction(known: Array, dt: float, jerk_density: float) -> None:
    """Carry on by dt [s] under a jerk density [m^2/s^5]."""
    z, pull, p = views(known)
    predict(z, p, dt, jerk_density)
    propagate_bias(pull, dt)


@compiled
def step_deflection(known: Array, motion: Array, monitor: Array, measured: float, variance: float) -> bool:
    """Take a deflection [m] in, as `correct_deflection`; False where the gate rejects it."""
    z, pull, p = views(known)
    return update_deflection(z, p, measured, variance, motion[HIGH] - motion[LOW], monitor, pull)


@compiled
def step_force(
    known: Array, motion: Array, monitor: Array, reference: float, measured: float, variance: float,
    deflection_variance: float, dt: float,
) -> int:  # fmt: skip
    """Take a force [N] in while moving, as `correct_force`, dt [s] after the last one."""
    z, pull, p = views(known)
    if update_stationary(motion, z, p, dt):
        return RESTS
    add_parameter_process_noise(p, dt)
    accumulate_excitation(motion, z, p, reference, dt)
    stroke, stood, speed = motion[HIGH] - motion[LOW], motion[STOOD], z[1]
    claimed, own = kinematic_force_variance(z, p, reference), measurement_cross_noise(z, reference, deflection_variance)
    taken = update_force(z, p, reference, measured, variance, deflection_variance, dt, stroke, monitor, pull, stood)
    if monitor[2] < SOFT_GATE:
        accumulate_matching(motion, speed, claimed, monitor[0] * monitor[0] - monitor[1] + own + claimed, dt)
    return TAKEN if taken else REJECTED
