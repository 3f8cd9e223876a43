"""The house rules that can be read off the imports."""

import ast
from collections import defaultdict
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[1] / "src"
DOORS = (
    "can", "cantools", "filterpy", "numba", "polars", "matplotlib", "allantools", "rosbags", "mcap", "aiohttp",
    "threadpoolctl",
)  # fmt: skip
NOT_FOR_CORES = {"vsa_estimator": "vsa_driver", "vsa_joint": "vsa_driver", "vsa_driver": "vsa_estimator"}


def imports(file: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


def importers() -> dict[str, list[Path]]:
    by_library = defaultdict(list)
    for file in sorted(SOURCES.glob("*/*/**/*.py")):
        for library in imports(file):
            by_library[library].append(file.relative_to(SOURCES))
    return by_library


@pytest.mark.parametrize("library", DOORS)
def test_a_library_comes_in_through_one_door(library):
    assert len(importers()[library]) <= 1


@pytest.mark.parametrize(("package", "stranger"), NOT_FOR_CORES.items())
def test_the_estimators_never_see_the_rig(package, stranger):
    assert not [file for file in importers()[stranger] if file.parts[0] == package]
