# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`colcon test` runs the tests of the packages, in an ordinary workspace and in the clone, or names what is missing."""

from xml.etree import ElementTree

import pytest
from emulated_machine import SITE, closure, link

pytestmark = pytest.mark.timeout(900)  # the machine is made once, within one of them

PACKAGE = "vsa_simulator"
QUICK = ("test_dynamics.py", "test_motion.py")
# Hook of the plugin launch_testing of ROS 2 Jazzy, with an argument that pytest 9 has removed.
LAUNCH_TESTING = "def pytest_pycollect_makemodule(path, parent):\n    pass\n"


@pytest.fixture
def workspace(ready, tmp_path):
    """An ordinary workspace with a clone under src/."""
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "vsa").symlink_to(ready.clone)
    return tmp_path


def colcon_test(machine, folder, results):
    """Run `colcon test` of one package in a folder with the environment of a user who has sourced the workspace."""
    bases = f"--build-base {results} --install-base {machine.clone / 'install'} --test-result-base {results}"
    command = f"python -m colcon --log-base {results} test --packages-select {PACKAGE} {bases}"
    setup = f'eval "$({machine.clone}/vsa env)"; cd {folder}; {command} --return-code-on-test-failure'
    return machine.run("bash", "-c", setup)


def counts(results):
    suite = next(ElementTree.parse(results / "pytest.xml").iter("testsuite"))
    return int(suite.get("tests")), int(suite.get("failures")) + int(suite.get("errors"))


@pytest.fixture(scope="module")
def with_test_libraries(ready):
    """The machine with requirements/test.txt, by links instead of a download; its clone has a few quick tests."""
    for file in (ready.clone / "test" / PACKAGE).rglob("test_*.py"):
        if file.name not in QUICK:
            file.unlink()
    libraries = ready.ros.parent / "suite"
    link(closure("test.txt") - closure("ros.txt") - closure("suite.txt"), libraries)
    return ready


def test_a_missing_library_is_named_in_one_line(ready, workspace, tmp_path):
    result = colcon_test(ready, workspace, tmp_path / "results")
    assert result.returncode
    lines = [line for line in result.stdout.splitlines() if "vsa: the tests need" in line]
    assert lines
    assert "threadpoolctl" in lines[0]
    assert "INTERNALERROR" not in result.stdout


@pytest.mark.parametrize("place", ["workspace", "clone"])
def test_the_tests_of_a_package_run(with_test_libraries, workspace, tmp_path, place):
    results = tmp_path / "results"
    result = colcon_test(with_test_libraries, workspace if place == "workspace" else with_test_libraries.clone, results)
    assert result.returncode == 0, result.stdout
    tests, failures = counts(results / PACKAGE)
    assert tests > 15
    assert failures == 0


def test_the_plugins_of_launch_testing_are_not_loaded(with_test_libraries, workspace, tmp_path):
    plugin = with_test_libraries.venv / SITE
    (plugin / "launch_testing_hooks.py").write_text(LAUNCH_TESTING)
    information = plugin / "launch_testing-3.4.3.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: launch-testing\nVersion: 3.4.3\n")
    (information / "entry_points.txt").write_text("[pytest11]\nlaunch_testing = launch_testing_hooks\n")
    folder = with_test_libraries.clone / "src" / PACKAGE
    without = with_test_libraries.run("bash", "-c", f'eval "$(./vsa env)"; cd {folder}; python -m pytest -c /dev/null')
    assert "PluginValidationError" in without.stdout
    results = tmp_path / "results"
    assert colcon_test(with_test_libraries, workspace, results).returncode == 0
    assert counts(results / PACKAGE)[0] > 15
