# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The source tree as the tests of the house rules read it: packages, folders, modules, imports."""

import ast
import functools
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src"
PACKAGES = sorted(path.parent.name for path in SOURCES.glob("*/setup.py"))


def package_root(package):
    return SOURCES / package / package


def modules(package):
    """All Python files of a package."""
    return sorted(path for path in package_root(package).rglob("*.py") if "__pycache__" not in path.parts)


def folders(package):
    """All folders of a package with Python files."""
    return sorted({path.parent for path in modules(package)})


def dotted(path):
    """Name of a module or folder, as Python imports it."""
    parts = path.relative_to(SOURCES).parts[1:]
    name = ".".join(parts).removesuffix(".py")
    return name.removesuffix(".__init__")


@functools.cache
def imports(file):
    """Dotted names that a file imports: `a.b` for `from a.b import c`, `a.b.c` where that is a module of the suite."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                found.add(name if _is_module(name) else node.module)
    return frozenset(found)


@functools.cache
def _is_module(name):
    package = name.partition(".")[0]
    path = SOURCES / package / Path(*name.split("."))
    return path.is_dir() or path.with_suffix(".py").exists()


def covers(permitted, name):
    """Whether a permitted name is this one or contains it."""
    return name == permitted or name.startswith(permitted + ".")
