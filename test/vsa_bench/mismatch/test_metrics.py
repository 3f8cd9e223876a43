# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures on arrays with known errors, and their aggregate."""

import numpy as np
import pytest
from vsa_bench.mismatch.metrics import Estimates, aggregate, peer_error, quantity_figures, settling

COUNT = 1000
TRUE = np.linspace(1000.0, 5000.0, COUNT)
ALL = np.ones(COUNT, dtype=bool)


def figures(error, std, valid=ALL, **options):
    """Of an estimate with relative errors and standard deviations."""
    estimates = Estimates(TRUE * (1.0 + error), (TRUE * std) ** 2, valid)
    return quantity_figures(estimates, TRUE, TRUE, **options)


def test_error_and_half_width_are_medians_over_the_valid_samples():
    error = np.where(np.arange(COUNT) < 400, 0.5, 0.02)
    result = figures(error, 0.03, np.arange(COUNT) >= 300)
    assert result["valid"] == pytest.approx(0.7)
    assert result["error"] == pytest.approx(0.02)
    assert result["half_width"] == pytest.approx(1.959964 * 0.03)


def test_errors_are_relative_to_the_scale():
    estimates = Estimates(np.full(3, 90.0), np.full(3, 25.0), np.ones(3, dtype=bool))
    result = quantity_figures(estimates, np.zeros(3), np.full(3, 800.0))
    assert result["error"] == pytest.approx(90.0 / 800.0)
    assert result["half_width"] == pytest.approx(1.959964 * 5.0 / 800.0)
    assert result["wrong"] == 1.0


@pytest.mark.parametrize(
    ("error", "std", "valid", "wrong"),
    [(0.05, 0.01, True, 1.0), (0.05, 0.013, True, 0.0), (0.009, 0.001, True, 0.0), (0.05, 0.01, False, 0.0)],
    ids=("wrong", "within 4 deviations", "within 1 %", "invalid"),
)
def test_wrong_is_valid_and_beyond_four_deviations_and_one_per_cent(error, std, valid, wrong):
    assert figures(error, std, ALL & valid)["wrong"] == wrong


def test_wrong_is_a_share_of_all_samples_and_coverage_of_the_valid_ones():
    error = np.where(np.arange(COUNT) < 100, 0.2, 0.0)
    result = figures(error, 0.01, np.arange(COUNT) < 200)
    assert result["wrong"] == pytest.approx(0.1)
    assert result["coverage"] == pytest.approx(0.5)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_the_interval_of_gaussian_errors_covers_95_per_cent(logarithmic):
    noise = 0.02 * np.random.default_rng(3).standard_normal(200_000)
    true = np.full(noise.size, 3000.0)
    value = true * np.exp(noise) if logarithmic else true * (1.0 + noise)
    std = 0.02 * (value if logarithmic else true)
    result = quantity_figures(Estimates(value, std**2, np.ones(noise.size, dtype=bool)), true, true, logarithmic)
    assert result["coverage"] == pytest.approx(0.95, abs=0.002)


def test_the_interval_of_stiffness_is_logarithmic():
    """The interval of half the true stiffness with a relative deviation of 0.36 ends at 1.01 times the truth."""
    assert figures(-0.5, 0.18, logarithmic=True)["coverage"] == 1.0
    assert figures(-0.5, 0.18)["coverage"] == 0.0


def test_without_a_valid_sample_there_is_no_error():
    result = figures(0.1, 0.01, ~ALL)
    assert result == {"valid": 0.0, "error": None, "coverage": None, "wrong": 0.0, "half_width": None}


def test_settling_is_the_last_entry_into_five_per_cent():
    time = np.arange(100) * 0.1
    stiffness = np.full(100, 1000.0)
    stiffness[:30] = 1200.0
    stiffness[50] = 900.0
    true = np.full(100, 1000.0)
    assert settling(stiffness, true, time) == {"time_to_5pct_s": pytest.approx(5.1), "converged": True}
    stiffness[80] = 900.0
    assert settling(stiffness, true, time) == {"time_to_5pct_s": pytest.approx(8.1), "converged": False}
    stiffness[-1] = 900.0
    assert settling(stiffness, true, time) == {"time_to_5pct_s": None, "converged": False}


def test_a_peer_that_diverges_has_no_error():
    assert peer_error(np.array([1.1, 0.9, 1.0]), np.ones(3)) == pytest.approx(0.1)
    assert peer_error(np.full(3, np.nan), np.ones(3)) is None


def run(error, seconds, coverage=0.9):
    one = {"valid": 1.0, "error": error, "coverage": coverage, "wrong": 0.0, "half_width": 0.01}
    return {
        "stiffness": one, "damping": one, "inertia": one, "peers": {"menard": 2.0 * error if error else None},
        "time_to_5pct_s": seconds, "converged": seconds is not None, "dropped": 0.0,
    }  # fmt: skip


def test_the_aggregate_is_the_median_of_the_runs_and_the_share_of_converged_ones():
    result = aggregate([run(0.1, 4.0), run(0.3, 9.0), run(None, None, coverage=None)])
    assert result["stiffness"]["error"] == pytest.approx(0.2)
    assert result["peers"]["menard"] == pytest.approx(0.4)
    assert result["time_to_5pct_s"] == 9.0
    assert result["converged"] == pytest.approx(2.0 / 3.0)
    assert aggregate([run(0.1, 4.0), run(0.1, None), run(0.1, None)])["time_to_5pct_s"] is None
