# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Convergence from wrong start values to the true coefficients."""

from dataclasses import replace

import numpy as np
import pytest
from transmission_data import ANOTHER, MULTISINE, SLOW, TRANSMISSION_1, column, record, run, wrong_start
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator


@pytest.mark.parametrize("k2_factor", [0.7, 1.3])
@pytest.mark.parametrize("motion", [SLOW, MULTISINE])
@pytest.mark.parametrize("rig", [TRANSMISSION_1, ANOTHER])
def test_the_estimate_converges_from_start_values_that_are_wrong_by_a_third(rig, motion, k2_factor):
    recording = record(rig, motion, 30.0)
    estimator = Estimator(wrong_start(rig, k2_factor))
    estimates = run(estimator, recording)
    error = np.abs(np.log(column(estimates, "stiffness") / recording.stiffness))
    assert error[recording.stamp_ns > 1e9 + 16e9].max() < 0.05
    assert estimates[-1].status is Status.VALID
    late = slice(2000, None)
    assert np.sqrt(np.mean(error[late] ** 2)) < 0.003
    assert estimates[-1].k2 == pytest.approx(rig.k2, rel=0.005)
    state = estimator.state()
    assert state.d1 == pytest.approx(rig.d1, rel=0.03)
    assert abs(state.d1 - rig.d1) < 3.0 * state.d1_variance**0.5


def test_the_stiffness_interval_contains_the_truth_from_the_first_second_on():
    inside = []
    for seed in range(4):
        recording = record(TRANSMISSION_1, MULTISINE, 20.0, seed=seed)
        estimates = run(Estimator(wrong_start(TRANSMISSION_1, 0.7 + 0.6 * (seed % 2))), recording)
        stiffness = column(estimates, "stiffness")
        std = np.sqrt(column(estimates, "stiffness_variance")) / stiffness
        inside.append(np.abs(np.log(stiffness / recording.stiffness)) < 1.96 * std)
    assert np.mean(np.array(inside)[:, 100:]) > 0.9


def test_samples_at_1_khz_are_estimated_each_with_the_same_accuracy():
    recording = record(TRANSMISSION_1, MULTISINE, 20.0, rate=1000)
    estimates = run(Estimator(wrong_start(TRANSMISSION_1)), recording)
    late = slice(16_000, None)
    stiffness = column(estimates, "stiffness")[late]
    assert np.sqrt(np.mean((stiffness / recording.stiffness[late] - 1.0) ** 2)) < 0.003
    assert np.unique(stiffness).size == stiffness.size
    assert np.abs(np.diff(np.log(stiffness))).max() < 0.003  # 3 mm/s x k2 x 1 ms = 0.0008: no step at a filter update


def test_without_motion_the_status_is_converging_until_motion_begins():
    still = record(TRANSMISSION_1, (0.010, ()), 8.0)
    moving = record(TRANSMISSION_1, SLOW, 16.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimates = run(estimator, still)
    assert {estimate.status for estimate in estimates} == {Status.CONVERGING}
    std = np.sqrt(estimates[-1].stiffness_variance) / estimates[-1].stiffness
    assert abs(np.log(estimates[-1].stiffness / still.stiffness[-1])) < 2.0 * std
    for stamp_ns, force, deflection in zip(moving.stamp_ns, moving.force, moving.deflection, strict=True):
        last = estimator.add(int(stamp_ns) + 8_000_000_000, float(force), float(deflection))
    assert last.status is Status.VALID
    assert last.k2 == pytest.approx(TRANSMISSION_1.k2, rel=0.005)


def test_a_single_sweep_of_the_stroke_does_not_cause_overconfidence():
    wrong = []
    for seed in range(6):
        recording = record(TRANSMISSION_1, SLOW, 10.0, seed=seed)
        estimates = run(Estimator(wrong_start(TRANSMISSION_1, 0.7 + 0.6 * (seed % 2))), recording)
        stiffness = column(estimates, "stiffness")
        error = np.abs(stiffness / recording.stiffness - 1.0)
        beyond = error > np.maximum(4.0 * np.sqrt(column(estimates, "stiffness_variance")) / stiffness, 0.01)
        wrong.append(beyond & (column(estimates, "stiffness_valid") > 0))
    assert np.mean(wrong) < 0.01


def test_a_large_mass_in_a_single_tone_leaves_the_stiffness_invalid():
    heavy = replace(TRANSMISSION_1, mass=375.5)
    recording = record(heavy, (0.012, ((4.5e-4, 1.0),)), 20.0)
    estimates = run(Estimator(wrong_start(heavy)), recording)
    stiffness = column(estimates, "stiffness")
    std = np.sqrt(column(estimates, "stiffness_variance")) / stiffness
    assert not column(estimates, "stiffness_valid").any()
    assert np.all(np.abs(np.log(stiffness / recording.stiffness)) < 4.0 * std)
