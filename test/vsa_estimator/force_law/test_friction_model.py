"""What the state would be off by, had the friction another form: carried through the filter, part of the interval."""

import numpy as np
import pytest
from transmission_data import TRANSMISSION_1, record, run, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.filter import ekf as step
from vsa_estimator.force_law.transmission import COULOMB_SPEED, SIZE, Z, force, friction_model_std

REFERENCE, DT, SHARE = 0.010, 0.01, 0.02
TRUTH = np.array([0.010, 0.0, 0.0, np.log(3000.0), 267.2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3])
STD = np.array([1e-5, 1e-3, 1e-2, 0.05, 10.0, 400.0, 2e7, 0.1, 1.0, 0.1])
GENTLE = (0.0085, ((2e-3, 0.06), (1.5e-4, 0.3)))


def law(state):
    return force(state, REFERENCE, COULOMB_SPEED, np.zeros(SIZE), np.zeros((SIZE, SIZE)))


def test_the_pull_is_what_a_friction_of_that_form_does_to_the_state():
    rng = np.random.default_rng(3)
    states = [np.array(TRUTH), np.array(TRUTH)]
    covariances = [np.diag(STD**2), np.diag(STD**2)]
    pull, monitor = np.zeros(SIZE), np.zeros(3)
    for k in range(3000):
        w, t = 2.0 * np.pi * 0.1, DT * k
        motion = 0.010 + 2e-3 * np.sin(w * t), 2e-3 * w * np.cos(w * t), -2e-3 * w * w * np.sin(w * t)
        measured_x = motion[0] + 1e-6 * rng.standard_normal()
        measured_f = law(np.array([*motion, *TRUTH[3:]])) + 0.01 * rng.standard_normal()
        for z, p, pulled in zip(states, covariances, (pull, None), strict=True):
            step.predict(z, p, DT, 1e-4)
            if pulled is not None:
                step.carry(pulled, DT)
            step.update_deflection(z, p, measured_x, 1e-12, 0.004, monitor, pulled)
        z, p = states[0], covariances[0]
        extra = SHARE * friction_model_std(z, np.sqrt(COULOMB_SPEED**2 + 1.5 * p[1, 1] + 0.125 * (z[2] * DT) ** 2))
        for z, p, pulled, more in zip(states, covariances, (pull, None), (0.0, extra), strict=True):
            step.update_force(z, p, REFERENCE, measured_f + more, 1e-4, 1e-12, DT, 0.004, monitor, pulled)
    found = (states[1] - states[0]) / SHARE
    for name in (Z.D1, Z.D2, Z.D0):
        assert found[name] == pytest.approx(pull[name], rel=0.1)
    assert pull[Z.D1] < -1.0  # more force at low speed looks like more friction and less damping
    assert pull[Z.D0] > 0.0


def test_the_interval_of_the_damping_holds_where_friction_saturates_sooner_than_the_model_has_it():
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    run(estimator, record(TRANSMISSION_1, GENTLE, 60.0))
    state, pull = estimator.state(), estimator._supervisor.tracker.friction_bias
    assert abs(state.d1 - TRANSMISSION_1.d1) < 1.96 * np.sqrt(state.d1_variance)
    assert state.d1_variance == pytest.approx(estimator._supervisor.tracker.p[Z.D1, Z.D1] + pull[Z.D1] ** 2)
    assert abs(pull[Z.D1]) > 0.5 * np.sqrt(estimator._supervisor.tracker.p[Z.D1, Z.D1])
