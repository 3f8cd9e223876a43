# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Prediction and updates of the filter against filterpy, and its output against complex-step derivatives."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from vsa_estimator.filter.ekf import predict, update_deflection, update_force
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.records import (
    PREDICTION,
    ForceMeasurement,
    initial_excitation,
    initial_monitor,
    initial_state,
)
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.state import K2, SIZE, M
from vsa_estimator.force_law.transmission import force
from vsa_estimator.tuning.filter import (
    CROSS_NOISE_SHARE,
    MAX_INFORMATION_GAIN,
    MIN_REVERSAL_FORCE,
    MIN_STROKE,
    PEAK_SPEED_GATE,
    REVERSAL_SHARE,
    REVERSAL_SPEED,
    REVERSAL_TIME,
)
from vsa_estimator.tuning.force_law import COULOMB_SPEED

TRUTH = np.array([0.010, 1e-3, 1e-2, 8.0, 267.2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3])
REFERENCE = 0.0105
STD = np.array([1e-5, 2e-4, 2e-2, 0.05, 5.0, 200.0, 2e7, 0.2, 0.5, 0.1])


def law(z):
    """Eq. (6) below v*."""
    x, v, a, s, k2, d1, d2, mass, offset, coulomb = z
    elastic = np.exp(s + k2 * (x - REFERENCE)) / k2 + offset
    return elastic + d1 * v + d2 * v**3 + coulomb * np.tanh(v / COULOMB_SPEED) + mass * a


def complex_step_gradient(function, z):
    gradient = np.empty(SIZE)
    for i in range(SIZE):
        shifted = z.astype(complex)
        shifted[i] += 1j * 1e-20 * max(abs(z[i]), 1e-3)
        gradient[i] = function(shifted).imag / (1e-20 * max(abs(z[i]), 1e-3))
    return gradient


def filter_at(z, p, stroke=0.010):
    """State and excitation records at mean z and covariance p with a travel [m]."""
    state, excitation = initial_state(), initial_excitation()
    state["mean"][0], state["covariance"][0] = z, p
    excitation["position_max"] = stroke
    return state, excitation


@pytest.mark.parametrize("ahead", [0.0, 0.004, 0.1])
@pytest.mark.parametrize("scales", [(1.0, 1.0), (0.7, 0.6)], ids=["white jerk", "smooth"])
def test_the_output_is_the_predicted_impedance_with_its_covariance_by_complex_step(ahead, scales):
    rng, jerk_density, prediction = np.random.default_rng(3), 1e-3, np.empty(1, PREDICTION)
    root = STD[:, None] * rng.normal(size=(SIZE, SIZE))
    state, _ = filter_at(TRUTH, root @ root.T)
    state["friction_bias"][0] = 0.1 * STD * rng.normal(size=SIZE)
    state["uncertainty"][0] = (0.0, 0.0, 0.04, 0.0, 9.0, 7.0, 3e6, *scales)
    before = state.copy()
    predict_output(state, REFERENCE, ahead, jerk_density, prediction)
    assert np.array_equal(state, before)

    out = np.array(prediction[0].tolist())
    predict(state, ahead, jerk_density)
    z, p, bias = state[0]["mean"], state[0]["covariance"], state[0]["friction_bias"]
    sigma = np.exp(z[3] + z[4] * (z[0] - REFERENCE))
    stiffness = complex_step_gradient(lambda z: z[3] + z[4] * (z[0] - REFERENCE), z)
    damping = complex_step_gradient(lambda z: z[5] + 3.0 * z[6] * z[1] ** 2, z)
    by = np.vstack([np.eye(SIZE)[:3], stiffness, damping, np.eye(SIZE)[7]])
    bias = by[3:5] @ bias
    position, velocity = scales
    by[3, 0] *= position
    by[4, 1] *= velocity
    covariance = by @ p @ by.T
    covariance[3:5, 3:5] += np.outer(bias, bias)
    covariance[3, 3] += (
        (1.0 - position**2) * z[4] ** 2 * jerk_density * ahead**5 / 20.0
    )  # the scales do not apply to new jerk
    covariance[4, 4] += (1.0 - velocity**2) * (6.0 * z[6] * z[1]) ** 2 * jerk_density * ahead**3 / 3.0
    covariance[3, 4] += (1.0 - position * velocity) * z[4] * 6.0 * z[6] * z[1] * jerk_density * ahead**4 / 8.0
    covariance[3, 3] += (9.0 / sigma) ** 2
    covariance[4, 4] += (3.0 * z[1] ** 2 * 3e6) ** 2 + 7.0**2
    covariance[5, 5] = 0.04
    values = [*z[:3], sigma, z[5] + 3.0 * z[6] * z[1] ** 2, z[7]]
    assert out[0:12:2] == pytest.approx(np.array(values), rel=1e-12)
    assert out[1:12:2] == pytest.approx(np.diag(covariance), rel=1e-9)
    expected = [sigma * covariance[3, 4], sigma * covariance[3, 5], covariance[4, 5]]
    assert out[12:15] == pytest.approx(np.array(expected), rel=1e-9)
    assert out[15] == peak_speed(z[5], z[6])


class Reference:
    """The same filter on filterpy's ExtendedKalmanFilter with dense matrices."""

    def __init__(self, z, p):
        self.force = ExtendedKalmanFilter(SIZE, 1)
        self.force.x, self.force.P = z.reshape(-1, 1).copy(), p.copy()
        self.stroke = 0.010

    def predict(self, dt, jerk_density):
        ekf = self.force
        ekf.F = np.eye(SIZE)
        ekf.F[0, 1] = ekf.F[1, 2] = dt
        ekf.F[0, 2] = dt * dt / 2.0
        ekf.Q = np.zeros((SIZE, SIZE))
        ekf.Q[:3, :3] = jerk_density * np.array(
            [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
        )
        ekf.predict()

    def update(self, measured, gradient, expected, noise, mask, exponent, cross_noise=0.0):
        """Gate and filterpy's update; for consider parameters (gain 0) or cross-noise, Joseph form of the masked gain.

        `cross_noise` reduces the gain and is no part of the covariance.
        """
        ekf = self.force
        prior, covariance, row = ekf.x.copy(), ekf.P.copy(), gradient.reshape(1, -1)
        noise += cross_noise
        variance = (row @ covariance @ row.T).item() + noise
        nis = (measured - expected) ** 2 / variance
        if nis > 100.0:
            return
        if nis > 16.0:
            noise += variance * ((nis / 16.0) ** exponent - 1.0)
        ekf.update(np.array([[measured]]), lambda _: row, lambda _: np.array([[expected]]), R=np.array([[noise]]))
        if cross_noise or not mask.all():
            gain = ekf.K * mask.reshape(-1, 1)
            keep = np.eye(SIZE) - gain @ row
            ekf.x = prior + gain * (measured - expected)
            ekf.P = keep @ covariance @ keep.T + gain * (noise - cross_noise) @ gain.T

    def mask(self):
        """1 for a coefficient that the motion excites, 0 for a consider parameter."""
        z, p = self.force.x[:, 0], self.force.P
        mask = np.ones(SIZE)
        mask[K2] = z[4] * self.stroke >= MIN_STROKE
        mask[M] = z[2] ** 2 >= 9.0 * p[2, 2]
        return mask

    def deflection(self, measured, noise):
        self.update(measured, np.eye(SIZE)[0], self.force.x[0, 0], noise, self.mask(), 0.5)

    def force_step(self, measured, noise, deflection_noise, dt):
        z, p = self.force.x[:, 0], self.force.P
        gradient, hessian = np.empty(SIZE), np.empty((SIZE, SIZE))
        coulomb_speed = np.sqrt(COULOMB_SPEED**2 + 1.5 * (p[1, 1] + (z[2] * dt) ** 2 / 12.0))
        expected = force(z, REFERENCE, coulomb_speed, gradient, hessian)
        friction_error = max(REVERSAL_SHARE * (z[9] + np.sqrt(p[9, 9])), MIN_REVERSAL_FORCE)
        reversal = friction_error * np.exp(-(z[1] ** 2) / (REVERSAL_SPEED**2 + 2.0 * p[1, 1]))
        spread = np.trace(hessian @ p @ hessian @ p) / 2.0
        cross_noise = CROSS_NOISE_SHARE * gradient[0] ** 2 * deflection_noise
        total = noise + reversal**2 * max(1.0, REVERSAL_TIME / dt) + spread
        mask = self.mask()
        mask[M] *= abs(z[2]) * np.sqrt(p[7, 7]) >= 0.2 * np.sqrt(noise)
        ambiguous = abs(abs(z[1]) - peak_speed(z[5], z[6])) < PEAK_SPEED_GATE * np.sqrt(p[1, 1])
        information = (gradient @ p)[6] ** 2 / (gradient @ p @ gradient + total + cross_noise) / p[6, 6]
        mask[5:7] = not ambiguous or information <= MAX_INFORMATION_GAIN
        self.update(measured, gradient, expected + np.trace(hessian @ p) / 2.0, total, mask, 2.0, cross_noise)
        z = self.force.x[:, 0]
        z[4], z[5], z[7], z[9] = max(z[4], 20.0), max(z[5], 50.0), max(z[7], 0.0), max(z[9], 0.0)


def multisine(t):
    """4 mm at 0.05 Hz and 0.16 mm at 0.7 Hz about 10.5 mm: deflection, speed, acceleration."""
    w = 2.0 * np.pi * np.array([0.05, 0.7])
    amplitude = np.array([4e-3, 1.6e-4])
    x = 0.0105 + amplitude @ np.sin(w * t)
    return x, (amplitude * w) @ np.cos(w * t), -(amplitude * w**2) @ np.sin(w * t)


@pytest.mark.parametrize(("d2_std", "beyond", "updates"), [(6e7, 0.5, False), (6e7, 8.0, True), (1e6, 0.5, True)])
def test_a_force_at_an_ambiguous_peak_speed_does_not_update_an_uncertain_damper(d2_std, beyond, updates):
    z = np.array([0.01, 0.0, 0.0, 7.0, 250.0, 5500.0, -1.8e8, 0.3, 20.0, 0.3])
    w = peak_speed(z[5], z[6])
    z[1] = w * (1.0 + 0.05 * beyond)
    p = np.diag([1e-12, (0.05 * w) ** 2, 1e-4, 1e-4, 1.0, 50.0**2, d2_std**2, 1e-3, 1e-2, 1e-4])
    before, variance = z.copy(), np.diag(p).copy()
    expected = force(z, 0.01, COULOMB_SPEED, np.empty(SIZE), np.empty((SIZE, SIZE)))
    state, excitation = filter_at(z, p)
    measurement = ForceMeasurement(float(expected) + 0.3, 3e-4, 1e-12, 0.01, 0.01)
    assert update_force(state, excitation, initial_monitor(), measurement)
    z, p = state[0]["mean"], state[0]["covariance"]
    assert (z[5] != before[5], p[5, 5] < variance[5]) == (updates, updates)
    assert (z[6] != before[6], p[6, 6] < variance[6]) == (updates, updates)
    assert p[3, 3] < variance[3]


def test_ten_thousand_steps_agree_with_filterpy_to_1e_9():
    rng = np.random.default_rng(5)
    state, excitation = filter_at([*multisine(-0.01), *TRUTH[3:]], np.diag(STD**2))
    z, p = state[0]["mean"], state[0]["covariance"]
    reference = Reference(z, p)
    dt, monitor = 0.01, initial_monitor()
    masked = 0
    for k in range(10_000):
        motion = multisine(k * dt)
        measured_x = motion[0] + 1e-5 * rng.standard_normal() * (8.0 if k % 997 == 500 else 1.0)
        measured_f = law(np.array([*motion, *TRUTH[3:]])) + 0.017 * rng.standard_normal()
        predict(state, dt, 1e-4)
        update_deflection(state, excitation, monitor, measured_x, 1e-10)
        update_force(state, excitation, monitor, ForceMeasurement(measured_f, 0.017**2, 1e-10, REFERENCE, dt))
        reference.predict(dt, 1e-4)
        reference.deflection(measured_x, 1e-10)
        reference.force_step(measured_f, 0.017**2, 1e-10, dt)
        masked += z[2] ** 2 < 9.0 * p[2, 2]
    assert 0 < masked < 10_000
    std = np.sqrt(np.diag(p))
    assert z / std == pytest.approx(reference.force.x[:, 0] / std, rel=1e-9, abs=1e-9)
    assert p / np.outer(std, std) == pytest.approx(reference.force.P / np.outer(std, std), abs=1e-9)


def test_the_covariance_stays_symmetric_to_the_bit_and_positive():
    rng = np.random.default_rng(6)
    (state, excitation), monitor = filter_at(TRUTH, np.diag(STD**2)), initial_monitor()
    for _ in range(2_000):
        predict(state, 0.01, 1e-3)
        update_deflection(state, excitation, monitor, 0.010 + 1e-5 * rng.standard_normal(), 1e-10)
        measured = float(law(TRUTH)) + 0.017 * rng.standard_normal()
        update_force(state, excitation, monitor, ForceMeasurement(measured, 3e-4, 1e-10, REFERENCE, 0.01))
    p = state[0]["covariance"]
    assert np.array_equal(p, p.T)
    std = np.sqrt(np.diag(p))
    assert np.linalg.eigvalsh(p / np.outer(std, std)).min() > -1e-12


def test_the_hard_gate_rejects_a_measurement_a_hundred_standard_deviations_off():
    (state, excitation), monitor = filter_at(TRUTH, np.diag(STD**2) * 1e-4), initial_monitor()
    before = state.copy()
    measurement = ForceMeasurement(float(law(TRUTH)) + 100 * 0.017, 0.017**2, 0.0, REFERENCE, 0.01)
    assert not update_force(state, excitation, monitor, measurement)
    assert not update_deflection(state, excitation, monitor, 0.010 + 1e-3, 1e-10)
    assert np.array_equal(state, before)
