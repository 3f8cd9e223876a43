# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One version of all packages: that of package.xml, which is the newest one in CHANGELOG.md."""

import re
from xml.etree import ElementTree

import pytest
from source_tree import PACKAGES, ROOT, SOURCES

MANIFESTS = sorted(SOURCES.glob("*/package.xml"))


def version(manifest):
    return ElementTree.parse(manifest).getroot().findtext("version")


@pytest.mark.parametrize("manifest", MANIFESTS, ids=lambda path: path.parent.name)
def test_every_package_has_the_newest_version_of_the_changelog(manifest):
    newest = re.search(r"^## (\d+\.\d+\.\d+)\b", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert newest, "CHANGELOG.md has no heading '## X.Y.Z'"
    assert version(manifest) == newest[1]


@pytest.mark.parametrize("package", PACKAGES)
def test_setup_reads_the_version_from_the_manifest(package):
    assert 'version=package.findtext("version")' in (SOURCES / package / "setup.py").read_text()
