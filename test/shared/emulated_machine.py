# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A machine with ROS 2 Jazzy, emulated by links to the wheels of this environment.

Its prefix stands for /opt/ros/jazzy: rclpy, messages, build tools, colcon, numpy 1.26, and none of
requirements/suite.txt. `environment` is what its setup.bash exports. It has neither ros2cli nor launch nor apt.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from importlib.metadata import distributions
from pathlib import Path

ROOT = Path(__file__).parents[2]
PREFIX = Path(sys.prefix)
PACKAGES = Path(sysconfig.get_path("purelib"))
BASE_PYTHON = Path(sys._base_executable)  # of the system, without this environment's packages
SITE = PACKAGES.relative_to(PREFIX)
HAS_WHEELS = (PREFIX / "share" / "ament_index" / "resource_index" / "packages" / "rclpy").exists()
NUMPY = "1.26.4"  # of Ubuntu 24.04
COPIED = ("vsa", "colcon.meta", "requirements", "src", "test", "pyproject.toml", "README.md", "CHANGELOG.md")
SCRIPTS = {"colcon": "colcon_core.command:main", "cmake": "cmake:cmake", "ctest": "cmake:ctest", "ninja": "ninja:ninja"}


def normalized(name):
    return re.sub(r"[-_.]+", "-", name).lower()


INSTALLED = {normalized(one.metadata["Name"]): one for one in reversed(list(distributions(path=[str(PACKAGES)])))}


def closure(file):
    """Distributions that a requirements file needs, with their own requirements."""
    lines = (ROOT / "requirements" / file).read_text().splitlines()
    waiting = [line for line in lines if line and not line.startswith("#")]
    found = set()
    while waiting:
        match = re.match(r"([\w.-]+)(?:\[([\w-]+)\])?", waiting.pop())
        name = normalized(match[1])
        if name in INSTALLED and name not in found:
            found.add(name)
            extra = f'extra == "{match[2]}"'
            needed = INSTALLED[name].requires or []
            waiting += [one for one in needed if "extra ==" not in one or extra in one.replace("'", '"')]
    return found


def link(names, folder):
    """Links to everything that distributions have in the folder of packages."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        for entry in {file.parts[0] for file in INSTALLED[name].files or ()} - {"..", "__pycache__"}:
            if not entry.endswith(".pth") and not (folder / entry).exists():
                (folder / entry).symlink_to(PACKAGES / entry)


@dataclass(frozen=True)
class Machine:
    """Folders of an emulated machine."""

    ros: Path  # stands for /opt/ros/jazzy
    clone: Path  # copy of this tree
    venv: Path  # the clone's, with pip and the libraries of suite.txt, which else would have to be downloaded

    def environment(self, **variables):
        """Variables after `source /opt/ros/jazzy/setup.bash`."""
        libraries = [self.ros / "lib", *(self.ros / SITE).glob("ros_*.libs")]
        kept = {name: os.environ[name] for name in ("HOME", "LANG", "TMPDIR") if name in os.environ}
        return kept | {
            "PATH": f"{self.ros / 'bin'}:{BASE_PYTHON.parent}:/usr/local/bin:/usr/bin:/bin",
            "ROS_DISTRO": "jazzy",
            "ROS_VERSION": "2",
            "ROS_PYTHON_VERSION": "3",
            "AMENT_PREFIX_PATH": str(self.ros),
            "CMAKE_PREFIX_PATH": str(self.ros),
            "PYTHONPATH": str(self.ros / SITE),
            "LD_LIBRARY_PATH": ":".join(map(str, libraries)),
            "CFLAGS": "-O0",  # for the time of the build
            "CXXFLAGS": "-O0",
            **variables,
        }

    def run(self, *command, cwd=None, limit=800.0, **variables):
        """Run a command; its result with output and errors in `stdout`."""
        return subprocess.run(
            list(map(str, command)),
            cwd=cwd or self.clone,
            env=self.environment(**variables),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=limit,
            check=False,
        )


def machine_in(folder):
    """The machine that `build` makes in a folder."""
    return Machine(folder / "ros", folder / "vsa", folder / "vsa" / ".venv")


def build(folder):
    """Make an emulated machine in an empty folder. Raises CalledProcessError where numpy cannot be downloaded."""
    machine = machine_in(folder)
    ros = closure("ros.txt")
    link(ros - {"numpy"}, machine.ros / SITE)
    _link_prefix(machine.ros)
    _write_scripts(machine.ros / "bin")
    numpy = ["install", "--quiet", "--no-compile", "--no-deps", "--target", machine.ros / SITE, f"numpy=={NUMPY}"]
    subprocess.run([sys.executable, "-m", "pip", *numpy], check=True, capture_output=True)
    machine.clone.mkdir()
    for name in COPIED:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
            shutil.copytree(ROOT / name, machine.clone / name, ignore=ignored)
        elif (ROOT / name).exists():
            shutil.copy2(ROOT / name, machine.clone / name)
    subprocess.run([BASE_PYTHON, "-m", "venv", "--system-site-packages", machine.venv], check=True)
    link(closure("suite.txt") - ros - {"numpy"}, folder / "suite")
    (machine.venv / SITE / "suite.pth").write_text(f"{folder / 'suite'}\n")


def _link_prefix(prefix):
    for part in ("share", "include", "tools"):
        (prefix / part).symlink_to(PREFIX / part)
    for path in (PREFIX / "lib").iterdir():
        if path != PACKAGES.parent:
            (prefix / "lib" / path.name).symlink_to(path)


def _write_scripts(folder):
    folder.mkdir()
    for name, entry in SCRIPTS.items():
        module, function = entry.split(":")
        (folder / name).write_text(
            f"#!{BASE_PYTHON}\nfrom {module} import {function}\nraise SystemExit({function}())\n"
        )
        (folder / name).chmod(0o755)
    (folder / "python3").symlink_to(BASE_PYTHON)
