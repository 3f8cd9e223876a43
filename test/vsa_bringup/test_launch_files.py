"""Launch files, checked by their syntax tree: `launch` is absent where ROS was installed from wheels."""

import ast
from pathlib import Path

import pytest
from vsa_common.ros.subprocesses import executable
from vsa_tools.demo.parameters import base_parameters

FOLDER = Path(__file__).parents[2] / "src/vsa_bringup/launch"
FILES = sorted(FOLDER.glob("*.launch.py"))


def nodes(file: Path) -> list[tuple[str, str, str]]:
    """(package, executable, name) of the table NODES and of every Node(...) with literal arguments."""
    found = []
    for item in ast.walk(ast.parse(file.read_text())):
        if isinstance(item, ast.Assign) and getattr(item.targets[0], "id", "") == "NODES":
            found += ast.literal_eval(item.value)
        elif isinstance(item, ast.Call) and getattr(item.func, "id", "") == "Node":
            words = {k.arg: k.value.value for k in item.keywords if isinstance(k.value, ast.Constant)}
            if {"package", "executable"} <= words.keys():
                found.append((words["package"], words["executable"], words.get("name", "driver")))
    return found


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_every_node_of_a_launch_file_exists_and_has_its_parameters(file):
    assert nodes(file)
    for package, name, node in nodes(file):
        assert Path(executable(package, name)).exists()
        assert node in base_parameters()


def test_launch_files_include_only_each_other():
    for file in FILES:
        for item in ast.walk(ast.parse(file.read_text())):
            if isinstance(item, ast.Constant) and str(item.value).endswith(".launch.py") and " " not in str(item.value):
                assert (FOLDER / item.value).exists()
