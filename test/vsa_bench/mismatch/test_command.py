# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases, filters, one case from end to end, and the command."""

import json
import math
from itertools import chain

import numpy as np
import pytest
from vsa_bench.mismatch import command
from vsa_bench.mismatch.cases import ALL, GROUP_OF, MOTIONS, QUICK, VARIANTS, Case, chosen
from vsa_bench.mismatch.run import NOMINAL, PEERS, estimate, peer_stiffness, run_case, run_figures, start_parameters
from vsa_common.types import Array
from vsa_estimator.formulations import create_estimator
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.rig.recording import Simulation, TransmissionVariant

PAPER = "spring_exponential"


def peak(values: Array) -> float:
    return float(np.abs(values).max())


def test_every_case_differs_from_the_papers_rig_and_from_the_others():
    variants = list(chain.from_iterable(members.values() for members in VARIANTS.values()))
    assert len(set(variants)) == len(variants) == len(GROUP_OF) == 27
    assert [name for name in GROUP_OF if VARIANTS[GROUP_OF[name]][name] == TransmissionVariant()] == [PAPER]
    assert len(set(ALL)) == len(ALL) == 27 * 5 * 2
    assert set(QUICK) <= set(ALL)
    assert {one.group for one in QUICK} == set(VARIANTS)
    assert {one.motion for one in QUICK} == set(MOTIONS)


def test_only_fast_motion_and_steps_exceed_the_peak_speed_and_no_motion_the_force_range():
    for name, motion in MOTIONS.items():
        simulation = Simulation(TransmissionVariant(), motion, 60.0, 100)
        assert (peak(simulation.velocity) > NOMINAL.maximum_speed) == (name in ("fast", "dwells")), name
        assert peak(simulation.force) < 150.0, name


def test_filters_select_by_name_group_motion_and_rate():
    assert list(chosen(ALL, [], [], [])) == list(ALL)
    assert {one.name for one in chosen(ALL, ["dampers", "crosstalk"], [], [])} == {*VARIANTS["dampers"], "crosstalk"}
    assert list(chosen(ALL, ["bouc_wen"], ["sine", "fast"], [1000])) == [
        Case("bouc_wen", "sine", 1000), Case("bouc_wen", "fast", 1000)
    ]  # fmt: skip
    assert list(chosen(QUICK, ["spring_sinh"], ["dwells"], [])) == []


@pytest.mark.parametrize("name", [PAPER, "spring_quadratic", "spring_linear", "scale_drift_10"])
def test_the_start_has_twice_or_half_the_true_stiffness_for_any_spring(name):
    one = Case(name, "mix", 100)
    simulation = Simulation(one.variant, MOTIONS["mix"], 1.0, 100)
    ratios = set()
    for seed in range(12):
        start = start_parameters(simulation, seed)
        assert start["initial.k2"] / 267.2 in (pytest.approx(0.7), pytest.approx(1.3))
        stiffness = start["initial.k2"] * (simulation.force[0] - start["initial.force_offset"])
        ratios.add(round(float(stiffness / simulation.stiffness[0]), 6))
    assert ratios == {0.5, 2.0}


def test_a_case_has_the_figures_of_its_estimates_taken_sample_by_sample():
    one, seed, seconds = Case(PAPER, "mix", 100), 7, 25.0
    result = run_case(one, [seed], seconds)
    simulation = Simulation(one.variant, MOTIONS["mix"], seconds, 100)
    recording = simulation.recording(seed)
    assert result["median"]["stiffness"] == result["runs"][0]["stiffness"]
    rows = estimate(recording, start_parameters(simulation, seed))
    late = range(math.ceil(0.3 * (len(rows) - 1)), len(rows))
    valid = [k for k in late if rows["stiffness_valid"][k]]
    errors = sorted(abs(rows["stiffness"][k] / simulation.stiffness[k] - 1.0) for k in valid)
    figures = result["runs"][0]["stiffness"]
    assert figures["valid"] == pytest.approx(len(valid) / len(late))
    assert figures["error"] == pytest.approx(float(np.median(errors)))
    assert figures["error"] < 0.01
    damping = result["runs"][0]["damping"]
    errors = [
        abs(rows["damping"][k] - simulation.damping[k]) / max(simulation.damping[k], 800.0)
        for k in late
        if rows["damping_valid"][k]
    ]
    assert damping["error"] == (pytest.approx(float(np.median(errors))) if errors else None)
    assert set(result["runs"][0]["peers"]) == set(PEERS)
    json.dumps(result, allow_nan=False)


def test_the_damping_of_a_quadratic_damper_is_not_wrong_beside_an_exponential_spring():
    case = Case("damper_quadratic", "mix", 100)
    simulation = Simulation(case.variant, case.profile, 60.0, 100)
    rows = estimate(simulation.recording(3), start_parameters(simulation, 3))
    damping = run_figures(rows, simulation)["damping"]
    assert damping["valid"] > 0.9
    assert damping["wrong"] < 0.005
    assert damping["coverage"] > 0.8


def test_the_estimator_has_the_default_configuration_but_for_its_start():
    simulation = Simulation(TransmissionVariant(), MOTIONS["mix"], 3.0, 100)
    recording = simulation.recording(1)
    default = create_estimator(EstimatorConfig())
    samples = zip(recording.stamp_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    stiffness = [one.stiffness for sample in samples if isinstance(one := default.add(*sample), Estimate)]
    np.testing.assert_array_equal(estimate(recording, {})["stiffness"], stiffness)


def test_peers_follow_a_spring_that_is_not_exponential():
    one = Case("spring_quadratic", "mix", 100)
    simulation = Simulation(one.variant, MOTIONS["mix"], 40.0, 100)
    stiffness = peer_stiffness([simulation.recording(1)], one)["recursive_least_squares"][0, 2000:]
    assert np.median(np.abs(stiffness / simulation.stiffness[2000:] - 1.0)) < 0.02


def test_stamps_with_jitter_are_evaluated_on_the_samples_that_are_used():
    result = run_case(Case("stamp_jitter", "mix", 1000), [1], 4.0)
    assert 0.0 <= result["median"]["dropped"] < 0.9


def test_the_command_writes_the_cases_and_prints_the_same_tables_from_its_file(tmp_path, capsys):
    path = tmp_path / "folder" / "m.json"
    choice = ["--case", "spring_sinh", "friction", "--motion", "narrow", "--rate", "100"]
    arguments = [*choice, "--seeds", "2", "--seed", "5", "--seconds", "8", "--no-recordings", "--workers", "2"]
    assert command.main([*arguments, "--json", str(path), "--markdown"]) == 0
    printed = capsys.readouterr().out
    report = json.loads(path.read_text())
    assert [(one["case"], one["motion"], one["rate_hz"]) for one in report["cases"]] == [
        ("spring_sinh", "narrow", 100), ("friction_stribeck", "narrow", 100), ("friction_lugre", "narrow", 100)
    ]  # fmt: skip
    assert all(len(one["runs"]) == len(set(one["seeds"])) == 2 for one in report["cases"])
    assert report["cases"][0]["seeds"] == report["cases"][1]["seeds"]
    assert report["recorded"] == []
    assert "### Required figures" in printed
    assert command.main(["--from", str(path), "--markdown"]) == 0
    assert capsys.readouterr().out == printed


def test_real_recordings_are_skipped_with_one_line_where_there_is_no_folder(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(command, "run_cases", lambda *arguments: [])
    assert command.main(["--quick", "--recordings", str(tmp_path / "none")]) == 0
    assert f"no folder {tmp_path / 'none'}" in capsys.readouterr().err
    monkeypatch.chdir(tmp_path)
    assert command.shared_data() is None
    (tmp_path / "shared" / "data").mkdir(parents=True)
    (tmp_path / "main").mkdir()
    monkeypatch.chdir(tmp_path / "main")
    assert command.shared_data() == tmp_path / "shared" / "data"


def test_a_choice_without_a_case_is_an_error(capsys):
    with pytest.raises(SystemExit):
        command.main(["--quick", "--case", "friction_lugre"])
    assert "no case has the given" in capsys.readouterr().err


def test_a_failure_names_its_case(monkeypatch):
    def fail(case, seeds, seconds):
        raise ValueError("no estimate")

    monkeypatch.setattr(command, "run_case", fail)
    message = r"spring_exponential mix 100 Hz, seeds \[1, 2\]: ValueError\('no estimate'\)"
    with pytest.raises(RuntimeError, match=message):
        command.run_cases([Case(PAPER, "mix", 100)], [1, 2], 1.0, 1)


def test_a_missing_file_of_a_former_run_gives_a_one_line_error(tmp_path, capsys):
    assert command.main(["--from", str(tmp_path / "none.json")]) == 1
    assert capsys.readouterr().err.count("\n") == 1
