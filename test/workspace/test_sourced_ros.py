# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa setup` with a sourced ROS 2 Jazzy, on an emulated machine.

What is built runs with the system's rclpy and numpy and the environment's other libraries.
"""

import shutil

import pytest
from emulated_machine import NUMPY

pytestmark = pytest.mark.timeout(900)  # the machine is made once, within one of them

PACKAGES = ("numpy", "rclpy", "vsa_msgs", "cantools")
ORIGIN = "import importlib; print(*[importlib.import_module(name).__file__ for name in {}], sep='\\n')"


def scripts(machine):
    return sorted((machine.clone / "install").glob("vsa_*/lib/vsa_*/*"))


def test_the_system_lacks_the_libraries_of_the_suite(machine):
    assert machine.run("python3", "-c", "import rclpy, numpy; print(numpy.__version__)").stdout.strip() == NUMPY
    for name in ("cantools", "numba", "rosbags"):
        assert "ModuleNotFoundError" in machine.run("python3", "-c", f"import {name}").stdout


def test_every_executable_runs_with_the_python_of_the_environment(ready):
    assert len(scripts(ready)) > 10
    assert {script.read_text().splitlines()[0] for script in scripts(ready)} == {f"#!{ready.venv}/bin/python"}


def test_the_environment_has_the_numpy_and_the_rclpy_of_the_system(ready):
    command = f'eval "$(./vsa env)"; python -c "{ORIGIN.format(PACKAGES)}"'
    numpy, rclpy, messages, cantools = ready.run("bash", "-c", command).stdout.splitlines()
    assert numpy.startswith(str(ready.ros))
    assert rclpy.startswith(str(ready.ros))
    assert messages.startswith(str(ready.clone / "install"))
    assert not cantools.startswith(str(ready.ros))


def test_a_second_setup_does_nothing(ready):
    assert ready.run("./vsa", "setup").stdout == "vsa: ready\n"


@pytest.mark.live
def test_the_demo_runs(ready, tmp_path):
    command = ["./vsa", "demo", "--duration", "5", "--rate", "100", "--seed", "1", "--out", tmp_path / "demo"]
    result = ready.run(*command)
    assert result.returncode == 0, result.stdout
    assert (tmp_path / "demo" / "summary.json").exists()


def test_without_the_sourced_ros_the_reason_is_one_line(ready):
    result = ready.run("./vsa", "setup", AMENT_PREFIX_PATH="")
    assert result.returncode == 1
    expected = f"vsa: {ready.venv} was made with the ROS 2 Jazzy of {ready.ros}: source {ready.ros}/setup.bash first"
    assert result.stdout.startswith(expected)
    assert result.stdout.count("\n") == 1


def test_an_interpreter_without_rclpy_is_refused_in_one_line(machine, tmp_path):
    clone = tmp_path / "vsa"
    shutil.copytree(machine.clone, clone, ignore=shutil.ignore_patterns(".venv", "src", "build", "install", "log"))
    result = machine.run("./vsa", "setup", cwd=clone, PYTHONPATH="")
    assert result.returncode == 1
    assert "cannot import rclpy" in result.stdout
    assert result.stdout.count("\n") == 1
    assert not (clone / ".venv").exists()
