# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Scores and bound of the bench against analytic values, and its command."""

import json
import math

import numpy as np
import pytest
from vsa_bench import command as bench
from vsa_bench.estimation.bound import equivalent_jerk_density, force_gradients, posterior_bound
from vsa_bench.estimation.cases import DEFAULT, QUICK, RIGS, case
from vsa_bench.estimation.command import main
from vsa_bench.estimation.methods import METHODS
from vsa_bench.estimation.recordings import RESOLUTION, record, simulate
from vsa_bench.estimation.score import confidently_wrong, score, time_to_accuracy
from vsa_bench.estimation.starts import draw
from vsa_bench.estimation.track import Track

KEYS = {"converged", "time_to_5pct_s", "stiffness_nrmse", "damping_nrmse", "k2_error", "d2_error", "coverage", "nees",
        "nees_band", "ratio_to_bound", "us_per_step"}  # fmt: skip


@pytest.fixture(scope="module")
def recording():
    return record(case(motion="slow2"), [1, 2, 3], 20.0)


def track(recording, error=0.0, std=0.01, valid=1.0) -> Track:
    """A method with the relative error `error` everywhere and the relative standard deviation `std`."""
    truth = recording.truth
    shape = recording.force.shape
    stiffness = np.broadcast_to((1.0 + error) * truth.stiffness, shape)
    k2 = np.full(shape, (1.0 + error) * truth.coefficients.k2)
    damping = np.broadcast_to(truth.damping, shape)
    ones = np.full(shape, valid)
    return Track(
        stiffness=stiffness, stiffness_variance=(std * stiffness) ** 2, stiffness_valid=ones,
        damping=damping, damping_variance=np.ones(shape), damping_valid=ones,
        inertia=np.ones(shape), inertia_variance=np.ones(shape), inertia_valid=np.zeros(shape),
        k2=k2, k2_variance=(std * k2) ** 2, d2=np.full(shape, truth.coefficients.d2),
        nees=np.full((3, 20), 3.0), jerk_density=1e-4, seconds=6e-3,
    )  # fmt: skip


def test_errors_are_fractions(recording):
    result = score(track(recording, error=0.02), recording, None)
    assert result["stiffness_nrmse"] == pytest.approx(0.02)
    assert result["k2_error"] == pytest.approx(0.02)
    assert result["damping_nrmse"] == 0.0
    assert result["d2_error"] == 0.0
    assert result["converged"] == 1.0
    assert result["us_per_step"] == pytest.approx(1.0)
    assert result["nees"] == 3.0


@pytest.mark.parametrize(("error", "covered"), [(0.0, 1.0), (0.019, 1.0), (0.0205, 0.0)])
def test_coverage_counts_intervals_that_contain_the_truth(recording, error, covered):
    assert score(track(recording, error), recording, None)["coverage"]["stiffness"] == covered


def test_confidently_wrong_counts_valid_samples_beyond_four_deviations(recording):
    assert confidently_wrong(track(recording, 0.05), recording)["stiffness"] == 1.0
    assert confidently_wrong(track(recording, 0.05, valid=0.0), recording)["stiffness"] == 0.0
    assert confidently_wrong(track(recording, 0.05, std=0.02), recording)["stiffness"] == 0.0
    assert confidently_wrong(track(recording, 0.009, std=1e-4), recording)["stiffness"] == 0.0


def test_time_to_five_per_cent_is_the_last_entry_into_the_band():
    time = np.arange(10) * 0.5
    error = np.zeros((4, 10))
    error[0, :4] = 0.2
    error[1, [0, 6]] = -0.2
    error[3, -1] = 0.2
    np.testing.assert_array_equal(time_to_accuracy(error, time), [2.0, 3.5, 0.0, np.inf])


def test_a_diverged_run_gives_no_figure(recording):
    diverged = Track(stiffness=np.full(recording.force.shape, np.nan))
    result = score(diverged, recording, None)
    assert result["converged"] == 0.0
    assert result["stiffness_nrmse"] is None
    json.dumps(result, allow_nan=False)


def test_the_bound_of_a_known_motion_is_that_of_weighted_least_squares(recording):
    """Without encoder noise the motion is known; the coefficients' bound is then prior + sum g g' / s^2, inverted."""
    quiet = record(case(motion="slow2", deflection_noise_mm=1e-5, force_noise_n=0.017), [1], 20.0)
    start = draw(case(motion="slow2"), float(quiet.truth.deflection[0]), 1)
    bound = posterior_bound(quiet, start, 1e-3)
    gradients = force_gradients(quiet.truth)[:, 3:]
    names = ("k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
    prior = np.array([math.log(2.0), *(start.std[name] for name in names)])
    scaled = gradients * prior
    ideal = np.linalg.inv(np.eye(7) + scaled.T @ scaled / quiet.force_noise**2) * np.outer(prior, prior)
    assert bound.k2[-1] >= ideal[1, 1]
    # the quantisation acts through the stiffness, with at most 1.7 times the noise of the force sensor
    assert bound.k2[-1] < 8.0 * ideal[1, 1]
    assert np.all(np.diff(bound.k2) <= 1e-9)


def test_more_noise_is_a_higher_bound(recording):
    start = draw(case(), 0.012, 1)
    noisy = record(case(motion="slow2", deflection_noise_mm=0.1), [1], 20.0)
    low, high = (posterior_bound(one, start, 1e-4) for one in (recording, noisy))
    assert high.ln_stiffness[-1] > 4.0 * low.ln_stiffness[-1]


def test_force_gradients_are_derivatives_of_the_force():
    truth = simulate(case().coefficients, "slow2", 100, 20.0)
    c = truth.coefficients
    k, h = 1500, 1e-9
    spring = [c.k1 * math.exp(c.k2 * (truth.deflection[k] + s * h)) for s in (1.0, -1.0)]
    assert force_gradients(truth)[k, 0] == pytest.approx((spring[0] - spring[1]) / (2.0 * h), rel=1e-5)
    at_reference = math.log(truth.stiffness[0])
    dx = truth.deflection[k] - truth.deflection[0]
    elastic = [math.exp(at_reference + k2 * dx) / k2 for k2 in (c.k2 + 1e-4, c.k2 - 1e-4)]
    assert force_gradients(truth)[k, 4] == pytest.approx((elastic[0] - elastic[1]) / 2e-4, rel=1e-5)


def test_the_jerk_density_of_a_sine_is_its_power_over_its_frequency():
    truth = simulate(case(coulomb_friction_n=0.0).coefficients, "one_hz", 1000, 30.0)
    w = 2.0 * np.pi
    jerk = 0.45e-3 * w**3
    assert equivalent_jerk_density(truth) == pytest.approx(jerk**2 / w, rel=0.3)


def test_samples_are_the_truth_with_the_noise_of_the_case(recording):
    force_error = recording.force - recording.truth.force
    deflection_error = recording.deflection - recording.truth.deflection
    assert force_error.std() == pytest.approx(0.017, rel=0.05)
    assert deflection_error.std() == pytest.approx(math.hypot(1e-5, RESOLUTION / math.sqrt(12.0)), rel=0.05)
    assert np.abs(recording.deflection / RESOLUTION - np.round(recording.deflection / RESOLUTION)).max() < 1e-6


def test_force_and_motion_obey_the_law():
    """Eqs. (2) to (6) on the truth of the rig."""
    truth = simulate(case().coefficients, "slow", 100, 30.0)
    c = truth.coefficients
    held = np.clip(truth.velocity, -c.maximum_speed, c.maximum_speed)
    law = c.force_offset + c.k1 * np.exp(c.k2 * truth.deflection) + c.d1 * held + c.d2 * held**3
    law += c.inertia * truth.acceleration + c.coulomb_friction * np.tanh(truth.velocity / 5e-5)
    np.testing.assert_allclose(truth.force, law, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_a_bad_start_has_the_documented_errors(seed):
    one = case()
    c = one.coefficients
    elastic = c.k1 * math.exp(c.k2 * 0.0105)
    start = draw(one, 0.0105, seed).value
    assert start["k2"] / c.k2 in (pytest.approx(0.7), pytest.approx(1.3))
    stiffness = start["k2"] * (c.force_offset + elastic - start["force_offset"])
    assert stiffness / (c.k2 * elastic) in (pytest.approx(0.5), pytest.approx(2.0))
    assert start["inertia"] == pytest.approx(2.0 * c.inertia)


def test_the_default_cases_cover_all_motions_masses_and_rigs():
    assert {one.motion for one in DEFAULT} >= {"slow", "slow2", "multisine", "half_hz", "fast", "dwells", "one_hz"}
    assert {one.mass for one in DEFAULT} == {"light", "heavy"}
    assert {one.rig for one in DEFAULT} == set(RIGS)
    assert {one.coefficients.inertia for one in DEFAULT if one.mass == "heavy"} == {5.0}
    assert len(set(DEFAULT)) == len(DEFAULT)
    assert all(one.force_noise_n == (0.13 if one.deflection_noise_mm == 0.1 else 0.017) for one in (*DEFAULT, *QUICK))


def test_the_command_writes_every_method_with_every_key(tmp_path, capsys):
    arguments = ["--seeds", "1", "--seed", "5", "--seconds", "20", "--motion", "slow2"]
    files = ["--json", str(tmp_path / "b.json"), "--plot", str(tmp_path / "b.png")]
    assert main([*arguments, *files]) == 0
    report = json.loads((tmp_path / "b.json").read_text())
    (one,) = report["cases"]
    assert (one["transmission"], one["motion"], one["rate_hz"], len(one["seeds"])) == (
        "transmission_1",
        "slow2",
        100,
        1,
    )
    assert set(one["methods"]) == set(METHODS)
    for result in one["methods"].values():
        assert set(result) >= KEYS
        assert set(result["coverage"]) >= {"stiffness", "damping", "k2"}
    assert one["methods"]["force"]["stiffness_nrmse"] < one["methods"]["recursive_least_squares"]["stiffness_nrmse"]
    assert (tmp_path / "b.png").stat().st_size > 10_000
    assert "grioli_bicchi" in capsys.readouterr().out


def test_options_give_every_combination(tmp_path):
    arguments = [
        "--method",
        "menard",
        "--seeds",
        "1",
        "--seconds",
        "5",
        "--motion",
        "slow",
        "slow2",
        "--rate",
        "100",
        "1000",
    ]
    assert main([*arguments, "--json", str(tmp_path / "b.json")]) == 0
    cases = json.loads((tmp_path / "b.json").read_text())["cases"]
    assert [(one["motion"], one["rate_hz"]) for one in cases] == [
        ("slow", 100), ("slow", 1000), ("slow2", 100), ("slow2", 1000)
    ]  # fmt: skip


def test_seeds_are_random_unless_given(tmp_path):
    arguments = ["--method", "menard", "--seeds", "2", "--seconds", "5", "--motion", "slow", "--json"]
    seeds = []
    for extra in ([], [], ["--seed", "7"], ["--seed", "7"]):
        main([*arguments, str(tmp_path / "b.json"), *extra])
        seeds.append(json.loads((tmp_path / "b.json").read_text())["cases"][0]["seeds"])
    assert seeds[0] != seeds[1]
    assert seeds[2] == seeds[3]


def test_bench_lists_its_benches(capsys):
    assert bench.main(["nothing"]) == 2
    assert "estimation" in capsys.readouterr().err
    assert bench.main(["--help"]) == 0
    assert bench.main(["estimation", "--seeds", "1", "--seconds", "3", "--method", "menard", "--motion", "slow"]) == 0
