# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""House rules on imports: doors to libraries, layers of packages, permitted imports of folders, no cycles.

The docstring of a folder's `__init__.py` has the line `Permitted imports: a, b.c, d`; it ends at an empty line. A name
a.b permits a.b.c. The folder itself and the standard library are always permitted.
"""

import ast
import re
import sys
from collections import defaultdict
from graphlib import CycleError, TopologicalSorter

import pytest
from source_tree import PACKAGES, SOURCES, covers, dotted, folders, imports, modules, package_root

DOORS = (
    "can", "cantools", "filterpy", "numba", "polars", "matplotlib", "rosbags", "mcap", "aiohttp", "launch",
    "launch_ros", "xacro",
)  # fmt: skip
DOOR_FOLDERS = ("vsa_common.io.bags",)  # a door of several modules
LAYERS = {
    "vsa_common": set(),
    "vsa_driver": {"vsa_common", "vsa_msgs"},
    "vsa_simulator": {"vsa_common", "vsa_driver", "vsa_msgs"},
    "vsa_estimator": {"vsa_common", "vsa_msgs"},
    "vsa_joint": {"vsa_common", "vsa_msgs"},
    "vsa_bringup": {"vsa_common", "vsa_msgs", "vsa_driver", "vsa_estimator", "vsa_joint"},
    "vsa_tools": {"vsa_common", "vsa_msgs", "vsa_estimator", "vsa_joint", "vsa_bringup", "vsa_simulator"},
    "vsa_bench": {*PACKAGES, "vsa_msgs"},
}
ON_THE_SIMULATOR = ("vsa_tools.demo", "vsa_tools.scenarios", "vsa_tools.evaluation")  # within vsa_tools
FOLDERS = [folder for package in PACKAGES for folder in folders(package)]


def door(file):
    """The module, or the folder where that is a door as a whole."""
    folder = dotted(file.parent)
    return folder if folder in DOOR_FOLDERS else dotted(file)


def permitted_imports(folder):
    """Names after `Permitted imports:`; None without that line."""
    docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text())) or ""
    line = re.search(r"^Permitted imports:(.*?)(?:\n\n|\Z)", docstring, re.MULTILINE | re.DOTALL)
    return line and {name.strip().rstrip(".") for name in line[1].split(",") if name.strip()}


def is_standard(name):
    return name.partition(".")[0] in sys.stdlib_module_names


@pytest.mark.parametrize("library", DOORS)
def test_a_library_is_imported_by_one_module(library):
    files = [file for package in PACKAGES for file in modules(package)]
    assert len({door(file) for file in files if any(covers(library, name) for name in imports(file))}) <= 1


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_imports_only_packages_of_lower_layers(package):
    for file in modules(package):
        used = {name.partition(".")[0] for name in imports(file) if name.startswith("vsa_")}
        assert used <= LAYERS[package] | {package}, dotted(file)
        if package == "vsa_tools" and "vsa_simulator" in used:
            assert any(covers(name, dotted(file)) for name in ON_THE_SIMULATOR), dotted(file)


@pytest.mark.parametrize("folder", FOLDERS, ids=dotted)
def test_a_folder_imports_only_what_its_docstring_permits(folder):
    permitted = permitted_imports(folder)
    assert permitted is not None, f"{folder.relative_to(SOURCES)}/__init__.py: no line 'Permitted imports: ...'"
    permitted |= {dotted(folder)}
    for file in folder.glob("*.py"):
        names = {name for name in imports(file) if not is_standard(name)}
        assert not [name for name in names if not any(covers(one, name) for one in permitted)], dotted(file)


@pytest.mark.parametrize("folder", FOLDERS, ids=dotted)
def test_every_permitted_import_of_a_folder_is_used(folder):
    used = {name for file in folder.glob("*.py") for name in imports(file)}
    unused = [one for one in permitted_imports(folder) or () if not any(covers(one, name) for name in used)]
    assert unused == []


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_of_a_package_have_no_import_cycle(package):
    """Modules directly in the package count one by one: settings below the folders, the node above them."""
    root = package_root(package)
    single = {dotted(file) for file in root.glob("*.py") if file.name != "__init__.py"}
    names = single | {dotted(folder) for folder in folders(package) if folder != root}
    graph = defaultdict(set)
    for file in modules(package):
        own = dotted(file if file.parent == root else file.parent)
        for name in imports(file):
            while name not in names and name:
                name = name.rpartition(".")[0]
            if name and name != own:
                graph[own].add(name)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))
