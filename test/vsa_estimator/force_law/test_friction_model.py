# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Friction bias: the sensitivity of the state to the form of the friction, propagated as a consider parameter."""

import numpy as np
import pytest
from transmission_data import TRANSMISSION_1, record, run, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.filter.ekf import predict, update_deflection, update_force
from vsa_estimator.filter.records import ForceMeasurement, initial_excitation, initial_monitor, initial_state
from vsa_estimator.force_law.friction import friction_model_std, smoothing_speed
from vsa_estimator.force_law.state import SIZE, Z
from vsa_estimator.force_law.transmission import force
from vsa_estimator.tuning.force_law import COULOMB_SPEED

REFERENCE, DT, SHARE = 0.010, 0.01, 0.02
TRUTH = np.array([0.010, 0.0, 0.0, np.log(3000.0), 267.2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3])
STD = np.array([1e-5, 1e-3, 1e-2, 0.05, 10.0, 400.0, 2e7, 0.1, 1.0, 0.1])
GENTLE = (0.0085, ((2e-3, 0.06), (1.5e-4, 0.3)))


def law(state):
    return force(state, REFERENCE, COULOMB_SPEED, np.zeros(SIZE), np.zeros((SIZE, SIZE)))


def test_the_friction_bias_is_the_difference_of_two_filters_with_different_friction():
    rng = np.random.default_rng(3)
    states, excitation, monitor = [initial_state(), initial_state()], initial_excitation(), initial_monitor()
    excitation["position_max"] = 0.004
    for state in states:
        state["mean"][0], state["covariance"][0] = TRUTH, np.diag(STD**2)
    nominal = states[0][0]
    for k in range(3000):
        w, t = 2.0 * np.pi * 0.1, DT * k
        motion = 0.010 + 2e-3 * np.sin(w * t), 2e-3 * w * np.cos(w * t), -2e-3 * w * w * np.sin(w * t)
        measured_x = motion[0] + 1e-6 * rng.standard_normal()
        measured_f = law(np.array([*motion, *TRUTH[3:]])) + 0.01 * rng.standard_normal()
        for state in states:
            predict(state, DT, 1e-4)
            update_deflection(state, excitation, monitor, measured_x, 1e-12)
        z, p = nominal["mean"], nominal["covariance"]
        coulomb_speed = np.sqrt(COULOMB_SPEED**2 + 1.5 * p[1, 1] + 0.125 * (z[2] * DT) ** 2)
        assert coulomb_speed == pytest.approx(smoothing_speed(z[2], p[1, 1], DT), rel=1e-12)
        extra = SHARE * friction_model_std(z[1], z[9], coulomb_speed)
        for state, more in zip(states, (0.0, extra), strict=True):
            update_force(
                state, excitation, monitor, ForceMeasurement(float(measured_f + more), 1e-4, 1e-12, REFERENCE, DT)
            )
    difference, bias = (states[1]["mean"][0] - states[0]["mean"][0]) / SHARE, nominal["friction_bias"]
    for name in (Z.D1, Z.D2, Z.D0):
        assert difference[name] == pytest.approx(bias[name], rel=0.1)
    assert bias[Z.D1] < -1.0  # more force at low speed: more friction, less damping
    assert bias[Z.D0] > 0.0


def test_the_interval_of_the_damping_covers_the_truth_where_friction_saturates_at_a_lower_speed():
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    run(estimator, record(TRANSMISSION_1, GENTLE, 60.0))
    state, bias = estimator.state(), estimator._supervisor.tracker.friction_bias
    assert abs(state.d1 - TRANSMISSION_1.d1) < 1.96 * np.sqrt(state.d1_variance)
    assert state.d1_variance == pytest.approx(estimator._supervisor.tracker.p[Z.D1, Z.D1] + bias[Z.D1] ** 2)
    assert abs(bias[Z.D1]) > 0.5 * np.sqrt(estimator._supervisor.tracker.p[Z.D1, Z.D1])
