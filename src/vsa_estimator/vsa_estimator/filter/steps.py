"""One force of the filter with all that depends on it: rest, process noise, excitation, update, matching."""

from vsa_common.accel import compiled
from vsa_estimator.filter.ekf import update_force
from vsa_estimator.filter.excitation import (
    accumulate_excitation,
    accumulate_matching,
    accumulate_time_since_motion,
    is_stationary,
    kinematic_force_variance,
)
from vsa_estimator.filter.measurement_noise import measurement_cross_noise
from vsa_estimator.filter.process_noise import add_parameter_process_noise
from vsa_estimator.filter.records import ForceMeasurement, Record
from vsa_estimator.force_law.state import V
from vsa_estimator.tuning.filter import SOFT_GATE

STATIONARY, REJECTED, ACCEPTED = range(3)  # results of `process_force`


@compiled
def process_force(
    state: Record, excitation: Record, monitor: Record, reference: float, force: float, variance: float,
    deflection_variance: float, dt: float,
) -> int:  # fmt: skip
    """Update by a force [N], dt [s] after the one before: STATIONARY (no update), REJECTED or ACCEPTED."""
    z, p = state[0]["mean"], state[0]["covariance"]
    accumulate_time_since_motion(excitation, z, p, dt)
    if is_stationary(excitation):
        return STATIONARY
    add_parameter_process_noise(p, dt)
    accumulate_excitation(excitation, z, p, reference, dt)
    speed, predicted_var = z[V], kinematic_force_variance(z, p, reference)
    cross_noise = measurement_cross_noise(z, reference, deflection_variance)
    measurement = ForceMeasurement(force, variance, deflection_variance, reference, dt)
    accepted = update_force(state, excitation, monitor, measurement)
    result = monitor[0]
    if result["nis"] < SOFT_GATE:
        observed_var = result["innovation"] * result["innovation"] - result["variance"] + cross_noise + predicted_var
        accumulate_matching(excitation, speed, predicted_var, observed_var, dt)
    return ACCEPTED if accepted else REJECTED
