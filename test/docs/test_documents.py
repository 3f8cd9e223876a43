# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Documents: a measurement for each parameter, links to existing targets, existing modules."""

import importlib
import re
from pathlib import Path
from pkgutil import resolve_name

import pytest
from vsa_common.config.configuration import parameters
from vsa_tools.reference_tables import NODES

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
CONTRIBUTING = ROOT / "CONTRIBUTING.md"
READMES = [ROOT / "QUALITY_DECLARATION.md", *sorted((ROOT / "src").glob("*/README.md"))]
MODULE = re.compile(r"`(vsa_[a-z]+(?:\.\w+)+)`")  # or an attribute of one
FILE = re.compile(r"`(?:src/vsa_[a-z]+/)?(vsa_[a-z]+(?:/\w+)+(?:\.py)?)/?`")  # or a folder
SECTIONS = {
    "every_node": "Every node",
    "driver": "Driver",
    "estimator": "Estimator",
    "joint": "Joint",
    "stiffness_controller": "Stiffness controller",
    "excitation": "Excitation",
    "recorder": "Recorder",
    "rig_simulator": "Simulated rig",
}


def section(name):
    """Text of a section of docs/reference/parameters.md."""
    text = (ROOT / "docs" / "reference" / "parameters.md").read_text()
    return text.split(f"\n## {name}\n")[1].split("\n## ")[0]


def parameter_names(node):
    """Parameters of a node."""
    module, _, name = NODES[node].rpartition(".")
    return {parameter.name for parameter in parameters(getattr(importlib.import_module(module), name))}


def general(names):
    """Names with `transmission_N` for both transmissions."""
    return {re.sub(r"^transmission_[12]\.", "transmission_N.", name) for name in names}


@pytest.mark.parametrize("node", NODES)
def test_every_parameter_has_its_measurement(node):
    documented = set(re.findall(r"`([^`]+)`", section(SECTIONS[node])))
    assert general(parameter_names(node)) - documented == set()


@pytest.mark.parametrize("node", NODES)
def test_every_documented_parameter_exists(node):
    existing = {name for other in NODES for name in parameter_names(other)}
    rows = [row.split("|")[1] for row in section(SECTIONS[node]).splitlines() if row.startswith("| `")]
    assert rows
    assert {name for row in rows for name in re.findall(r"`([^`]+)`", row)} <= existing | general(existing)


def anchors(path):
    heads = re.findall(r"^#+ (.*)$", path.read_text(), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("document", [*DOCUMENTS, *READMES, CONTRIBUTING], ids=lambda path: str(path.relative_to(ROOT)))
def test_every_link_has_a_target(document):
    for target in re.findall(r"\]\(([^)\s]+)\)", document.read_text()):
        if re.match(r"\w+://", target):
            continue
        file, _, anchor = target.partition("#")
        path = (document.parent / file).resolve() if file else document
        assert path.exists(), target
        if anchor:
            assert anchor in anchors(path), target


def test_the_index_lists_every_benchmark():
    index = (ROOT / "docs" / "benchmarks" / "index.md").read_text()
    for document in sorted((ROOT / "docs" / "benchmarks").glob("[!i]*.md")):
        assert f"({document.name})" in index


@pytest.mark.parametrize(
    "document",
    [path for path in (*DOCUMENTS, CONTRIBUTING) if "decisions" not in path.parts],
    ids=lambda path: path.name,
)
def test_every_module_in_a_document_exists(document):
    text = document.read_text()
    for name in MODULE.findall(text):
        resolve_name(name)  # raises ImportError or AttributeError
    for name in FILE.findall(text):
        assert (ROOT / "src" / name.partition("/")[0] / name).exists(), name


def test_modules_are_found_in_text():
    text = "`vsa_joint.node` `vsa_tools.design.spring.ExponentialSpring.force` `vsa_joint/node.py` `vsa_demo/bag/`"
    assert MODULE.findall(text) == ["vsa_joint.node", "vsa_tools.design.spring.ExponentialSpring.force"]
    assert FILE.findall(text + " `src/vsa_joint/vsa_joint/node.py`")[::2] == ["vsa_joint/node.py", "vsa_joint/node.py"]


def services():
    """(package, name) of every service that the source creates."""
    found = set()
    for file in (ROOT / "src").rglob("*.py"):
        for name in re.findall(r'create_service\(\s*\w+,\s*"~?/?(\w+)"', file.read_text()):
            found.add((file.relative_to(ROOT / "src").parts[0], name))
    return found


def test_the_interfaces_list_every_service():
    text = (ROOT / "docs" / "reference" / "interfaces.md").read_text()
    rows = [
        row.split("|")[1] for row in text.split("\n## Services\n")[1].split("\n## ")[0].splitlines() if row[:3] == "| `"
    ]
    documented = {name.rpartition("/")[2] for row in rows for name in re.findall(r"`([^`]+)`", row)}
    assert len(services()) > 5
    assert {name for _, name in services()} <= documented


def test_the_interfaces_list_every_field_of_every_service():
    text = (ROOT / "docs" / "reference" / "interfaces.md").read_text().split("\n## Services\n")[1].split("\n## ")[0]
    for file in (ROOT / "src" / "vsa_msgs" / "srv").glob("*.srv"):
        fields = re.findall(r"^[a-z][\w/\[\]]* (\w+)", file.read_text(), re.MULTILINE)
        assert fields
        assert all(f"`{name}`" in text for name in [file.stem, *fields])
