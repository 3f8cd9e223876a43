# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Command line of the nodes: help, refusal of other arguments, parameter files without a section."""

import os
import signal
import subprocess

import pytest
from lifecycle import wait_until_active
from vsa_common.ros.subprocesses import executable

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 70) % 80
ENVIRONMENT = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
NODES = [
    ("vsa_driver", "driver"),
    ("vsa_estimator", "estimator"),
    ("vsa_joint", "joint"),
    ("vsa_joint", "stiffness_controller"),
    ("vsa_simulator", "rig_simulator"),
    ("vsa_bringup", "composed"),
]


def run(package, name, *arguments):
    command = [executable(package, name), *arguments]
    return subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize(("package", "name"), NODES)
def test_help_describes_a_node_and_its_ros_arguments(package, name):
    done = run(package, name, "--help")
    usage, _, text = done.stdout.partition("\n\n")
    assert (done.returncode, done.stderr) == (0, "")
    assert usage == f"usage: {name} [--help] [--ros-args ...]"
    assert len(text.partition("\n")[0]) > 30  # what the node is for
    assert "--params-file FILE" in text


@pytest.mark.parametrize(
    "arguments", [("-p", "silence:=1.0"), ("--params-file", "my_rig.yaml"), ("--verbose",), ("bus",)], ids=" ".join
)
def test_arguments_without_ros_args_are_refused_with_the_usage(arguments):
    done = run("vsa_driver", "driver", *arguments)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "usage: driver [--help] [--ros-args ...]",
        f"driver: error: no such argument: {' '.join(arguments)}; ROS arguments stand after --ros-args",
    ]


@pytest.mark.parametrize("name", ["driver", "composed"])
def test_an_unknown_argument_of_several_joints_is_refused_once(tmp_path, name):
    file = tmp_path / "two.yaml"
    file.write_text("/left/driver: {ros__parameters: {silence: 0.1}}\n/right/driver: {ros__parameters: {silence: 0.1}}")
    package = {"driver": "vsa_driver", "composed": "vsa_bringup"}[name]
    done = run(package, name, "--verbose", "--ros-args", "--params-file", str(file))
    assert (done.returncode, done.stderr.count("usage")) == (2, 1)


@pytest.mark.parametrize(
    ("argument", "reason"),
    [("--parameters", "no such ROS argument: ['--parameters']"), ("-p x", "override rule: '-p x'")],
)
def test_a_ros_argument_that_is_none_is_refused_with_the_usage(argument, reason):
    done = run("vsa_joint", "joint", "--ros-args", *argument.split())
    assert done.returncode == 2
    usage, error = done.stderr.splitlines()
    assert usage == "usage: joint [--help] [--ros-args ...]"
    assert error.endswith(reason)


@pytest.mark.parametrize(("section", "reported"), [("/right/joint", True), ("/vsa/joint", False), ("/**", False)])
def test_a_parameter_file_without_a_section_for_the_node_is_reported(tmp_path, section, reported):
    file = tmp_path / "my_rig.yaml"
    file.write_text(f"{section}: {{ros__parameters: {{autostart: true}}}}\n/**/other: {{ros__parameters: {{a: 1}}}}\n")
    command = [executable("vsa_joint", "joint"), "--ros-args", "--params-file", str(file)]
    process = subprocess.Popen(command, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    try:
        wait_until_active(DOMAIN, "/vsa/joint")
    finally:
        process.send_signal(signal.SIGINT)
        log = process.communicate(timeout=20)[1]
    assert process.returncode == 0
    assert (f"{file}: nothing for /vsa/joint; its parameters have their defaults" in log) is reported
