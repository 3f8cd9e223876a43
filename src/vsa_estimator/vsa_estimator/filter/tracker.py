"""The filter's state over time: steps, rejections, and what to do when a sensor starts to tell another story."""

import math
from collections import deque
from typing import Any, NamedTuple

import numpy as np
from vsa_common.types import Array
from vsa_estimator.filter.ekf import HARD_GATE, MIN_STROKE, SOFT_GATE
from vsa_estimator.filter.excitation import (
    ACCELERATION_SQUARE,
    DOUBTS,
    HIGH,
    LOW,
    NEAR_KINK,
    SHARES,
    assess_uncertainty,
    initial_excitation,
    reset_matching,
)
from vsa_estimator.filter.steps import (
    FOUND,
    KNOWN,
    REJECTED,
    RESTS,
    step_deflection,
    step_force,
    step_prediction,
    views,
)
from vsa_estimator.force_law.transmission import COULOMB_SPEED, SIZE, Z, force, peak_speed
from vsa_estimator.settings import Initial

START_SPEED_STD = 2e-3  # [m/s]
START_ACCELERATION_STD = 5e-3  # [m/s^2]
WATCH_TIME = 2.0  # innovations are watched over this long [s]
SUSPICION = 3.0  # mean normalised innovation squared above which the coefficients no longer explain the force
LOUD = 10.0  # no innovation counts for more: a jolt makes few great ones, wrong coefficients many
CONTRADICTION = 40.0  # squared distance of six coefficients from a regression's that no chance explains
FAST = 2.0  # times the speed of the damper's greatest force, beyond which the lag of the filter is not held against it


class CoefficientUncertainty(NamedTuple):
    """Coefficients with what is known of them beyond the covariance, SI."""

    k2: float
    k2_variance: float  # with what the mass might hide
    d2: float
    d2_variance: float  # with what noise of the speed does to it
    force_offset: float
    coulomb_friction: float
    inertia_variance: float  # with an error of the acceleration that keeps its phase
    inertial_force: float  # root mean square of what moves the mass [N]


class Tracker:
    """State and covariance of one transmission. `knows` says whether the force may correct the coefficients."""

    def __init__(self, initial: Initial, rate: float) -> None:
        """Wide start values; `rate` of the filter [Hz]."""
        self._initial = initial
        self._rate = rate
        self.known = np.zeros(KNOWN)  # as the steps take it
        self._divide()
        self.reference = 0.0
        self.deflection_monitor = np.array([0.0, 1.0])
        self.force_monitor = np.array([0.0, 1.0, 0.0])
        self._watched: deque[float] = deque(maxlen=int(WATCH_TIME * rate))
        self._watched_sum = 0.0
        self._motion = initial_excitation()
        self._found[SHARES:] = 1.0
        self._uncertainty: CoefficientUncertainty | None = None
        self._force_variance = math.inf  # of the last force's noise [N^2]

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy has its own parts of its own array."""
        self.__dict__.update(state)
        self._divide()

    def _divide(self) -> None:
        self.z, self.friction_bias, self.p = views(self.known)
        self._found = self.known[FOUND:]

    @property
    def speed(self) -> float:
        """Deflection rate [m/s]."""
        return float(self.z[Z.V])

    @property
    def covariance(self) -> Array:
        """Of the state, with its systematic error."""
        return np.asarray(self.p + np.outer(self.friction_bias, self.friction_bias))

    @property
    def beyond_peak_speed(self) -> bool:
        """Whether the rod is known to move where its damper has no more force to give."""
        return abs(self.speed) > NEAR_KINK * peak_speed(float(self.z[Z.D1]), float(self.z[Z.D2]))

    @property
    def deflection_nis(self) -> float:
        """Normalised innovation squared of the last deflection."""
        return float(self.deflection_monitor[0] ** 2 / self.deflection_monitor[1])

    @property
    def stroke(self) -> float:
        """Travel of the last STROKE_MEMORY seconds [m]."""
        return float(self._motion[HIGH] - self._motion[LOW])

    @property
    def _max_mass(self) -> float:
        """What the mass may well be [kg]."""
        return float(self.z[Z.M]) + math.sqrt(float(self.p[Z.M, Z.M]))

    @property
    def max_inertial_force(self) -> float:
        """Root mean square of what may move the mass, as heavy and as much accelerated as it may well be [N]."""
        return self._max_mass * math.sqrt(max(float(self._motion[ACCELERATION_SQUARE]), 0.0) + float(self.p[Z.A, Z.A]))

    @property
    def sufficient_stroke(self) -> bool:
        """Whether the travel bends the spring's curve enough to tell k2."""
        return bool(self.z[Z.K2] * self.stroke > MIN_STROKE)

    def start(self, deflection: float, measured_force: float, deflection_variance: float) -> None:
        """Begin at a place, knowing the start values alone; the place becomes the reference."""
        self.reference = float(deflection)
        self.reset_position(deflection, deflection_variance)
        self.reset_coefficients(measured_force)

    def reset_position(self, deflection: float, deflection_variance: float) -> None:
        """Position anew, speed and acceleration unknown; the coefficients stay."""
        self._uncertainty = None
        self.z[:3] = deflection, 0.0, 0.0
        self.p[:3] = 0.0
        self.p[:, :3] = 0.0
        self.friction_bias[:3] = 0.0
        self.p[0, 0] = 4.0 * deflection_variance
        self.p[1, 1] = START_SPEED_STD**2
        self.p[2, 2] = START_ACCELERATION_STD**2
        self._motion[HIGH] = self._motion[LOW] = deflection
        self.reset_matching()
        self.reset_nis_test()

    def reset_coefficients(self, measured_force: float) -> None:
        """Coefficients back to their start values, the stiffness from the present force by eq. (3)."""
        self._uncertainty = None
        start, dx = self._initial, self.z[Z.X] - self.reference
        elastic = max(measured_force - start.force_offset, 0.5)
        relative = start.k2_std / start.k2
        self.z[3:] = (
            np.log(start.k2 * elastic) - start.k2 * dx, start.k2, start.d1, start.d2, start.inertia,
            start.force_offset, start.coulomb_friction,
        )  # fmt: skip
        self.p[3:] = 0.0
        self.p[:, 3:] = 0.0
        k2_variance = start.k2_std**2
        variances = (
            relative**2 + (start.force_offset_std / elastic) ** 2 + dx * dx * k2_variance, k2_variance,
            start.d1_std**2, start.d2_std**2, start.inertia_std**2, start.force_offset_std**2,
            start.coulomb_friction_std**2,
        )  # fmt: skip
        self.p[range(3, SIZE), range(3, SIZE)] = variances
        self.p[3, 4] = self.p[4, 3] = -dx * k2_variance
        self.friction_bias[3:] = 0.0
        self.reset_matching()
        self.reset_nis_test()

    def set_coefficients(self, mean: Array, covariance: Array) -> None:
        """Take over coefficients [s k2 d1 d2 M F0 d0] with their covariance."""
        self._uncertainty = None
        self.z[3:] = mean
        self.z[Z.K2] = max(self.z[Z.K2], 20.0)
        self.z[Z.D1] = max(self.z[Z.D1], 50.0)
        self.z[Z.D0] = max(self.z[Z.D0], 0.02)
        self.p[3:, :3] = 0.0
        self.p[:3, 3:] = 0.0
        self.p[3:, 3:] = covariance

    def restore(self, mean: Array, covariance: Array, reference: float) -> None:
        """Set coefficients as `set_coefficients`, with the position at which s holds [m]."""
        self.set_coefficients(mean, covariance)
        self.reference = reference

    def set_reference(self, position: float) -> None:
        """Let s hold at another position [m]; the coefficients are reset afterwards."""
        self.reference = position

    def cross_check_failed(self, mean: Array, covariance: Array, acceleration: float, force_noise_std: float) -> bool:
        """Whether a regression over the same data has found other coefficients, beyond what it may be off by.

        A mass that may be felt, at the data's `acceleration` [m/s^2] or in the brisk motion that the regression left
        out, confounds it; then the filter is believed. One that is not felt is compared with nothing but a start value.
        """
        acceleration = max(acceleration, math.sqrt(max(self._motion[ACCELERATION_SQUARE], 0.0)))
        if self._max_mass * acceleration > 2.0 * force_noise_std:
            return False
        told = np.arange(SIZE - 3) != Z.M - 3
        covariance = covariance[np.ix_(told, told)]
        scale = np.sqrt(np.diag(covariance))
        apart = (self.z[3:] - mean)[told] / scale
        return bool(apart @ np.linalg.solve(covariance / np.outer(scale, scale), apart) > CONTRADICTION)

    def set_stroke(self, high: float, low: float) -> None:
        """The travel that the start values were learnt from [m]."""
        self._motion[HIGH], self._motion[LOW] = high, low

    def predict(self, dt: float, jerk_density: float) -> None:
        """Carry on by dt [s]."""
        self._uncertainty = None
        step_prediction(self.known, dt, jerk_density)

    def reset_matching(self) -> None:
        """The motion is livelier than it was: no longer to be called smooth."""
        reset_matching(self._motion)

    def inflate_for_acceleration(self, offset: float, duration: float) -> None:
        """The rod has left its way by `offset` [m] within `duration` [s]: by an acceleration that nobody foresaw."""
        self._uncertainty = None
        self.reset_matching()
        way = np.array([1.0, 2.0 / duration, 2.0 / duration**2]) * offset
        self.p[:3, :3] += np.outer(way, way)

    def update_deflection(self, measured: float, variance: float) -> bool:
        """Take a deflection in; False where the gate rejects it."""
        self._uncertainty = None
        return bool(step_deflection(self.known, self._motion, self.deflection_monitor, measured, variance))

    def is_outlier(self, measured: float, variance: float) -> bool:
        """Whether a deflection [m] is further off than chance explains."""
        return bool((measured - self.z[Z.X]) ** 2 > SOFT_GATE * (float(self.p[Z.X, Z.X]) + variance))

    def position_uncertain(self, offset: float, variance: float) -> bool:
        """Whether the place has become so uncertain that the gate would let a deflection so far off [m] pass."""
        return bool(offset * offset < HARD_GATE * (float(self.p[Z.X, Z.X]) + variance))

    def update_force(self, measured: float, variance: float, deflection_variance: float, dt: float) -> bool:
        """Take a force in while moving; False where the gate rejects it."""
        self._uncertainty = None
        found = step_force(
            self.known, self._motion, self.force_monitor, self.reference, measured, variance, deflection_variance, dt
        )
        if found == RESTS:
            return True
        self._force_variance = variance
        _, v, _, _, _, d1, d2, *_ = self.z.tolist()
        if abs(v) < FAST * math.sqrt(d1 / max(-3.0 * d2, 1e-6)):
            self._add_nis(float(self.force_monitor[2]))
        return bool(found != REJECTED)

    @property
    def nis_test_failed(self) -> bool:
        """Whether the force has not been explained for WATCH_TIME."""
        full = len(self._watched) == self._watched.maxlen
        return full and self._watched_sum > SUSPICION * len(self._watched)

    def predicted_force(self, deflection: float) -> float:
        """Force of eq. (6) at another place with the present motion [N]."""
        z = self.z.copy()
        z[Z.X] = deflection
        return float(force(z, self.reference, COULOMB_SPEED, np.zeros(SIZE), np.zeros((SIZE, SIZE))))

    @property
    def uncertainty(self) -> CoefficientUncertainty:
        """What the last step says of the coefficients."""
        if self._uncertainty is None:
            self._uncertainty = self._assess_uncertainty()
        return self._uncertainty

    def _assess_uncertainty(self) -> CoefficientUncertainty:
        assess_uncertainty(self._motion, self.z, self.p, self._force_variance, self._initial.inertia_std, self._found)
        k2_variance, d2_variance, inertia_variance, inertial_force = self._found[:DOUBTS].tolist()
        _, k2, _, d2, _, force_offset, coulomb_friction = self.z[3:].tolist()
        return CoefficientUncertainty(
            k2, k2_variance, d2, d2_variance, force_offset, coulomb_friction, inertia_variance, inertial_force
        )

    def _add_nis(self, nis: float) -> None:
        nis = min(nis, LOUD)
        if len(self._watched) == self._watched.maxlen:
            self._watched_sum -= self._watched[0]
        self._watched.append(nis)
        self._watched_sum += nis

    def reset_nis_test(self) -> None:
        """Begin to watch the innovations anew."""
        self._watched.clear()
        self._watched_sum = 0.0
