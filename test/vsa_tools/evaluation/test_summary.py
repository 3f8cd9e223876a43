# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of merit of runs with known errors."""

import numpy as np
import pytest
from vsa_tools.evaluation.recorded_run import Frames
from vsa_tools.evaluation.summary import (
    Coefficient,
    Geometry,
    JointRun,
    Series,
    Transmission,
    converged_after,
    coverage,
    joint_summary,
    joint_truth,
    latency_summary,
    log_coverage,
    nrmse,
    transmission_summary,
)

RATE = 100.0
N = 1000


def truth() -> dict[str, np.ndarray]:
    phase = 2 * np.pi * np.arange(N) / 200
    return {
        "stiffness_1": 4000 + 1000 * np.sin(phase),
        "stiffness_2": 3000 - 500 * np.sin(phase),
        "damping_1": 4000 - 500 * np.cos(phase),
        "damping_2": 3000 + 100 * np.cos(phase),
    }


def run(scale: float = 1.0, std: float = 10.0, missing: tuple[int, ...] = ()) -> Transmission:
    sample = np.setdiff1d(np.arange(N), missing)
    true = truth()
    spread = np.full(len(sample), std)
    coefficient = Coefficient(1.0, 2.0, 0.1, 2.05)
    return Transmission(
        len(sample),
        sample,
        Series(true["stiffness_1"][sample] * scale, spread),
        Series(true["damping_1"][sample] * scale, spread),
        {"k2": coefficient, "d2": coefficient, "inertia": coefficient},
        False,
    )


def test_a_perfect_run_has_no_error_and_no_loss():
    summary = transmission_summary(run(), truth(), 1, RATE)
    assert (summary["samples_sent"], summary["samples_fused"], summary["samples_lost"]) == (N, N, 0)
    assert summary["stiffness_nrmse"] == summary["damping_nrmse"] == 0.0
    assert summary["stiffness_coverage95"] == summary["damping_coverage95"] == 1.0
    assert summary["converged_after_s"] == 0.0


def test_lost_samples_are_counted():
    summary = transmission_summary(run(missing=(3, 500, 999)), truth(), 1, RATE)
    assert (summary["samples_fused"], summary["samples_lost"]) == (N - 3, 3)


def test_estimates_without_a_sample_or_after_the_end_are_ignored():
    good = run()
    more = Transmission(
        N,
        np.r_[good.sample, [-1, N + 5]],
        Series(np.r_[good.stiffness.value, [1.0, 1.0]], np.r_[good.stiffness.std, [1.0, 1.0]]),
        Series(np.r_[good.damping.value, [1.0, 1.0]], np.r_[good.damping.std, [1.0, 1.0]]),
        good.coefficients,
        True,
    )
    assert transmission_summary(more, truth(), 1, RATE)["stiffness_nrmse"] == 0.0


def test_a_run_one_percent_off_has_an_error_of_one_percent():
    summary = transmission_summary(run(1.01), truth(), 1, RATE)
    assert summary["stiffness_nrmse"] == pytest.approx(0.01)
    assert summary["stiffness_coverage95"] == 0.0


def test_only_the_last_thirty_percent_are_evaluated():
    late = run()
    late.stiffness.value[: int(0.7 * N)] *= 3.0
    summary = transmission_summary(late, truth(), 1, RATE)
    assert summary["stiffness_nrmse"] == 0.0
    assert summary["converged_after_s"] == pytest.approx(7.0)


def test_coefficients_appear_with_the_names_of_the_interface():
    summary = transmission_summary(run(), truth(), 1, RATE)
    assert summary["k2"] == {"start": 1.0, "estimate": 2.0, "std": 0.1, "truth": 2.05}
    assert summary["inertia"] == {"start": 1.0, "estimate": 2.0, "std": 0.1, "truth": 2.05, "valid": False}


def test_stamps_map_to_their_sample_and_unknown_stamps_to_none():
    frames = Frames(np.array([10, 20, 30]), np.array([5, 6, 9]))
    assert list(frames.samples(np.array([30, 10, 25, 5, 40]))) == [9, 5, -1, -1, -1]
    assert list(Frames(np.array([], dtype=int), np.array([], dtype=int)).samples(np.array([1]))) == [-1]


def test_convergence_is_after_the_last_error_above_the_limit():
    time, true = np.arange(5.0), np.full(5, 100.0)
    assert converged_after(time, np.array([90.0, 100, 94, 104, 100]), true) == 3.0
    assert converged_after(time, np.array([100.0, 100, 100, 100, 106]), true) is None
    assert converged_after(time, np.array([np.nan, 100, 100, 100, 100]), true) == 1.0
    assert converged_after(time, true, true) == 0.0
    assert converged_after(time[:0], true[:0], true[:0]) is None


def test_a_transient_of_a_step_ends_no_convergence():
    time, estimate = np.arange(100) * 0.01, np.full(100, 100.0)
    estimate[:20] = estimate[50:59] = 90.0
    assert converged_after(time, estimate, np.full(100, 100.0)) == pytest.approx(0.2)
    estimate[80:92] = 90.0
    assert converged_after(time, estimate, np.full(100, 100.0)) == pytest.approx(0.92)


def test_the_coverage_of_a_gaussian_error_is_the_nominal_one():
    rng = np.random.default_rng(1)
    true = np.full(20000, 50.0)
    # three standard errors of a fraction of 0.95 over 20000 draws are 0.005
    value = true + 2.0 * rng.standard_normal(20000)
    assert coverage(Series(value, np.full(20000, 2.0)), true) == pytest.approx(0.95, abs=0.005)
    value = true * np.exp(0.3 * rng.standard_normal(20000))
    assert log_coverage(Series(value, 0.3 * value), true) == pytest.approx(0.95, abs=0.005)


def test_a_soft_transmission_leaves_a_quarter_through_a_rigid_tendon():
    geometry = Geometry(0.02, (1e12, 1e12), 0.01)
    index = np.arange(N)
    stiffness, damping = joint_truth(truth(), (index, index), geometry)
    true = truth()
    assert stiffness == pytest.approx(0.02**2 / 4 * (true["stiffness_1"] + true["stiffness_2"]))
    assert damping == pytest.approx(0.01 + 0.02**2 / 4 * (true["damping_1"] + true["damping_2"]))


def test_the_joint_has_the_impedance_of_the_paper_rig():
    # design: K_t = 2000 N/mm, x = 9.00 and 5.23 mm give K = 0.5853, D = 0.9345 with a rigid tendon and 1/4
    k = [0.776e0 * 267.2 * np.exp(267.2 * 0.009), 7.031 * 165.6 * np.exp(165.6 * 0.00523)]
    columns = {f"stiffness_{i}": np.array([k[i - 1]]) for i in (1, 2)} | {
        f"damping_{i}": np.array([4000.0]) for i in (1, 2)
    }
    one = np.array([0])
    stiffness, damping = joint_truth(columns, (one, one), Geometry(0.0215, (2e6, 2e6), 0.01))
    assert stiffness[0] == pytest.approx(0.5851, rel=2e-3)
    assert damping[0] == pytest.approx(0.9339, rel=2e-3)


def test_each_side_of_the_joint_is_evaluated_at_its_own_sample():
    geometry = Geometry(0.02, (1e5, 1e5), 0.01)
    first, second = np.arange(1, N), np.arange(0, N - 1)
    stiffness, damping = joint_truth(truth(), (first, second), geometry)
    spread = np.full(N - 1, 1e-3)
    summary = joint_summary(
        JointRun((first, second), Series(stiffness, spread), Series(damping, spread)), truth(), geometry
    )
    assert summary == {"messages": N - 1, "stiffness_nrmse": 0.0, "damping_nrmse": 0.0, "stiffness_coverage95": 1.0}


@pytest.mark.parametrize(("scale", "covered"), [(0.4, 1.0), (5.0, 0.0)])
def test_the_interval_of_the_joint_stiffness_is_symmetric_in_the_logarithm(scale, covered):
    geometry, index = Geometry(0.02, (1e5, 1e5), 0.01), np.arange(N)
    stiffness, damping = joint_truth(truth(), (index, index), geometry)
    value = scale * stiffness
    run_of_joint = JointRun((index, index), Series(value, 0.5 * value), Series(damping, damping))
    # exp(+-0.98) is a factor of 0.38 to 2.66; 1 +- 0.98 is one of 0.02 to 1.98
    assert joint_summary(run_of_joint, truth(), geometry)["stiffness_coverage95"] == covered


def test_latency_is_in_milliseconds():
    assert latency_summary(np.arange(101) * 1_000_000) == {"p50": 50.0, "p99": 99.0, "max": 100.0}
    assert latency_summary(np.array([], dtype=int)) == {"p50": None, "p99": None, "max": None}


def test_an_empty_run_has_no_figures_and_raises_no_error():
    assert nrmse(np.array([]), np.array([])) is None
    empty = run(missing=tuple(range(N)))
    assert transmission_summary(empty, truth(), 1, RATE)["samples_lost"] == N
