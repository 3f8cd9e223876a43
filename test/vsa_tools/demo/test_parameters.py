# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The parameter file of a run: its own values over those of the paper's rig."""

import argparse
from pathlib import Path

import numpy as np
import pytest
import yaml
from vsa_bench.harness.deployment import REST_S, Case, write_case
from vsa_common.config.configuration import load
from vsa_driver.settings import DriverSettings
from vsa_estimator.settings import NodeConfig
from vsa_simulator.node import SimulatorConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.rig import Rig
from vsa_tools.demo.command import clear, main, write_run
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, merge, write_parameters
from vsa_tools.demo.scenario import Scenario, ScenarioError, load_scenario


def options(folder: Path, seed: int = 3) -> argparse.Namespace:
    return argparse.Namespace(duration=12.0, rate=250, seed=seed, out=folder, view=False, scenario="")


@pytest.fixture
def parameters(tmp_path):
    changes = {"rig_simulator": {"profile": {"kind": "sine"}}}
    return write_run(tmp_path, options(tmp_path), 61_234, changes)


def test_layers_change_single_values_only():
    base = {"a": {"x": 1, "deep": {"y": 2, "z": 3}}}
    assert merge(base, {"a": {"deep": {"z": 4}}, "b": 5}) == {"a": {"x": 1, "deep": {"y": 2, "z": 4}}, "b": 5}
    assert base == {"a": {"x": 1, "deep": {"y": 2, "z": 3}}}


def test_the_rig_of_a_run_is_the_paper_rig_with_its_rate_port_and_truth_file(parameters, tmp_path):
    rig = load(parameters, "rig_simulator", SimulatorConfig)
    assert (rig.rate_hz, rig.duration, rig.seed, rig.autostart_clock) == (250, 12.0, 3, False)
    assert rig.truth_file == str(tmp_path / "truth.csv")
    assert rig.transmission_1.k2 == 267.2
    assert rig.profile.kind == "sine"
    assert rig.bus == load_without_autostart(parameters).bus


def load_without_autostart(path: Path) -> DriverSettings:
    tree = yaml.safe_load(path.read_text())
    assert tree["/**/driver"]["ros__parameters"].pop("autostart") is False
    path.write_text(yaml.safe_dump(tree))
    return load(path, "driver", DriverSettings)


def test_initial_coefficients_are_perturbed_within_two_standard_deviations(parameters):
    for side, k2 in ((1, 267.2), (2, 165.6)):
        start = load(parameters, f"estimator_{side}", NodeConfig).initial
        assert abs(start.k2 / k2 - 1.0) == pytest.approx(0.3)
        assert abs(start.k2 - k2) < 2.0 * start.k2_std
        assert abs(start.force_offset - {1: 16.39, 2: 8.269}[side]) < 2.0 * start.force_offset_std


def test_different_seeds_give_different_initial_coefficients(tmp_path):
    starts = set()
    for seed in range(8):
        path = write_run(tmp_path, options(tmp_path, seed), 61_234, {})
        starts.add(load(path, "estimator_1", NodeConfig).initial)
    assert len(starts) > 3


def test_a_parameter_file_has_no_aliases(tmp_path):
    shared = {"interface": "virtual"}
    path = tmp_path / "p.yaml"
    write_parameters(path, base_parameters(), {"driver": {"bus": shared}, "rig_simulator": {"bus": shared}})
    assert "&" not in path.read_text()  # an alias; the parser of ROS does not support it


def test_only_outputs_of_a_demo_are_cleared(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag.mcap").write_text("")
    for name in ("summary.json", "control.json", "pushes.yaml", "coefficients.yaml"):
        (tmp_path / name).write_text("")
    (tmp_path / "notes.txt").write_text("mine")
    clear(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("--rate", "5", "rate_hz = 5 Hz: must be within 10 to 10000 Hz"),
        ("--seed", "-1", "seed = -1: must be within 0 to"),
        ("--duration", "-1", "-1 s: must be above 0 s"),
        ("--duration", "nan", "nan s: must be above 0 s"),
        ("--duration", "inf", "inf s: must be above 0 s"),
    ],
)
def test_a_bad_option_is_refused_before_the_outputs_of_an_earlier_demo_are_removed(
    tmp_path, capsys, option, value, expected
):
    (tmp_path / "summary.json").write_text("earlier")
    with pytest.raises(SystemExit) as end:
        main(["--out", str(tmp_path), option, value])
    assert end.value.code == 2  # as for an unknown option
    assert expected in capsys.readouterr().err
    assert (tmp_path / "summary.json").read_text() == "earlier"


def test_two_runs_never_share_a_domain_or_a_port():
    domains = [claim_domain() for _ in range(10)]
    assert len({one.domain for one in domains}) == len({one.bus_port for one in domains}) == 10
    assert domains[0].environment()["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_the_plain_demo_is_an_empty_scenario(tmp_path):
    plain = load_scenario("", options(tmp_path))
    assert type(plain) is Scenario
    assert (plain.parameters(), list(plain.processes()), plain.evaluate(tmp_path)) == ({}, [], {})
    assert plain.failures({}) == []
    with pytest.raises(ScenarioError, match="no scenario 'moon'"):
        load_scenario("moon", options(tmp_path))


def test_initial_stiffness_is_off_by_a_factor_of_two_at_the_balanced_force(parameters):
    # F1 = F2 at rest without torque: the same force on both sides, eq. (3)
    rig = load(parameters, "rig_simulator", SimulatorConfig)
    force = 16.39 + 0.776 * np.exp(267.2 * rig.profile.centre)
    for side in (1, 2):
        start = load(parameters, f"estimator_{side}", NodeConfig).initial
        true = getattr(rig, f"transmission_{side}")
        ratio = start.k2 * (force - start.force_offset) / (true.k2 * (force - true.force_offset))
        assert ratio in (pytest.approx(2.0), pytest.approx(0.5))


@pytest.mark.parametrize("spring", ["linear", "quadratic", "sinh", "softening", "tabulated"])
def test_with_another_spring_initial_stiffness_is_off_by_a_factor_of_two_at_rest(tmp_path, spring):
    laws = {"spring": {"kind": spring}, "damper": {"kind": "quadratic"}}
    path = write_run(tmp_path, options(tmp_path), 61_234, {"rig_simulator": laws})
    rest = Rig(load(path, "rig_simulator", SimulatorConfig)).advance(1).truth[0]
    for side, k2 in ((1, 267.2), (2, 165.6)):
        start = load(path, f"estimator_{side}", NodeConfig).initial
        true, force = (rest[TRUTH.index(f"{name}_{side}")] for name in ("stiffness", "force"))
        assert start.k2 * (force - start.force_offset) / true in (pytest.approx(2.0), pytest.approx(0.5))
        assert start.k2 / k2 in (pytest.approx(0.7), pytest.approx(1.3))
        assert start.d1 / 1000.0 in (pytest.approx(0.6), pytest.approx(1.6))  # d1 / 4 at rest


def realtime_of(path, node):
    return yaml.safe_load(path.read_text())[node]["ros__parameters"].get("realtime", {})


def test_in_a_live_bench_each_composed_joint_has_a_core_and_the_rigs_share_another(tmp_path, monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {5, 2, 7})
    write_case(tmp_path / "case.yaml", Case("composed", 1000, 2, 10.0), 40_000)
    found = [
        realtime_of(tmp_path / "case.yaml", f"/joint_{i}/{name}")
        for i in (1, 2)
        for name in ("driver", "rig_simulator")
    ]
    rig = {"cores": "2"}
    assert found == [{"cores": "5", "busy": True}, rig, {"cores": "7", "busy": True}, rig]


@pytest.mark.parametrize(
    ("case", "asked"),
    [
        (Case("composed", 1000, 3, 10.0), {"rest": REST_S}),
        (Case("separate", 1000, 1, 10.0), {"rest": REST_S}),
        (Case("ordinary_executor", 1000, 1, 10.0), {}),
    ],
    ids=lambda value: getattr(value, "mode", ""),
)
def test_without_cores_to_spare_a_live_bench_leaves_them_to_the_kernel(tmp_path, monkeypatch, case, asked):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 1, 2})
    write_case(tmp_path / "case.yaml", case, 40_000)
    assert realtime_of(tmp_path / "case.yaml", "/joint_1/driver") == asked
