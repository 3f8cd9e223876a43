# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The C++ subscriber of examples/: its text of a message, compiled with the headers of vsa_msgs; its CMakeLists.

rclcpp is not among the wheels: subscribe.cpp itself is compiled where ROS 2 is installed.
"""

import os
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "subscribe_cpp"
MAIN = """
#include <cstdio>
#include "subscribe_cpp/stiffness_text.hpp"
int main() {
  vsa_msgs::msg::JointImpedance joint;
  joint.stiffness = 2.0;
  joint.stiffness_variance = 0.01;
  std::printf("[%s]\\n", subscribe_cpp::stiffness_text(joint).c_str());
  joint.stiffness_valid = true;
  std::printf("[%s]\\n", subscribe_cpp::stiffness_text(joint).c_str());
}
"""


def include_folders():
    """Folders of the C++ headers of all sourced message packages."""
    prefixes = [Path(prefix) for prefix in os.environ["AMENT_PREFIX_PATH"].split(":")]
    return [folder for prefix in prefixes for folder in (prefix / "include").glob("*") if folder.is_dir()]


def test_the_text_of_a_message_has_the_interval_of_a_valid_stiffness(tmp_path):
    (tmp_path / "main.cpp").write_text(MAIN)
    includes = [f"-I{folder}" for folder in (EXAMPLE / "include", *include_folders())]
    program = tmp_path / "main"
    command = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", *includes, tmp_path / "main.cpp", "-o", program]
    subprocess.run(command, check=True)
    output = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    assert output == "[]\n[K = 2.000 +- 0.196 N m/rad]\n"


def test_the_package_is_configured_and_names_the_missing_rclcpp(tmp_path):
    bases = ["--base-paths", EXAMPLE, "--build-base", tmp_path / "build", "--install-base", tmp_path / "install"]
    command = [sys.executable, "-m", "colcon", "--log-base", tmp_path / "log", "build", *bases]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "install" / "subscribe_cpp" / "share" / "subscribe_cpp" / "package.xml").exists()
    if not any((Path(prefix) / "share" / "rclcpp").exists() for prefix in os.environ["AMENT_PREFIX_PATH"].split(":")):
        assert "rclcpp is not installed" in result.stderr
    else:
        assert (tmp_path / "install" / "subscribe_cpp" / "lib" / "subscribe_cpp" / "subscribe").exists()
