# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The line for what the tests lack, and the end of the session with it."""

from pathlib import Path

import prerequisites
import pytest

pytest_plugins = ["pytester"]


def test_nothing_is_missing_here():
    assert prerequisites.missing_line() == ""


def test_modules_of_a_requirements_file_have_the_names_of_their_imports():
    assert {"can", "yaml", "numpy", "cantools"} <= set(prerequisites.modules("suite.txt"))
    assert {"pytest_timeout", "mcap_ros2"} <= set(prerequisites.modules("test.txt"))
    assert not {"ruff", "mypy"} & set(prerequisites.modules("test.txt"))


def test_a_missing_library_is_named_with_the_command_that_installs_it(monkeypatch):
    monkeypatch.setattr(prerequisites, "missing", lambda names: [name for name in names if name == "selenium"])
    line = prerequisites.missing_line()
    assert line.startswith("the tests need selenium: ")
    assert "-m pip install -r" in line
    assert "\n" not in line


def test_a_workspace_that_is_not_sourced_is_named(monkeypatch):
    monkeypatch.setattr(prerequisites, "missing", lambda names: [name for name in names if name == "vsa_msgs"])
    assert "source install/setup.bash; missing: vsa_msgs" in prerequisites.missing_line()


def test_the_session_ends_with_the_line(pytester):
    shared = pytester.mkdir("shared")
    (shared / "prerequisites.py").write_text("def missing_line():\n    return 'the tests need a library'\n")
    pytester.makeconftest(Path(__file__).with_name("conftest.py").read_text())
    pytester.makepyfile("def test_one():\n    pass\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert result.errlines == ["vsa: the tests need a library"]
