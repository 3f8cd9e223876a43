# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State of one transmission's filter over time: start, resets, predictions, updates and its consistency tests."""

import math
from typing import Any

import numpy as np
from vsa_common.types import Array
from vsa_estimator.filter.chi_square import NisTest, mahalanobis_square
from vsa_estimator.filter.ekf import REJECTED, STATIONARY, predict, process_force, update_deflection
from vsa_estimator.filter.excitation import near_peak_speed, reset_matching, stroke
from vsa_estimator.filter.initial_state import initial_coefficients
from vsa_estimator.filter.records import initial_excitation, initial_monitor, initial_state
from vsa_estimator.filter.uncertainty import CoefficientUncertainty, assess_uncertainty, coefficient_uncertainty
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.elastic import ln_stiffness_ratio
from vsa_estimator.force_law.state import SIZE, Z
from vsa_estimator.force_law.transmission import force
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import (
    HARD_GATE,
    INITIAL_ACCELERATION_STD,
    INITIAL_POSITION_STD_RATIO,
    INITIAL_SPEED_STD,
    MAHALANOBIS_LIMIT,
    MAX_CROSS_CHECK_INERTIA,
    MIN_INITIAL_COULOMB,
    MIN_STROKE,
    NIS_MAX_SPEED,
    SOFT_GATE,
)
from vsa_estimator.tuning.force_law import COULOMB_SPEED, MIN_D1, MIN_K2


class Tracker:
    """State and covariance of the filter of one transmission."""

    z: Array  # mean, order of `Z`: a view of `state`
    p: Array  # covariance without the systematic part: a view of `state`
    friction_bias: Array  # a view of `state`

    def __init__(self, initial: Initial, rate: float) -> None:
        """`initial` coefficients with standard deviations; `rate` of the filter [Hz]."""
        self._initial = initial
        self.state = initial_state()
        self._set_views()
        self.reference = 0.0  # of the stiffness state s [m]
        self.excitation = initial_excitation()
        self.deflection_monitor, self.force_monitor = initial_monitor(), initial_monitor()
        self._nis_test = NisTest(rate)
        self._uncertainty = coefficient_uncertainty(self.state)
        self._uncertainty_outdated = True
        self._force_variance = math.inf  # of the last force [N^2]

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a copy, whose views refer to its own record."""
        self.__dict__.update(state)
        self._set_views()

    def _set_views(self) -> None:
        self.z, self.p = self.state["mean"][0], self.state["covariance"][0]
        self.friction_bias = self.state["friction_bias"][0]

    def start(self, deflection: float, measured_force: float, deflection_variance: float) -> None:
        """Start at a deflection [m], which becomes the reference, with the initial coefficients."""
        self.reference = float(deflection)
        self.reset_position(deflection, deflection_variance)
        self.reset_coefficients(measured_force)

    def reset_position(self, deflection: float, deflection_variance: float) -> None:
        """Set the position [m]; velocity and acceleration become unknown, the coefficients stay."""
        self._uncertainty_outdated = True
        self.z[:3] = deflection, 0.0, 0.0
        self.p[:3] = self.p[:, :3] = 0.0
        self.friction_bias[:3] = 0.0
        self.p[Z.X, Z.X] = INITIAL_POSITION_STD_RATIO**2 * deflection_variance
        self.p[Z.V, Z.V] = INITIAL_SPEED_STD**2
        self.p[Z.A, Z.A] = INITIAL_ACCELERATION_STD**2
        self.set_stroke(deflection, deflection)
        self.reset_matching()
        self.reset_nis_test()

    def reset_coefficients(self, measured_force: float) -> None:
        """Set the coefficients to the initial ones, the stiffness from the present force [N] by eq. (3)."""
        self._uncertainty_outdated = True
        mean, covariance = initial_coefficients(self._initial, measured_force, self.z[Z.X] - self.reference)
        self._write_coefficients(mean, covariance)
        self.friction_bias[3:] = 0.0
        self.reset_matching()
        self.reset_nis_test()

    def set_coefficients(self, mean: Array, covariance: Array) -> None:
        """Set the coefficients [s k2 d1 d2 M F0 d0] (7) with their covariance (7 x 7)."""
        self._uncertainty_outdated = True
        self._write_coefficients(mean, covariance)
        self.z[Z.K2] = max(self.z[Z.K2], MIN_K2)
        self.z[Z.D1] = max(self.z[Z.D1], MIN_D1)
        self.z[Z.D0] = max(self.z[Z.D0], MIN_INITIAL_COULOMB)

    def _write_coefficients(self, mean: Array, covariance: Array) -> None:
        self.z[3:] = mean
        self.p[3:, :3] = 0.0
        self.p[:3, 3:] = 0.0
        self.p[3:, 3:] = covariance

    def restore(self, mean: Array, covariance: Array, reference: float) -> None:
        """Set coefficients as `set_coefficients`, with the reference of s [m]."""
        self.set_coefficients(mean, covariance)
        self.reference = reference
        self.reset_nis_test()

    def set_reference(self, position: float) -> None:
        """Set the reference of s [m]; `reset_coefficients` has to follow."""
        self.reference = position

    def set_stroke(self, high: float, low: float) -> None:
        """Set the travel [m], for example to that of the initialization."""
        self.excitation["position_max"], self.excitation["position_min"] = high, low

    def reset_matching(self) -> None:
        """Restart the covariance matching: the motion has another jerk density."""
        reset_matching(self.excitation)

    def reset_nis_test(self) -> None:
        """Start a new window of innovations."""
        self._nis_test.reset()

    def predict(self, dt: float, jerk_density: float) -> None:
        """Predict by dt [s] with white jerk [m^2/s^5]."""
        self._uncertainty_outdated = True
        predict(self.state, dt, jerk_density)

    def update_deflection(self, measured: float, variance: float) -> bool:
        """Update by a deflection [m]; False where the gate rejects it."""
        self._uncertainty_outdated = True
        return bool(update_deflection(self.state, self.excitation, self.deflection_monitor, measured, variance))

    def update_force(self, measured: float, variance: float, deflection_variance: float, dt: float) -> bool:
        """Update by a force [N], dt [s] after the one before, unless stationary; False where the gate rejects it."""
        self._uncertainty_outdated = True
        result = process_force(
            self.state, self.excitation, self.force_monitor, self.reference, measured, variance, deflection_variance, dt
        )
        if result == STATIONARY:
            return True
        self._force_variance = variance
        if abs(self.speed) < NIS_MAX_SPEED * self._peak_speed:
            self._nis_test.add(float(self.force_monitor["nis"][0]))
        return bool(result != REJECTED)

    def inflate_for_acceleration(self, offset: float, duration: float) -> None:
        """Inflate the covariance for an acceleration that caused an offset [m] within a duration [s]."""
        self._uncertainty_outdated = True
        self.reset_matching()
        error = np.array([1.0, 2.0 / duration, 2.0 / duration**2]) * offset
        self.p[:3, :3] += np.outer(error, error)

    def update_uncertainty(self) -> None:
        """Assess the uncertainty beyond the covariance, if the state has changed since."""
        if self._uncertainty_outdated:
            assess_uncertainty(self.state, self.excitation, self._force_variance, self._initial.inertia_std)
            self._uncertainty = coefficient_uncertainty(self.state)
            self._uncertainty_outdated = False

    def is_outlier(self, measured: float, variance: float) -> bool:
        """Whether a deflection [m] is beyond the soft gate."""
        return bool((measured - self.z[Z.X]) ** 2 > SOFT_GATE * (float(self.p[Z.X, Z.X]) + variance))

    def position_uncertain(self, offset: float, variance: float) -> bool:
        """Whether an innovation of `offset` [m] passes the hard gate."""
        return bool(offset * offset < HARD_GATE * (float(self.p[Z.X, Z.X]) + variance))

    def cross_check_failed(self, mean: Array, covariance: Array, acceleration: float, force_noise_std: float) -> bool:
        """Whether a regression's coefficients are inconsistent with the filter's (Mahalanobis distance, without M).

        An inertial force above the noise, at the data's `acceleration` [m/s^2] or at that of the recent motion, biases
        the regression: the check then passes. Below it the regression has no information on M.
        """
        acceleration = max(acceleration, math.sqrt(max(float(self.excitation["acceleration_square"][0]), 0.0)))
        if self._max_mass * acceleration > MAX_CROSS_CHECK_INERTIA * force_noise_std:
            return False
        compared = np.arange(SIZE - 3) != Z.M - 3
        error = (self.z[3:] - mean)[compared]
        return mahalanobis_square(error, covariance[np.ix_(compared, compared)]) > MAHALANOBIS_LIMIT

    @property
    def nis_test_failed(self) -> bool:
        """Whether the coefficients do not explain the forces of the last NIS_WINDOW."""
        return self._nis_test.failed

    @property
    def position(self) -> float:
        """Deflection [m]."""
        return float(self.z[Z.X])

    @property
    def speed(self) -> float:
        """Deflection rate [m/s]."""
        return float(self.z[Z.V])

    @property
    def covariance(self) -> Array:
        """Covariance of the state with the systematic error of the friction (10 x 10)."""
        return np.asarray(self.p + np.outer(self.friction_bias, self.friction_bias))

    @property
    def beyond_peak_speed(self) -> bool:
        """Whether the speed is near or beyond v*."""
        return bool(near_peak_speed(self.z))

    @property
    def deflection_nis(self) -> float:
        """Normalised innovation squared of the last deflection."""
        innovation = float(self.deflection_monitor["innovation"][0])
        return innovation**2 / float(self.deflection_monitor["variance"][0])

    @property
    def stroke(self) -> float:
        """Travel of the recent motion [m]."""
        return float(stroke(self.excitation))

    @property
    def sufficient_stroke(self) -> bool:
        """Whether the curvature of the spring over the travel makes k2 observable."""
        return bool(ln_stiffness_ratio(float(self.z[Z.K2]), self.stroke) > MIN_STROKE)

    @property
    def max_inertial_force(self) -> float:
        """Root mean square of the inertial force [N], with mass and acceleration one standard deviation higher."""
        square = max(float(self.excitation["acceleration_square"][0]), 0.0)
        return self._max_mass * math.sqrt(square + float(self.p[Z.A, Z.A]))

    @property
    def uncertainty(self) -> CoefficientUncertainty:
        """Coefficients with their uncertainty at the last `update_uncertainty`."""
        return self._uncertainty

    def predicted_force(self, z: Array) -> float:
        """Force of eq. (6) at a state (10,) that has the present reference [N]."""
        return float(force(z, self.reference, COULOMB_SPEED, np.zeros(SIZE), np.zeros((SIZE, SIZE))))

    @property
    def _max_mass(self) -> float:
        """Mass plus one standard deviation [kg]."""
        return float(self.z[Z.M]) + math.sqrt(float(self.p[Z.M, Z.M]))

    @property
    def _peak_speed(self) -> float:
        return float(peak_speed(float(self.z[Z.D1]), float(self.z[Z.D2])))
