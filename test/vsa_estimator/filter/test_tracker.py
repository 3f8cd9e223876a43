# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Filter of one transmission: copies, records, start values, uncertainty as an explicit update."""

import copy

import numpy as np
import pytest
from vsa_estimator.filter.chi_square import mahalanobis_square
from vsa_estimator.filter.excitation import accumulate_time_since_motion, is_stationary
from vsa_estimator.filter.initial_state import initial_coefficients
from vsa_estimator.filter.records import initial_excitation
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import SIZE, Z
from vsa_estimator.settings import EstimatorConfig

INITIAL = EstimatorConfig().initial


def started():
    tracker = Tracker(INITIAL, 100.0)
    tracker.start(0.01, 30.0, 1e-10)
    return tracker


def step(tracker):
    tracker.predict(0.01, 1e-3)
    tracker.update_deflection(0.0101, 1e-10)
    tracker.update_force(30.1, 1e-4, 1e-10, 0.01)


def test_updates_write_through_the_views_into_the_record():
    tracker = started()
    step(tracker)
    assert tracker.z[Z.X] == tracker.state[0]["mean"][Z.X] != 0.01
    assert np.shares_memory(tracker.p, tracker.state)
    assert tracker.force_monitor["nis"][0] > 0.0


def test_a_copy_has_its_own_state():
    tracker = started()
    other = copy.deepcopy(tracker)
    step(other)
    assert np.shares_memory(other.z, other.state)
    assert not np.shares_memory(other.z, tracker.state)
    assert tracker.z[Z.X] == 0.01
    step(tracker)
    assert np.array_equal(tracker.state, other.state)


def test_a_query_of_the_uncertainty_changes_no_state():
    tracker = started()
    step(tracker)
    before = tracker.state.copy()
    assert tracker.uncertainty.k2_variance == 0.0
    assert np.array_equal(tracker.state, before)
    tracker.update_uncertainty()
    assert tracker.uncertainty.k2_variance >= tracker.p[Z.K2, Z.K2]
    assert tracker.uncertainty.k2 == tracker.z[Z.K2]


def test_start_values_have_a_positive_definite_covariance():
    mean, covariance = initial_coefficients(INITIAL, 30.0, 1e-3)
    assert mean.shape == (SIZE - 3,)
    assert np.array_equal(covariance, covariance.T)
    scale = np.sqrt(np.diag(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > 0.0


def test_the_transmission_is_stationary_after_half_a_second_without_motion():
    excitation, z, p = initial_excitation(), np.zeros(SIZE), np.zeros((SIZE, SIZE))
    for _ in range(49):
        accumulate_time_since_motion(excitation, z, p, 0.01)
    assert not is_stationary(excitation)
    for _ in range(2):
        accumulate_time_since_motion(excitation, z, p, 0.01)
    assert is_stationary(excitation)
    z[Z.V] = 1e-3
    accumulate_time_since_motion(excitation, z, p, 0.01)
    assert not is_stationary(excitation)


def test_the_mahalanobis_distance_is_scale_invariant():
    error, covariance = np.array([1.0, 2.0]), np.array([[4.0, 1.0], [1.0, 2.0]])
    expected = error @ np.linalg.inv(covariance) @ error
    scale = np.array([1e6, 1e-6])
    assert mahalanobis_square(error, covariance) == pytest.approx(expected)
    assert mahalanobis_square(scale * error, np.outer(scale, scale) * covariance) == pytest.approx(expected)


def test_restored_coefficients_begin_a_new_window_of_innovations():
    tracker = started()
    for _ in range(400):
        tracker._nis_test.add(10.0)
    assert tracker.nis_test_failed
    tracker.restore(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference)
    assert not tracker.nis_test_failed
