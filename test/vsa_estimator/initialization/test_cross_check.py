# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cross-check of the filter by a regression over the same data."""

from functools import cache

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, measure, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import Z
from vsa_estimator.initialization.cross_check import CrossCheckSchedule
from vsa_estimator.initialization.scheduler import Initializer
from vsa_estimator.tuning.filter import MAHALANOBIS_LIMIT


@cache
def fed(spoil=None):
    """The estimator, without the bank, after 60 s; `spoil` changes its tracker at 14 s.

    That is in mode TRACKING, and before the parity check is established: later it suspends such a filter first.
    """
    recording = record(TRANSMISSION_1, MULTISINE, 60.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1, elastic_law="exponential"))
    samples = zip(recording.stamp_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    for index, sample in enumerate(samples):
        if index == 1400 and spoil:
            assert estimator._supervisor.modes.initialized
            spoil(estimator._supervisor.tracker)
        estimate = estimator.add(*sample)
    return estimator, estimate


def test_cross_checks_are_8_16_32_and_64_seconds_apart_and_not_rarer():
    schedule, now_ns, intervals = CrossCheckSchedule(), 0, []
    schedule.restart(now_ns)
    for _ in range(5):
        begin_ns = now_ns
        while not schedule.is_due(now_ns):
            now_ns += 1_000_000_000
        intervals.append((now_ns - begin_ns) // 1_000_000_000)
        schedule.postpone(now_ns)
    assert intervals == [8, 16, 32, 64, 64]


def set_confident_stiff_damper(tracker):
    tracker.z[Z.D1] *= 1.15
    tracker.z[Z.D2] *= 1.3
    tracker.z[Z.D0] = 0.1
    tracker.p[Z.D1 :, :] *= 1e-3
    tracker.p[:, Z.D1 :] *= 1e-3


def test_a_refuted_filter_becomes_less_certain_and_converges_without_a_reset():
    estimator, estimate = fed(set_confident_stiff_damper)
    state = estimator.state()
    assert estimate.reset_count == 0
    assert state.d1 == pytest.approx(TRANSMISSION_1.d1, rel=0.03)
    assert state.d2 == pytest.approx(TRANSMISSION_1.d2, rel=0.06)
    assert estimate.stiffness_valid
    assert estimate.damping_valid


def test_a_correct_filter_passes_the_cross_check():
    _, estimate = fed()
    assert estimate.reset_count == 0


def test_a_cross_check_fails_only_beyond_chance():
    estimator, _ = fed()
    tracker, covariance = (
        estimator._supervisor.tracker,
        np.diag((0.01 * estimator._supervisor.tracker.z[3:]) ** 2 + 1e-12),
    )
    rng = np.random.default_rng(1)
    near = rng.multivariate_normal(tracker.z[3:], covariance, 500)
    assert not any(tracker.cross_check_failed(mean, covariance, 0.01, 0.017) for mean in near)
    assert tracker.cross_check_failed(1.07 * tracker.z[3:], covariance, 0.01, 0.017)
    assert not tracker.cross_check_failed(1.07 * tracker.z[3:], covariance, 1.0, 0.017)  # an observable mass
    start = tracker.z[3:] + 20.0 * np.sqrt(np.diag(covariance)) * (np.arange(7) == Z.M - 3)
    assert not tracker.cross_check_failed(
        start, covariance, 0.01, 0.017
    )  # the mass has its initial value: it is not observable


def test_single_large_innovations_pass_the_nis_test_and_a_lasting_misfit_fails():
    initial, jolted = wrong_start(TRANSMISSION_1).initial, [60.0 if k % 50 < 4 else 1.0 for k in range(200)]
    for innovations, fails in ((jolted, False), ([4.0] * 200, True)):
        tracker = Tracker(initial, 100.0)
        for innovation in innovations:
            tracker._nis_test.add(innovation)
        assert tracker.nis_test_failed == fails


def steps(seconds=40.0, rate=100, rise=0.25, travel=1.5e-3):
    """Steps to and fro each second, three times faster than v*, with creep in between: t, x, v, a."""
    t = np.arange(round(seconds * rate)) / rate
    u, to = np.clip(np.mod(t, 1.0) / rise, 0.0, 1.0), travel * np.where(np.floor(t) % 2 == 0, 1.0, -1.0)
    creep, w = 2e-4, 2.0 * np.pi * 0.11
    x = 0.0115 + to * (u**3 * (10.0 - 15.0 * u + 6.0 * u * u) - 0.5) + creep * np.sin(w * t)
    v = to * 30.0 * u**2 * (1.0 - u) ** 2 / rise + creep * w * np.cos(w * t)
    a = to * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / rise**2 - creep * w * w * np.sin(w * t)
    return t, x, v, a


@pytest.mark.parametrize("seed", range(6))
def test_fast_steps_with_creep_between_them_do_not_bias_the_regression(seed):
    rig = TRANSMISSION_1
    recording = measure(rig, *steps(), seed)
    initializer, fit = Initializer(wrong_start(rig).initial, 100.0), None
    for sample in zip(1e-9 * recording.stamp_ns, recording.deflection, recording.force, strict=True):
        initializer.add(*sample)
    reference = float(recording.deflection[0])
    initializer.begin(0.01, reference, 0.017, 1.04e-5, 0.03, cross_check=True)
    while fit is None:
        fit = initializer.advance(0.01)
    s = np.log(rig.k1 * rig.k2) + rig.k2 * reference
    truth = np.array([s, rig.k2, rig.d1, rig.d2, rig.mass, rig.force_offset, rig.coulomb_friction])
    scale = np.sqrt(np.diag(fit.covariance))
    apart = (truth - fit.mean) / scale
    assert apart @ np.linalg.solve(fit.covariance / np.outer(scale, scale), apart) < 0.5 * MAHALANOBIS_LIMIT
