# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""What the tests need beyond pytest, and one line for what is missing. Imports nothing but the standard library."""

import importlib.util
import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Modules whose name differs from that of the distribution.
MODULES = {"python-can": "can", "pyyaml": "yaml", "mcap-ros2-support": "mcap_ros2"}
COMMANDS = {"ruff", "mypy", "types-pyyaml", "pytest-xdist"}  # of ./vsa lint and ./vsa test


def modules(file):
    """Modules of the distributions in a requirements file."""
    lines = (ROOT / "requirements" / file).read_text().lower().splitlines()
    names = [re.match(r"[\w.-]+", line)[0] for line in lines if line and not line.startswith("#")]
    return [MODULES.get(name, name.replace("-", "_")) for name in names if name not in COMMANDS]


def missing(names):
    return [name for name in names if importlib.util.find_spec(name) is None]


def missing_line():
    """What is missing and how to get it; empty if nothing is."""
    packages = missing(path.parent.name for path in sorted(ROOT.glob("src/*/package.xml")))
    if packages:
        return f"the tests need a built workspace: source install/setup.bash; missing: {', '.join(packages)}"
    libraries = missing([*modules("suite.txt"), *modules("test.txt")])
    if libraries:
        files = " ".join(f"-r {ROOT / 'requirements' / name}.txt" for name in ("suite", "test"))
        return f"the tests need {', '.join(libraries)}: {sys.executable} -m pip install {files}"
    return ""
