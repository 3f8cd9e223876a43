# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The paper's filter, eqs. (14) to (17) corrected, and the offset filter of section V-A.

State of eq. (17) with two more: z = [x v a j r | sigma D M k2 d2], j the jerk in (14), r the filtered force rate. In
N, mm, s (M: N s^2/mm), where the covariance is well conditioned. Where (17) and (14) to (16) differ, the latter are
used: (14) has sigma v, (15) factor 1, (16) factor 6. The only module that imports filterpy.
"""

import math
from enum import IntEnum

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from vsa_common.types import Array
from vsa_estimator.tuning.filter import HARD_GATE, NIS_CAP, NIS_WINDOW, SOFT_GATE
from vsa_estimator.tuning.force_rate import (
    FRICTION_DRIFT,
    MAX_LN_GROWTH,
    OFFSET_DRIFT,
    PARAMETER_DRIFT,
    RATE_FILTER,
)


class R(IntEnum):
    """Order of the state; units of `ForceRateFilter.state`."""

    X = 0  # deflection [m]
    V = 1  # velocity [m/s]
    A = 2  # acceleration [m/s^2]
    J = 3  # jerk [m/s^3]
    RATE = 4  # filtered force rate [N/s]
    SIGMA = 5  # stiffness [N/m]
    D = 6  # damping [N s/m]
    M = 7  # inertia [kg]
    K2 = 8  # growth of the spring [1/m]
    D2 = 9  # cubic coefficient of the damper [N s^3/m^3]


SIZE = 10
TO_SI = np.array([1e-3, 1e-3, 1e-3, 1e-3, 1.0, 1e3, 1e3, 1e3, 1e3, 1e9])
REJECTED_VARIANCE = 1e12  # [mm^2, N^2/s^2]: a measurement without effect


class ForceRateFilter(ExtendedKalmanFilter):  # type: ignore[misc]
    """Eqs. (14) to (17) as an extended Kalman filter: deflection and filtered force rate are measured."""

    def __init__(self, state: Array, std: Array) -> None:
        """`state` and its standard deviation, (10,), SI."""
        super().__init__(dim_x=SIZE, dim_z=2)
        self.x = (state / TO_SI)[:, None]
        self.P = np.diag((std / TO_SI) ** 2)
        self.rejected = [0, 0]  # measurements of deflection and force rate
        self.nis = 0.0  # of the last force rate
        self._dt = 0.0

    def advance(self, dt: float, snap_density: float) -> None:
        """Predict by dt [s] with white snap of `snap_density` [m^2/s^7]."""
        self._dt = dt
        self.F = self._jacobian(dt)
        self.Q = np.zeros((SIZE, SIZE))
        self.Q[:4, :4] = 1e6 * snap_density * white_snap(dt)
        self.Q[R.RATE, R.RATE] = 1e-8
        self.Q[range(5, SIZE), range(5, SIZE)] = np.array(PARAMETER_DRIFT) * dt
        self.predict()

    def predict_x(self, u: float = 0.0) -> None:
        """State equations; overrides the linear ones of filterpy."""
        x, v, a, j, rate, sigma, damping, mass, k2, d2 = self.x[:, 0]
        dt = self._dt
        new_x, new_v, new_a = _integrate(x, v, a, j, dt)
        keep = math.exp(-dt / RATE_FILTER)
        new_sigma = sigma * math.exp(_clip_growth(k2 * (new_x - x)))  # (15), integrated over dx
        new_damping = damping + 3.0 * d2 * (new_v**2 - v**2)  # (16), integrated over dv
        middle_v, middle_a = v + 0.5 * a * dt, a + 0.5 * j * dt
        force_rate = 0.5 * (sigma + new_sigma) * middle_v + 0.5 * (damping + new_damping) * middle_a + mass * j  # (14)
        new_rate = keep * rate + (1.0 - keep) * force_rate
        self.x[:, 0] = [new_x, new_v, new_a, j, new_rate, new_sigma, new_damping, mass, k2, d2]

    def correct(self, deflection: float, force_rate: float, deflection_std: float, rate_std: float) -> None:
        """Update by deflection [m] and filtered force rate [N/s] with standard deviations, each with its gates."""
        measured = np.array([deflection * 1e3, force_rate])
        noise = np.array([deflection_std * 1e3, rate_std]) ** 2
        measured_states = [R.X, R.RATE]
        innovation = measured - self.x[measured_states, 0]
        variance = self.P[measured_states, measured_states] + noise
        nis = innovation**2 / variance
        self.nis = float(nis[1])
        for i in range(2):
            if nis[i] > HARD_GATE:
                self.rejected[i] += 1
                noise[i] = REJECTED_VARIANCE
            elif nis[i] > SOFT_GATE:
                noise[i] += variance[i] * (math.sqrt(nis[i] / SOFT_GATE) - 1.0)
        self.update(measured[:, None], _measured_jacobian, _measured, R=np.diag(noise))
        self.P = 0.5 * (self.P + self.P.T)
        for index, minimum in ((R.SIGMA, 1e-3), (R.M, 0.0), (R.K2, 0.02)):
            self.x[index, 0] = max(self.x[index, 0], minimum)

    @property
    def state(self) -> Array:
        """State (10,), SI."""
        return np.asarray(self.x[:, 0] * TO_SI)

    @property
    def covariance(self) -> Array:
        """Covariance of the state (10, 10), SI."""
        return np.asarray(self.P * np.outer(TO_SI, TO_SI))

    def _jacobian(self, dt: float) -> Array:
        """Derivatives of the state equations by the state (10, 10)."""
        x, v, a, j, _, sigma, damping, mass, k2, d2 = self.x[:, 0]
        new_x, new_v, _ = _integrate(x, v, a, j, dt)
        f = np.eye(SIZE)
        f[0, 1:4] = dt, dt**2 / 2.0, dt**3 / 6.0
        f[1, 2:4] = dt, dt**2 / 2.0
        f[2, 3] = dt
        exponent = k2 * (new_x - x)
        growth = math.exp(_clip_growth(exponent))
        unclipped = 1.0 if abs(exponent) < MAX_LN_GROWTH else 0.0
        f[R.SIGMA, R.SIGMA] = growth
        f[R.SIGMA, 1:4] = unclipped * sigma * growth * k2 * f[0, 1:4]
        f[R.SIGMA, R.K2] = unclipped * sigma * growth * (new_x - x)
        f[R.D, 1:4] = 6.0 * d2 * new_v * f[1, 1:4]
        f[R.D, R.V] -= 6.0 * d2 * v
        f[R.D, R.D2] = 3.0 * (new_v**2 - v**2)
        keep = math.exp(-dt / RATE_FILTER)
        middle_v, middle_a = v + 0.5 * a * dt, a + 0.5 * j * dt
        mean_sigma = 0.5 * sigma * (1.0 + growth)
        mean_damping = damping + 1.5 * d2 * (new_v**2 - v**2)
        by = 0.5 * middle_v * f[R.SIGMA] + 0.5 * middle_a * f[R.D]
        by[R.SIGMA] += 0.5 * middle_v
        by[R.D] += 0.5 * middle_a
        by[[R.V, R.A, R.J]] += mean_sigma, 0.5 * dt * mean_sigma + mean_damping, 0.5 * dt * mean_damping + mass
        by[R.M] += j
        f[R.RATE] = (1.0 - keep) * by
        f[R.RATE, R.RATE] = keep
        return f


class OffsetFilter:
    """Kalman filter of force offset F0 and Coulomb friction d0 by the residual force (section V-A)."""

    def __init__(self, offset: float, offset_std: float, friction: float, friction_std: float) -> None:
        """Start values with standard deviations [N]."""
        self._kalman = KalmanFilter(dim_x=2, dim_z=1)
        self._kalman.x = np.array([[offset], [friction]])
        self._kalman.P = np.diag([offset_std**2, friction_std**2])
        self.nis_mean = 1.0  # running mean of the normalised innovation squared

    def add(self, residual: float, direction: float, variance: float, dt: float) -> None:
        """Update by the `residual`, measured minus impedance force [N], in motion towards `direction` (-1 or 1).

        `dt` [s] is the time since the last update, `variance` [N^2].
        """
        self._kalman.Q = np.diag([OFFSET_DRIFT, FRICTION_DRIFT]) * dt
        self._kalman.predict()
        self._kalman.update(np.array([[residual]]), R=np.array([[variance]]), H=np.array([[1.0, direction]]))
        nis = float(self._kalman.y[0, 0] ** 2 / self._kalman.S[0, 0])
        self.nis_mean += (min(nis, NIS_CAP) - self.nis_mean) * min(dt / NIS_WINDOW, 1.0)

    @property
    def offset(self) -> float:
        """F0 [N]."""
        return float(self._kalman.x[0, 0])

    @property
    def friction(self) -> float:
        """d0 [N], not negative."""
        return max(float(self._kalman.x[1, 0]), 0.0)

    @property
    def covariance(self) -> Array:
        """Covariance of [F0 d0] (2, 2) [N^2]."""
        return np.asarray(self._kalman.P)


def white_snap(dt: float) -> Array:
    """Covariance (4, 4) of [x v a j] by white snap of unit density over dt [s]."""
    q = np.empty((4, 4))
    for i in range(4):
        for k in range(4):
            power = 7 - i - k
            q[i, k] = dt**power / (math.factorial(3 - i) * math.factorial(3 - k) * power)
    return q


def _integrate(x: float, v: float, a: float, j: float, dt: float) -> tuple[float, float, float]:
    return x + v * dt + a * dt**2 / 2.0 + j * dt**3 / 6.0, v + a * dt + j * dt**2 / 2.0, a + j * dt


def _clip_growth(exponent: float) -> float:
    return min(max(exponent, -MAX_LN_GROWTH), MAX_LN_GROWTH)


def _measured(x: Array) -> Array:
    return np.asarray(x[[R.X, R.RATE]])


def _measured_jacobian(x: Array) -> Array:
    h = np.zeros((2, SIZE))
    h[0, R.X] = h[1, R.RATE] = 1.0
    return h
