# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Processes of a launch file from its arguments."""

from pathlib import Path

import pytest
import yaml
from vsa_bringup import robot_description
from vsa_bringup.arguments import arguments, options
from vsa_bringup.deployment import COMPOSED, RIG, SEPARATE, processes
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.sections import sections
from vsa_common.ros.subprocesses import executable
from vsa_tools.demo.parameters import base_parameters

DEFAULTS = {one.name: one.default for one in arguments()} | {"robot_description": "false"}
TWO = "/left/driver: {ros__parameters: {silence: 0.1}}\n/right/driver: {ros__parameters: {silence: 0.1}}\n"
SUITE = [("driver", "vsa"), ("estimator_1", "vsa"), ("estimator_2", "vsa"), ("joint", "vsa")]


def started(programs=SEPARATE, **given):
    return processes(options(DEFAULTS | given), programs)


def identities(found):
    return [(process.name or process.executable, process.namespace) for process in found]


@pytest.mark.parametrize("programs", [SEPARATE, (*SEPARATE, RIG), COMPOSED], ids=["joint", "simulated", "composed"])
def test_every_process_exists_and_its_nodes_are_in_the_parameter_file(programs):
    for program in programs:
        assert Path(executable(program.package, program.executable)).exists()
        assert set(program.nodes) <= base_parameters().keys()


def test_the_default_is_the_four_nodes_with_the_parameter_file():
    found = started()
    assert identities(found) == SUITE
    assert {process.parameter_files for process in found} == {(DEFAULTS["config"],)}
    assert {(process.log_level, process.on_exit, process.arguments) for process in found} == {("", "continue", ())}


def test_controller_recorder_and_live_page_are_started_in_the_namespace():
    found = started(namespace="left", controller="true", record="/tmp/bag", view="8090", log_level="warn")
    assert identities(found) == [
        *((name, "left") for name, _ in SUITE),
        ("stiffness_controller", "left"),
        ("recorder", "left"),
        ("view", ""),
    ]
    assert found[-2].arguments == ("--out", "/tmp/bag")
    assert found[-1].arguments == ("--namespace", "/left", "--port", "8090")
    assert {process.log_level for process in found[:-1]} == {"warn"}
    assert started(record="true")[-1].arguments == ()


def test_composed_is_one_process_that_finds_its_joints_or_has_one_namespace(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text(TWO)
    found = started(COMPOSED, config=str(file), namespace="auto", record="/tmp/bag", view="true")
    assert identities(found) == [
        ("composed", ""),
        ("recorder", "left"),
        ("view", ""),
        ("recorder", "right"),
        ("view", ""),
    ]
    assert [process.arguments[-1] for process in found[1:]] == ["/tmp/bag_left", "8080", "/tmp/bag_right", "8081"]
    of_nodes = sections(found[0].parameter_files[1])
    assert of_nodes["/**/estimator_1" if "/left/estimator_1" not in of_nodes else "/left/estimator_1"] == {
        "frame_prefix": "left/"
    }
    assert identities(started(COMPOSED, config=str(file), namespace="right")) == [("composed", "right")]


def test_separate_nodes_are_started_for_each_joint_of_the_file(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text(TWO)
    found = started(config=str(file), namespace="auto")
    assert {space for _, space in identities(found)} == {"left", "right"}
    assert len(found) == 8


def installed(monkeypatch, *packages):
    monkeypatch.setattr(robot_description, "_is_installed", lambda name: name in packages)


def test_description_and_rviz_are_started_where_they_are_installed(monkeypatch):
    pytest.importorskip("xacro")
    installed(monkeypatch, "robot_state_publisher", "xacro", "rviz2")
    found = started(namespace="left", robot_description="auto", rviz="true", use_sim_time="true")
    publisher, rviz = found[-2:]
    assert identities([publisher, rviz]) == [("robot_state_publisher", "left"), ("rviz2", "left")]
    (values,) = sections(publisher.parameter_files[0]).values()
    assert (values["frame_prefix"], values["use_sim_time"]) == ("left/", True)
    assert values["robot_description"].startswith("<?xml")
    display = yaml.safe_load(Path(rviz.arguments[1]).read_text())["Visualization Manager"]
    assert display["Global Options"]["Fixed Frame"] == "left/base_link"


def test_description_and_rviz_that_are_not_installed(monkeypatch):
    installed(monkeypatch, "xacro")
    assert identities(started(robot_description="auto")) == SUITE
    with pytest.raises(ConfigurationError, match="robot_description = true: not installed: robot_state_publisher"):
        started(robot_description="true")
    with pytest.raises(ConfigurationError, match="rviz = true: not installed: rviz2"):
        started(rviz="true")
