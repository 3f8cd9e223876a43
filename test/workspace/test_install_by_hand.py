# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The commands of docs/tutorials/install.md for a workspace with several packages, on the emulated machine.

The block that makes the environment runs as it is printed. The suite's libraries are linked, so pip has nothing to
download, and two packages are built; the messages are those of `./vsa setup`.
"""

import re

import pytest
from emulated_machine import ROOT, SITE

pytestmark = pytest.mark.timeout(900)  # the machine is made once, within one of them

TEXT = (ROOT / "docs" / "tutorials" / "install.md").read_text()
BLOCK = re.search(r"^python3 -m venv --system-site-packages.*?(?=^```)", TEXT, re.MULTILINE | re.DOTALL)[0]


@pytest.fixture(scope="module")
def workspace(ready, tmp_path_factory):
    """A workspace after the block."""
    folder = tmp_path_factory.mktemp("ws")
    (folder / "src").mkdir()
    (folder / "src" / "vsa").symlink_to(ready.clone)
    (folder / "install").mkdir()
    (folder / "install" / "vsa_msgs").symlink_to(ready.clone / "install" / "vsa_msgs")
    assert BLOCK.rstrip().endswith("-m colcon build --symlink-install")
    commands = f"set -e\n{BLOCK.rstrip()} --packages-select vsa_common vsa_driver"
    libraries = f"{ready.ros / SITE}:{ready.ros.parent / 'suite'}"
    result = ready.run("bash", "-c", commands, cwd=folder, PYTHONPATH=libraries, PIP_NO_INDEX="1")
    assert result.returncode == 0, result.stdout
    return folder


def test_the_environment_keeps_the_numpy_of_the_system(workspace):
    assert (workspace / ".venv" / "constraints.txt").read_text() == "numpy==1.26.4\n"
    assert not (workspace / ".venv" / SITE / "numpy").exists()


def test_the_executables_have_the_python_of_the_environment(workspace):
    driver = workspace / "install" / "vsa_driver" / "lib" / "vsa_driver" / "driver"
    assert driver.read_text().splitlines()[0] == f"#!{workspace}/.venv/bin/python"


def test_colcon_ignores_the_environment(workspace):
    built = {path.name for path in (workspace / "build").iterdir() if path.is_dir()}
    assert built == {"vsa_common", "vsa_driver"}


def test_the_libraries_that_rosdep_skips_are_those_of_pip():
    manifests = "".join(path.read_text() for path in ROOT.glob("src/*/package.xml"))
    from_pip = set(re.findall(r"<(?:exec_)?depend>(python3-[\w-]+-pip)<", manifests))
    skipped = re.findall(r'--skip-keys "([^"]*)"', TEXT)
    assert len(skipped) == 2
    assert [set(keys.split()) for keys in skipped] == [from_pip, from_pip]
