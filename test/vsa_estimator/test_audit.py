"""A filter that settled beside the truth, and is sure of it, is found out by a regression over the same data."""

from functools import cache

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.model import Z
from vsa_estimator.values import Reset


@cache
def fed(spoil=None):
    """The estimator after 60 s; at 20 s, when it knows, `spoil` gets its tracker."""
    recording = record(TRANSMISSION_1, MULTISINE, 60.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    samples = zip(recording.stamp_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    for index, sample in enumerate(samples):
        if index == 2000 and spoil:
            assert estimator._tracker.knows
            spoil(estimator._tracker)
        estimate = estimator.add(*sample)
    return estimator, estimate


def sure_of_a_stiff_damper(tracker):
    tracker.z[Z.D1] *= 1.15
    tracker.z[Z.D2] *= 1.3
    tracker.z[Z.D0] = 0.1
    tracker.p[Z.D1 :, :] *= 1e-3
    tracker.p[:, Z.D1 :] *= 1e-3


def test_it_learns_again_and_counts_it():
    estimator, estimate = fed(sure_of_a_stiff_damper)
    state = estimator.state()
    assert estimate.reset_reason is Reset.INNOVATION
    assert state.d1 == pytest.approx(TRANSMISSION_1.d1, rel=0.03)
    assert state.d2 == pytest.approx(TRANSMISSION_1.d2, rel=0.06)
    assert estimate.stiffness_valid
    assert estimate.damping_valid


def test_a_filter_that_is_right_is_left_alone():
    _, estimate = fed()
    assert estimate.reset_count == 0


def test_a_regression_contradicts_beyond_chance_alone():
    estimator, _ = fed()
    tracker, covariance = estimator._tracker, np.diag((0.01 * estimator._tracker.z[3:]) ** 2 + 1e-12)
    rng = np.random.default_rng(1)
    near = rng.multivariate_normal(tracker.z[3:], covariance, 500)
    assert not any(tracker.contradicts(mean, covariance, 0.017) for mean in near)
    assert tracker.contradicts(1.07 * tracker.z[3:], covariance, 0.017)
    assert not tracker.contradicts(1.07 * tracker.z[3:], covariance, 1e-6)  # a mass that is felt
