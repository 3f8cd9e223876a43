# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""package.xml of each package: its dependencies are the imports of its source and its tests, and keys of rosdep.

A library without a rosdep key is a `pip_depend` of the export section; requirements/suite.txt installs it.
"""

import ast
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import prerequisites
import pytest
from source_tree import PACKAGES, ROOT, SOURCES, imports, modules, package_root

MANIFESTS = sorted(SOURCES.glob("*/package.xml"))
KNOWN = {
    line.split()[0]
    for line in (Path(__file__).parent / "rosdep_keys.txt").read_text().splitlines()
    if line and not line.startswith("#")
}
# Needed at runtime, but neither imported nor named in the source.
INDIRECT = {
    "vsa_driver": {"python3-msgpack"},  # by the interface udp_multicast of python-can
    "vsa_bringup": {"ros2launch"},  # by `ros2 launch`
}
TEST_TOOLS = {"python3-pytest", "python3-pytest-timeout"}  # by test/conftest.py
# Of requirements/test.txt, without a key.
TEST_LIBRARIES = {"allantools", "mcap", "mcap_ros2", "threadpoolctl"}


def manifest(package):
    return ElementTree.parse(SOURCES / package / "package.xml").getroot()


def depends(package, *tags):
    return {element.text for tag in tags for element in manifest(package).iter(tag)}


def third_party(files):
    """Top-level modules that files import, without the standard library and modules beside them."""
    names = {name.partition(".")[0] for file in files for name in imports(file)}
    own = {file.stem for file in (ROOT / "test").rglob("*.py")} | {"_pytest"}
    return names - set(sys.stdlib_module_names) - own


def key(module):
    """The dependency that provides a module: a ROS package, or a rosdep key; the module itself without either."""
    if module in KNOWN or module.startswith("vsa_"):
        return module
    found = [name for name in (f"python3-{module}", f"python3-{module}-pip") if name in KNOWN]
    return found[0] if found else module


def strings(files):
    trees = [ast.parse(file.read_text()) for file in files]
    return {str(node.value) for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant)}


def source_files(package):
    launch_files = [] if package == "vsa_msgs" else list((package_root(package).parent / "launch").glob("*.py"))
    return [*modules(package), *launch_files]


def files_of_tests(package):
    folders = [ROOT / "test" / package, *([ROOT / "test" / "system"] if package == "vsa_bringup" else [])]
    return [file for folder in folders for file in folder.rglob("*.py")]


@pytest.mark.parametrize("package", PACKAGES)
def test_every_import_has_a_dependency(package):
    needed = {key(name) for name in third_party(source_files(package)) - {package}}
    assert needed - depends(package, "depend", "exec_depend", "pip_depend") == set()


@pytest.mark.parametrize("package", PACKAGES)
def test_every_dependency_is_used(package):
    files = source_files(package)
    used = {key(name) for name in third_party(files)} | strings(files) | INDIRECT.get(package, set())
    assert depends(package, "depend", "exec_depend", "pip_depend") - used == set()


@pytest.mark.parametrize("package", PACKAGES)
def test_the_test_dependencies_are_the_imports_of_the_tests(package):
    """Other packages of the suite are none: their dependencies on this one would be circular."""
    imported = {key(name) for name in third_party(files_of_tests(package)) if not name.startswith("vsa_")}
    needed = (imported | TEST_TOOLS) - depends(package, "depend", "exec_depend", "pip_depend")
    assert needed & TEST_LIBRARIES <= set(prerequisites.modules("test.txt")) | set(prerequisites.modules("suite.txt"))
    assert depends(package, "test_depend") == needed - TEST_LIBRARIES


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda path: path.parent.name)
def test_every_dependency_is_a_key_of_rosdep(path):
    tags = ("depend", "exec_depend", "test_depend", "buildtool_depend", "build_depend")
    names = {name for name in depends(path.parent.name, *tags) if not (SOURCES / name).exists()}
    assert names <= KNOWN


@pytest.mark.parametrize("package", PACKAGES)
def test_a_library_for_pip_has_no_rosdep_key_and_a_pinned_version(package):
    for name in depends(package, "pip_depend"):
        assert not {f"python3-{name}", f"python3-{name}-pip"} & KNOWN
        assert re.search(rf"^{name}==", (ROOT / "requirements" / "suite.txt").read_text(), re.MULTILINE)


def test_every_library_of_the_suite_is_a_dependency_of_a_package():
    needed = {key(name) for name in prerequisites.modules("suite.txt") if name != "setuptools"}
    assert needed == {
        name
        for package in PACKAGES
        for name in depends(package, "exec_depend", "pip_depend")
        if name.startswith("python3-") or name in depends(package, "pip_depend")
    }


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda path: path.parent.name)
def test_metadata_is_complete_and_the_same_in_all_packages(path):
    root, first = manifest(path.parent.name), ElementTree.parse(MANIFESTS[0]).getroot()
    assert {url.get("type") for url in root.iter("url")} == {"website", "repository", "bugtracker"}
    for tag in ("url", "author", "maintainer"):
        assert [(e.text, e.attrib) for e in root.iter(tag)] == [(e.text, e.attrib) for e in first.iter(tag)]
    assert root.findtext("license") == "Apache-2.0"


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda path: path.parent.name)
def test_the_readme_of_a_package_lists_its_executables(path):
    readme = (path.parent / "README.md").read_text()
    setup = path.parent / "setup.py"
    entry_points = re.findall(r'"(\w+) = [\w.]+:main"', setup.read_text()) if setup.exists() else []
    assert sorted(re.findall(r"^\| `(\w+)` \|", readme, re.MULTILINE)) == sorted(entry_points)
    assert "QUALITY_DECLARATION.md" in readme


def test_the_licences_of_files_of_others_are_listed():
    licences = [path.relative_to(ROOT) for path in SOURCES.rglob("*LICENSE*")]
    notice = (ROOT / "NOTICE").read_text()
    assert licences
    assert all(str(path) in notice for path in licences)
    assert [element.text for element in manifest("vsa_tools").iter("license")] == ["Apache-2.0", "MIT"]
