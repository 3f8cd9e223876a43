# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""CHANGELOG.rst of each package, in catkin's format, from the released versions of CHANGELOG.md.

`python -m vsa_tools.changelogs CLONE` writes them. The packages are released together and have the same entries.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

_VERSION = re.compile(r"^## (\d+\.\d+\.\d+)(?: \((\d{4}-\d{2}-\d{2})\))?$")  # a version in work has another suffix


def releases(text: str) -> Iterator[tuple[str, list[str]]]:
    """Heading (version, date if known) and entries of each released version in a CHANGELOG.md, the newest first."""
    for section in re.split(r"^(?=## )", text, flags=re.MULTILINE):
        head, _, body = section.partition("\n")
        if version := _VERSION.match(head):
            entries = [" ".join(entry.split()) for entry in re.split(r"^- ", body, flags=re.MULTILINE)[1:]]
            yield version[1] + (f" ({version[2]})" if version[2] else ""), entries


def changelog(package: str, text: str) -> str:
    """CHANGELOG.rst of a package from the text of CHANGELOG.md."""
    title = f"Changelog for package {package}"
    line = "^" * len(title)
    parts = [f"{line}\n{title}\n{line}\n"]
    for heading, entries in releases(text):
        items = "".join(f"* {entry.replace('`', '``')}\n" for entry in entries)
        parts.append(f"{heading}\n{'-' * len(heading)}\n{items}")
    return "\n".join(parts)


def write(clone: Path) -> None:
    """Write CHANGELOG.rst of every package of a clone."""
    text = (clone / "CHANGELOG.md").read_text()
    for manifest in sorted(clone.glob("src/*/package.xml")):
        manifest.with_name("CHANGELOG.rst").write_text(changelog(manifest.parent.name, text))


if __name__ == "__main__":
    write(Path(sys.argv[1]))
