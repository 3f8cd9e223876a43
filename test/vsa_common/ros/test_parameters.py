# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of a node: types stay, texts of numbers are numbers, a dump can be loaded, changes while active."""

import os
import sys
from dataclasses import dataclass

import pytest
import rclpy
import yaml
from rcl_interfaces.msg import ParameterType
from rclpy.parameter import Parameter
from vsa_common.config.configuration import ConfigurationError, choice, flatten, load, quantities, quantity, string
from vsa_common.ros.node import SuiteNode

DOMAIN = 20 + (os.getpid() + 30) % 80


@dataclass(frozen=True)
class Example:
    noise: float = quantity(0.017, "N", 1e-6, 100.0, "noise", tunable=True)
    gain: float = quantity(2.0, "", 0.0, 100.0, "gain")
    count: int = quantity(3, "", 0, 10, "how many")
    radius: tuple[float, ...] = quantities((1.0, 2.0), "m", 0.0, 5.0, "radius")
    names: tuple[str, ...] = string(("",), "names")
    kind: str = choice("sine", ("sine", "ramp"), "which")


class ExampleNode(SuiteNode):
    """Records the configurations that are applied while it is active."""

    def __init__(self):
        super().__init__("example", Example)
        self.applied = []

    def reconfigure(self, config):
        if config.noise == 13.0:
            raise ConfigurationError("noise = 13.0 N: not now")
        self.applied.append(config)


@pytest.fixture
def start(monkeypatch):
    nodes = []

    def start(*arguments):
        command = ["example", "--ros-args", *arguments]
        monkeypatch.setattr(sys, "argv", command)
        rclpy.init(args=command, domain_id=DOMAIN)
        nodes.append(ExampleNode())
        return nodes[-1]

    yield start
    for node in nodes:
        node.close()
        node.destroy_node()
    rclpy.try_shutdown()


def change(node, name, value):
    return node.set_parameters_atomically([Parameter(name, value=value)])


@pytest.mark.parametrize(
    ("name", "value", "stored"),
    [
        ("noise", 1, 1.0),
        ("noise", "1e-3", 1e-3),
        ("noise", "1e-05", 1e-5),
        ("noise", "1.0e-5", 1e-5),
        ("noise", "+2.", 2.0),
        ("count", "4", 4),
        ("radius", [1, 2], [1.0, 2.0]),
        ("radius", ["1e-3", "2e0"], [1e-3, 2.0]),
        ("names", [], []),
    ],
)
def test_a_parameter_keeps_its_type_and_a_number_may_be_a_text(start, name, value, stored):
    node = start()
    kind = node.get_parameter(name).type_
    assert change(node, name, value).successful
    now = node.get_parameter(name)
    assert now.type_ is kind
    assert node.describe_parameter(name).type == kind.value
    assert (list(now.value) if isinstance(stored, list) else now.value) == stored
    assert flatten(node.config)[name] == (tuple(stored) if isinstance(stored, list) else stored)


@pytest.mark.parametrize(
    ("name", "value"),
    [("noise", "much"), ("noise", "1_0"), ("noise", True), ("count", 2.5), ("count", 11), ("kind", "chirp"),
     ("noise", float("nan")), ("radius", [9.0]), ("noise", None)],
)  # fmt: skip
def test_a_bad_value_is_refused_and_changes_nothing(start, name, value):
    node = start()
    before = node.get_parameter(name)
    assert not change(node, name, value).successful
    assert node.get_parameter(name).value == before.value
    assert node.config == Example()


@pytest.mark.parametrize("text", ["1e-3", "1e-05", "1.0e-5", "1"])
def test_numbers_of_the_command_line_and_of_files_are_doubles(start, tmp_path, text):
    file = tmp_path / "rig.yaml"
    file.write_text(f"/**/example:\n  ros__parameters: {{noise: {text}, gain: '{text}'}}\n")
    node = start(
        "--params-file", str(file), "-p", f"radius:=[{text},{text}]" if "." in text or "e" in text else "count:=1"
    )
    for name in ("noise", "gain"):
        assert node.get_parameter(name).type_ is Parameter.Type.DOUBLE
        assert node.get_parameter(name).value == float(text)
    assert load(file, "example", Example).noise == float(text)


def test_realtime_parameters_and_autostart_are_read_only(start):
    node = start()
    for name, value in (("realtime.priority", 50), ("autostart", False)):
        assert node.describe_parameter(name).read_only
        assert not change(node, name, value).successful


def test_a_dump_is_loaded_by_set_by_file_and_by_the_tools(start, tmp_path):
    node = start("-p", "noise:=1e-05", "-p", "kind:=ramp")
    names = [name for name in node.list_parameters([], 0).names if not name.startswith("qos_overrides.")]
    tree = {}
    for parameter in node.get_parameters(names):
        *groups, last = parameter.name.split(".")
        section = tree
        for one in groups:
            section = section.setdefault(one, {})
        section[last] = list(parameter.value) if hasattr(parameter.value, "typecode") else parameter.value
    file = tmp_path / "dump.yaml"
    file.write_text(yaml.dump({"/vsa/example": {"ros__parameters": tree}}))
    node.trigger_configure()
    node.trigger_activate()
    own = [Parameter(name, value=value) for name, value in tree.items() if name in flatten(node.config)]
    assert len(own) == 6
    assert all(node.set_parameters_atomically([one]).successful for one in own)
    assert not node.applied
    assert load(file, "example", Example) == node.config
    config = node.config
    node.close()
    node.destroy_node()
    rclpy.shutdown()
    assert start("--params-file", str(file)).config == config


def test_a_tunable_parameter_changes_while_active_and_another_one_names_the_recipe(start):
    node = start()
    node.trigger_configure()
    node.trigger_activate()
    assert change(node, "noise", 2).successful
    assert [config.noise for config in node.applied] == [2.0]
    refused = change(node, "gain", 3.0)
    assert not refused.successful
    assert "ros2 lifecycle set /vsa/example deactivate" in refused.reason
    assert node.config.gain == 2.0
    assert change(node, "gain", 2.0).successful
    assert not change(node, "noise", 13.0).successful
    assert node.config.noise == 2.0
    node.trigger_deactivate()
    assert change(node, "gain", 3.0).successful
    assert len(node.applied) == 1


def test_the_description_has_unit_range_and_when_it_changes(start):
    noise, gain = start().describe_parameters(["noise", "gain"])
    assert (noise.description, noise.type) == ("noise [N]", ParameterType.PARAMETER_DOUBLE)
    assert noise.floating_point_range[0].to_value == 100.0
    assert noise.additional_constraints == "changes at any time"
    assert gain.additional_constraints == "changes while the node is not active"


def test_a_foreign_parameter_for_all_nodes_is_ignored_and_one_for_this_node_is_an_error(start, tmp_path):
    file = tmp_path / "rig.yaml"
    file.write_text("/**:\n  ros__parameters: {noise: 3.0, of_another_node: 1}\n")
    node = start("--params-file", str(file))
    assert node.config.noise == 3.0
    assert not node.has_parameter("of_another_node")
    assert load(file, "example", Example).noise == 3.0
    rclpy.shutdown()
    file.write_text("/**:\n  ros__parameters: {nois: 1}\n/**/example:\n  ros__parameters: {nois: 1}\n")
    with pytest.raises(ConfigurationError, match="nois: no such parameter; did you mean noise"):
        start("--params-file", str(file))
    with pytest.raises(ConfigurationError, match="nois: no such parameter; did you mean noise"):
        load(file, "example", Example)
