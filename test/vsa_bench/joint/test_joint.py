# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Experiment on the joint without ROS: short runs against the truth of the rig."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from vsa_bench.joint import command as bench_joint
from vsa_bench.joint.case import Case, external_torque, geometry, rig_config, travel
from vsa_bench.joint.experiment import identify, record, run, used_rows
from vsa_bench.joint.operating_point import OperatingPoint, transmissions_of
from vsa_bench.joint.recorded import identify_series
from vsa_bench.joint.report import case_json, identified_covers
from vsa_joint.impedance.reflection import virtual_work
from vsa_joint.settings import JointConfig
from vsa_simulator.rig.transmission import spring_force, transmission_from

KEYS = {
    "co_contraction", "tendon_n_per_m", "coulomb_friction", "amplitude_nm", "seed", "expansion_valid", "identified",
    "estimated", "consistent", "paper", "response_error", "interval_holds",
}  # fmt: skip


@pytest.fixture(scope="module")
def with_friction():
    return run(Case(50.0, 1e5, 0.3, 4))


def test_with_friction_the_experiment_agrees_with_the_rig_and_the_estimate_with_the_experiment(with_friction):
    o = with_friction
    identified = o.identified.impedance
    assert identified.stiffness == pytest.approx(o.truth.stiffness, rel=0.01)
    assert identified.damping == pytest.approx(o.truth.damping, rel=0.03)
    assert o.estimated.stiffness == pytest.approx(identified.stiffness, rel=0.015)
    assert o.estimated.damping == pytest.approx(identified.damping, rel=0.04)
    assert identified_covers(o, "stiffness")
    assert identified_covers(o, "damping")


def test_a_case_has_every_key_and_survives_json(with_friction):
    case = json.loads(json.dumps(case_json(with_friction)))
    assert case.keys() >= KEYS
    assert case["response_error"] is None
    assert case["co_contraction"] == pytest.approx(25.0, rel=0.02)


def test_the_printed_damping_term_is_twice_the_true_one(with_friction):
    o = with_friction
    assert (o.printed.damping - 0.01) / (o.truth.damping - 0.01) == pytest.approx(2.0, rel=0.15)


def test_the_torque_without_friction_is_twenty_millinewtonmetres_rms():
    case = Case(50.0, 1e5, 0.0, 1)
    assert external_torque(case, rig_config(case)).rms == pytest.approx(0.02)


@pytest.mark.parametrize("spring", ["quadratic", "sinh"])
def test_with_another_spring_the_experiment_agrees_with_the_rig(spring):
    case = Case(50.0, 1e5, 0.0, 4, spring)
    config, used = rig_config(case), used_rows(case)
    recording, joint = record(case, config), geometry(config)
    rows = recording.truth[used][::50]
    impedances = [virtual_work(transmissions_of(row), joint) for row in rows]
    truth = OperatingPoint(rows, frictionless=True).at_rest(impedances)
    identified, response = identify(case, config, recording, used)
    assert response.error < 0.01
    assert identified.impedance.stiffness == pytest.approx(truth.stiffness, rel=0.01)
    assert identified.impedance.damping == pytest.approx(truth.damping, rel=0.03)


def test_with_another_spring_the_estimate_agrees_with_the_experiment():
    o = run(Case(50.0, 1e5, 0.3, 4, "quadratic"))
    assert o.estimated.stiffness == pytest.approx(o.identified.impedance.stiffness, rel=0.015)
    assert o.identified.impedance.stiffness == pytest.approx(o.truth.stiffness, rel=0.01)
    assert case_json(o)["spring"] == "quadratic"


@pytest.mark.parametrize("spring", ["exponential", "quadratic", "stop"])
def test_the_travel_of_a_force_balances_any_spring(spring):
    """Bisection of the rod's static force at the travel."""
    rig = rig_config(Case(50.0, 1e5, 0.3, 1, spring))
    for side in (rig.transmission_1, rig.transmission_2):
        transmission, end = transmission_from(side, rig), travel(50.0, side, rig)
        low, high = 0.0, 0.02
        while high - low > 1e-12:
            x = 0.5 * (low + high)
            surplus = 2.0 * side.tendon_stiffness * (end - 2.0 * x) - spring_force(x, transmission)
            low, high = (x, high) if surplus > 0.0 else (low, x)
        assert spring_force(low, transmission) == pytest.approx(50.0, abs=1e-4)


def test_the_spring_of_the_option_is_that_of_all_cases():
    cases = bench_joint._cases(bench_joint._arguments(["--spring", "sinh", "--quick"]))
    assert {case.spring for case in cases} == {"sinh"}
    assert {rig_config(case).spring.kind for case in cases} == {"sinh"}


def test_seeds_differ_between_frictions_and_repeats():
    arguments = bench_joint._arguments(["--seeds", "2"])
    cases = bench_joint._cases(arguments)
    frictional = [case for case in cases if not case.frictionless]
    assert len(frictional) == 60
    assert len(set(frictional)) == 60
    assert len(cases) - len(frictional) == 15


def series(case, drop=slice(0, 0)):
    """Angle and torque as in a bag: 40 samples per second with stamps."""
    config = rig_config(case)
    recording = record(case, config)
    stamps = 1e9 * np.arange(len(recording.angle)) / case.rate_hz
    keep = np.delete(np.arange(round(40.0 * case.rate_hz), len(stamps), 5), drop)
    joint = geometry(config)
    return [np.stack([stamps[keep], values[keep]], axis=1) for values in (recording.angle, recording.torque)], joint


def test_recorded_series_are_identified_with_an_interval(with_friction):
    (angle, torque), joint = series(with_friction.case)
    identified, truth = identify_series(angle, torque, joint, 20.0), with_friction.truth
    assert identified.impedance.stiffness == pytest.approx(truth.stiffness, rel=0.01)
    assert identified.impedance.damping == pytest.approx(truth.damping, rel=0.03)
    assert abs(identified.impedance.stiffness - truth.stiffness) < 3.0 * identified.std.stiffness


def test_a_recording_with_a_gap_or_too_short_raises():
    rows = np.stack([1e9 * np.arange(0.0, 50.0, 0.025), np.zeros(2000)], axis=1)
    joint = JointConfig().joint
    with pytest.raises(ValueError, match="joint_states: 1"):
        identify_series(np.delete(rows, slice(500, 540), axis=0), rows, joint, 20.0)
    with pytest.raises(ValueError, match="expected two periods"):
        identify_series(rows[:1000], rows[:1000], joint, 20.0)


def test_a_missing_bag_gives_a_one_line_error(capsys, tmp_path):
    assert bench_joint.main(["--bag", str(tmp_path / "none")]) == 1
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("text", ["/**/joint:\n  ros__parameters: {joint: {radius: wide}}\n", "a: [\n"])
def test_an_invalid_configuration_is_a_one_line_error(tmp_path, capsys, text):
    (tmp_path / "mine.yaml").write_text(text)
    assert bench_joint.main(["--bag", str(tmp_path), "--config", str(tmp_path / "mine.yaml")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "mine.yaml" in error


def test_ctrl_c_ends_the_experiment_with_one_line():
    code = "import sys; from vsa_bench.command import main; sys.exit(main(['joint']))"
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    time.sleep(8.0)  # within the first experiments
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert errors.endswith("bench joint: stopped\n")
