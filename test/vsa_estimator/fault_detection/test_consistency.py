# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""End of a suspension where a shift of the encoder, or another law, would not show."""

from types import SimpleNamespace

import numpy as np
import pytest
from vsa_estimator.fault_detection.consistency import NOMINAL, ConsistencyMonitor
from vsa_estimator.fault_detection.residual import Coefficients
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import C
from vsa_estimator.modes import Event
from vsa_estimator.settings import Initial

K2 = Initial().k2


def decision(shift, of_force=True, of_encoder=False, change=0.0):
    """Decision and coefficients of consistent residuals after a fault of `shift` [m], which would show or not."""
    tracker = Tracker(Initial(), 100.0)
    tracker.start(0.010, 30.0, 1e-10)
    present = Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference)
    monitor = ConsistencyMonitor(100.0, 4e-3, lambda: present)
    monitor._parity = SimpleNamespace(
        is_consistent=True, is_inconsistent=False, fault_size=(1.0, shift), checkpoint=present,
        growth=K2, has_expired=False,
        measure_fault=lambda: None, end_fault=lambda: None, replace=lambda coefficients: None,
        fault_would_show=lambda of_encoder=True, shows=(of_force, of_encoder): shows[of_encoder],
        hidden_change=lambda: change,
    )  # fmt: skip
    return monitor._suspended(), present


def test_a_fault_that_would_show_ends_with_the_coefficients_of_the_checkpoint():
    assert decision(1e-3, of_encoder=True)[0] == (Event.CONSISTENT, None, *NOMINAL[2:])


@pytest.mark.parametrize("share", [0.1, 0.9])
def test_a_small_shift_of_the_encoder_that_would_not_show_counts_in_the_stiffness(share):
    shift = share * 0.1 / K2
    found, before = decision(shift)
    assert found.event is Event.CONSISTENT
    assert np.array_equal(found.restore.mean, before.mean)
    added = found.restore.covariance - before.covariance
    assert added[C.S, C.S] == pytest.approx((K2 * shift) ** 2)
    assert np.count_nonzero(added) == 1


def test_a_shift_that_makes_the_stiffness_invalid_is_waited_for():
    assert decision(1.1 * 0.1 / K2)[0] is NOMINAL


def test_a_shift_of_the_force_that_would_not_show_is_waited_for():
    assert decision(1e-6, of_force=False)[0] is NOMINAL


def test_a_small_change_of_the_law_that_would_not_show_counts_in_the_stiffness():
    found, before = decision(1e-6, of_encoder=True, change=0.02)
    assert found.event is Event.CONSISTENT
    assert (found.restore.covariance - before.covariance)[C.S, C.S] == pytest.approx(0.02**2)


def test_a_change_of_the_law_that_makes_the_stiffness_invalid_is_waited_for():
    assert decision(1e-6, of_encoder=True, change=0.11)[0] is NOMINAL


def test_hidden_shift_and_change_count_together():
    assert decision(0.08 / K2, change=0.08)[0] is NOMINAL
