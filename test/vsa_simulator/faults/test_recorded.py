# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Failures in recorded signals, and stamps of late samples."""

import numpy as np
import pytest
from vsa_simulator.faults.recorded import DELAY_S, SPACING_NS, delayed, delivered, with_failure, with_pauses

DEFLECTION = 1e-5 * np.arange(100, 300)


def test_a_failure_changes_only_its_samples_and_by_its_amount():
    stepped = with_failure(DEFLECTION, "encoder wrong -v 0.001", range(50, 80), 100, 1)
    change = np.zeros(200)
    change[50:80] = 1e-3
    np.testing.assert_allclose(stepped - DEFLECTION, change, atol=1e-12)
    drifting = with_failure(np.zeros(200), "force drift -v 0.5", range(100, 200), 100, 1)
    np.testing.assert_allclose(drifting[100:], 0.005 * np.arange(100))


def test_a_deflection_below_zero_stays_below_zero():
    noisy = with_failure(np.zeros(2000), "encoder noise -v 10", range(2000), 100, 1)
    assert np.std(noisy) == pytest.approx(1e-4, rel=0.1)
    assert noisy.min() < 0.0 < noisy.max()


def test_samples_of_a_backlog_are_received_in_order_after_the_pause():
    sent = 10_000_000 * np.arange(4)
    late = with_pauses(sent, np.array([5_000_000]), np.array([20_000_000]))
    assert late.tolist() == [0, 25_000_000, 25_000_000 + SPACING_NS, 30_000_000]
    assert delivered(np.array([7, 5])).tolist() == [7, 7 + SPACING_NS]


def test_delays_are_positive_with_their_mean_and_keep_the_order():
    sent = 2_000_000 * np.arange(20_000)
    late = delayed(sent, np.random.default_rng(1))
    assert (np.diff(late) > 0).all()
    assert (late >= sent).all()
    assert 1e-9 * np.mean(late - sent) == pytest.approx(DELAY_S, rel=0.05)
