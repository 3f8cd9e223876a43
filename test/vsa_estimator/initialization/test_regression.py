"""From a start that is wrong in everything to the true coefficients."""

from dataclasses import replace

import numpy as np
import pytest
from transmission_data import ANOTHER, MULTISINE, SLOW, TRANSMISSION_1, column, record, run, wrong_start
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.initialization.posterior import Fit
from vsa_estimator.initialization.row_noise import whiten
from vsa_estimator.initialization.windows import BAND
from vsa_estimator.tuning.initialization import INCONSISTENCY_DECAY


@pytest.mark.parametrize("k2_factor", [0.7, 1.3])
@pytest.mark.parametrize("motion", [SLOW, MULTISINE])
@pytest.mark.parametrize("rig", [TRANSMISSION_1, ANOTHER])
def test_it_converges_from_a_start_that_is_wrong_by_a_third(rig, motion, k2_factor):
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


def test_the_interval_holds_from_the_first_second_on():
    inside = []
    for seed in range(4):
        recording = record(TRANSMISSION_1, MULTISINE, 20.0, seed=seed)
        estimates = run(Estimator(wrong_start(TRANSMISSION_1, 0.7 + 0.6 * (seed % 2))), recording)
        stiffness = column(estimates, "stiffness")
        std = np.sqrt(column(estimates, "stiffness_variance")) / stiffness
        inside.append(np.abs(np.log(stiffness / recording.stiffness)) < 1.96 * std)
    assert np.mean(np.array(inside)[:, 100:]) > 0.9


def test_a_kilohertz_stream_is_estimated_at_every_sample_and_no_worse():
    recording = record(TRANSMISSION_1, MULTISINE, 20.0, rate=1000)
    estimates = run(Estimator(wrong_start(TRANSMISSION_1)), recording)
    late = slice(16_000, None)
    stiffness = column(estimates, "stiffness")[late]
    assert np.sqrt(np.mean((stiffness / recording.stiffness[late] - 1.0) ** 2)) < 0.003
    assert np.unique(stiffness).size == stiffness.size
    assert np.abs(np.diff(np.log(stiffness))).max() < 0.003  # 3 mm/s x k2 x 1 ms = 0.0008, and no sawtooth


def test_without_motion_it_stays_converging_and_learns_when_motion_comes():
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


def test_a_single_sweep_of_the_stroke_is_not_believed_more_than_it_says():
    wrong = []
    for seed in range(6):
        recording = record(TRANSMISSION_1, SLOW, 10.0, seed=seed)
        estimates = run(Estimator(wrong_start(TRANSMISSION_1, 0.7 + 0.6 * (seed % 2))), recording)
        stiffness = column(estimates, "stiffness")
        error = np.abs(stiffness / recording.stiffness - 1.0)
        beyond = error > np.maximum(4.0 * np.sqrt(column(estimates, "stiffness_variance")) / stiffness, 0.01)
        wrong.append(beyond & (column(estimates, "stiffness_valid") > 0))
    assert np.mean(wrong) < 0.01


def test_a_heavy_mass_behind_one_tone_leaves_the_stiffness_unknown():
    heavy = replace(TRANSMISSION_1, mass=375.5)
    recording = record(heavy, (0.012, ((4.5e-4, 1.0),)), 20.0)
    estimates = run(Estimator(wrong_start(heavy)), recording)
    stiffness = column(estimates, "stiffness")
    std = np.sqrt(column(estimates, "stiffness_variance")) / stiffness
    assert not column(estimates, "stiffness_valid").any()
    assert np.all(np.abs(np.log(stiffness / recording.stiffness)) < 4.0 * std)


def test_a_fit_that_leaps_from_the_one_before_is_as_wide_as_the_leap():
    def fit(ln_stiffness, std, k2=250.0):
        mean = np.array([ln_stiffness, k2, 4e3, -1e8, 0.4, 16.0, 0.3])
        return Fit(mean, np.diag([std**2, 25.0, 1e4, 1e14, 0.1, 0.1, 0.01]), 0.02, 0.01, 1e-3)

    first, near, far = fit(7.0, 0.1), fit(7.2, 0.03), fit(7.4, 0.03)
    assert first.fuse_with_previous(None) is first
    assert np.array_equal(near.fuse_with_previous(first).covariance, near.covariance)
    leapt = far.fuse_with_previous(first)
    assert np.array_equal(leapt.mean, far.mean)
    assert leapt.covariance[0, 0] == pytest.approx(0.4**2 + 0.03**2)
    back = near.fuse_with_previous(leapt)  # from one so wide that is no leap, but the doubt lasts
    assert back.covariance[0, 0] == pytest.approx((INCONSISTENCY_DECAY * 0.4) ** 2 + 0.03**2)
    assert near.fuse_with_previous(back).covariance[0, 0] == pytest.approx(
        (INCONSISTENCY_DECAY**2 * 0.4) ** 2 + 0.03**2
    )


def test_a_leap_of_k2_makes_it_too_uncertain_to_start_a_filter_from():
    def fit(k2):
        mean = np.array([7.0, k2, 4e3, -1e8, 0.4, 16.0, 0.3])
        return Fit(mean, np.diag([1e-4, 25.0, 1e4, 1e14, 0.1, 0.1, 0.01]), 0.02, 0.01, 1e-3)

    assert fit(260.0).fuse_with_previous(fit(250.0)).ln_k2_std == pytest.approx(0.02)
    leapt = fit(230.0).fuse_with_previous(fit(250.0))
    assert leapt.covariance[1, 1] == pytest.approx(20.0**2 + 25.0)
    assert leapt.ln_k2_std == pytest.approx(np.hypot(0.02, 20.0 / 230.0))


def test_rows_that_share_noise_are_made_white():
    random = np.random.default_rng(3)
    full = np.convolve(random.standard_normal(400_003), [0.5, 1.0, -0.7, 0.3])[3:-3].reshape(-1, 20)
    kernel = np.correlate([0.5, 1.0, -0.7, 0.3], [0.5, 1.0, -0.7, 0.3], "full")[3:]
    covariance = np.zeros((20, BAND + 1))
    for apart, value in enumerate(kernel):
        covariance[apart:, apart] = value
    columns = full.T.copy()
    whiten(covariance, columns)
    assert np.cov(columns) == pytest.approx(np.eye(20), abs=0.04)
