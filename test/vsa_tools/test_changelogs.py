# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""CHANGELOG.rst of the packages."""

from pathlib import Path

import pytest
from vsa_tools.changelogs import changelog

ROOT = Path(__file__).parents[2]
TEXT = """# Changelog

## 0.3.0 (unreleased)

- In work.

## 0.2.0 (2026-05-01)

- A line of
  two lines with `code`.
- Another.

## 0.1.0

- First.
"""


def test_released_versions_are_written_in_the_format_of_catkin():
    assert changelog("vsa_joint", TEXT) == (
        "^" * 31 + "\nChangelog for package vsa_joint\n" + "^" * 31 + "\n\n"
        "0.2.0 (2026-05-01)\n------------------\n* A line of two lines with ``code``.\n* Another.\n\n"
        "0.1.0\n-----\n* First.\n"
    )


@pytest.mark.parametrize("package", sorted(path.parent.name for path in ROOT.glob("src/*/package.xml")))
def test_every_package_has_the_released_versions(package):
    """Renewed by `python -m vsa_tools.changelogs .`."""
    expected = changelog(package, (ROOT / "CHANGELOG.md").read_text())
    assert (ROOT / "src" / package / "CHANGELOG.rst").read_text() == expected
