# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters that the arguments of a launch file set, and their precedence in rcl."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from vsa_bringup.arguments import arguments, options
from vsa_bringup.overrides import bus_channel, overrides, write_parameters

DEFAULTS = {one.name: one.default for one in arguments()}
RCL = """
import rclpy, sys
rclpy.init(args=sys.argv)
node = rclpy.create_node("driver", namespace="left", automatically_declare_parameters_from_overrides=True)
print(node.get_parameter("bus.channel").value, node.get_parameter("autostart").value)
"""


def parameters(node="driver", namespace="vsa", simulated=False, **given):
    """Values that the arguments set for a node."""
    found = overrides(options(DEFAULTS | given), namespace, node, simulated)
    return {name: value for values in found.values() for name, value in values.items()}


def config(path, text):
    path.write_text(text)
    return str(path)


def test_defaults_set_nothing():
    assert parameters() == parameters("rig_simulator", simulated=True) == parameters("stiffness_controller") == {}


def test_a_simulated_joint_is_re_excited_unless_the_file_has_the_amplitude(tmp_path):
    assert parameters("stiffness_controller", simulated=True) == {"recovery_amplitude": 5e-4}
    file = config(tmp_path / "a.yaml", "/**/stiffness_controller: {ros__parameters: {recovery_amplitude: 0.0}}")
    assert parameters("stiffness_controller", simulated=True, config=file) == {}


def test_each_argument_sets_its_parameter_in_the_nodes_that_have_it():
    given = {"autostart": "false", "use_sim_time": "true", "bus_channel": "239.1.1.1", "frame_prefix": "arm/"}
    common = {"autostart": False, "use_sim_time": True}
    bus, prefix = {"bus.channel": "239.1.1.1"}, {"frame_prefix": "arm/"}
    assert parameters("driver", **given) == common | bus | prefix
    assert parameters("rig_simulator", **given) == common | bus
    assert parameters("estimator_2", **given) == parameters("joint", **given) == common | prefix
    assert parameters("stiffness_controller", **given) == common


@pytest.mark.parametrize(
    ("configured", "interface", "options_set"),
    [
        ("udp_multicast", "socketcan", [""]),
        ("socketcan", "socketcan", None),
        ("socketcan", "udp_multicast", ["hop_limit=0"]),
    ],
)
def test_options_of_another_interface_are_replaced(tmp_path, configured, interface, options_set):
    file = config(tmp_path / "a.yaml", f"/**/driver: {{ros__parameters: {{bus: {{interface: {configured}}}}}}}")
    found = parameters(config=file, bus_interface=interface)
    assert found == {"bus.interface": interface} | ({"bus.options": options_set} if options_set else {})


def test_simulated_joints_in_two_namespaces_share_no_bus():
    channels = {space: parameters(namespace=space, simulated=True)["bus.channel"] for space in ("left", "right", "a/b")}
    assert len({bus_channel("vsa"), *channels.values()}) == 4
    assert all(channel.split(".")[0] == "239" for channel in channels.values())
    for space, channel in channels.items():
        assert parameters("rig_simulator", space, simulated=True)["bus.channel"] == channel
    assert "bus.channel" not in parameters(namespace="left")  # a real rig
    assert "bus.channel" not in parameters(namespace="left", simulated=True, bus_interface="socketcan")
    assert parameters(namespace="left", simulated=True, bus_channel="239.1.1.1")["bus.channel"] == "239.1.1.1"


def test_a_bus_that_the_file_gives_to_one_namespace_remains(tmp_path):
    file = config(tmp_path / "a.yaml", "/left/driver: {ros__parameters: {bus: {channel: 239.2.2.2}}}")
    assert "bus.channel" not in parameters(namespace="left", simulated=True, config=file)
    assert "bus.channel" in parameters(namespace="right", simulated=True, config=file)


def test_frames_of_another_namespace_have_a_prefix(tmp_path):
    assert parameters("joint", "left") == {"frame_prefix": "left/"}
    assert parameters("joint", "left", frame_prefix="none") == {"frame_prefix": ""}
    file = config(tmp_path / "a.yaml", "/left/driver: {ros__parameters: {frame_prefix: arm/}}")
    assert parameters("estimator_1", "left", config=file) == {"frame_prefix": "arm/"}


def test_the_joint_node_has_the_name_of_its_driver(tmp_path):
    text = "/**/driver: {ros__parameters: {joint: {name: elbow}}}\n"
    assert parameters("joint", config=config(tmp_path / "a.yaml", text)) == {"joint_name": "elbow"}
    both = text + "/**/joint: {ros__parameters: {joint_name: elbow}}\n"
    assert parameters("joint", config=config(tmp_path / "b.yaml", both)) == {}


@pytest.mark.parametrize("keys", [["/**"], ["/**/driver"], ["/left/driver"], ["/left/driver", "/**/driver", "/**"]])
def test_arguments_have_precedence_over_every_section_of_the_file(tmp_path, keys):
    section = "{ros__parameters: {autostart: true, bus: {channel: file}}}\n"
    file = config(tmp_path / "a.yaml", "".join(f"{key}: {section}" for key in keys))
    given = DEFAULTS | {"config": file, "bus_channel": "argument", "autostart": "false"}
    written = write_parameters(overrides(options(given), "left", "driver", False))
    assert all("ros__parameters" in section for section in yaml.safe_load(Path(written).read_text()).values())
    command = [sys.executable, "-c", RCL, "--ros-args", "--params-file", file, "--params-file", written]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["argument", "False"]
