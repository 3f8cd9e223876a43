"""The documents are whole: every parameter has its measurement, every link leads somewhere."""

import importlib
import re
from pathlib import Path

import pytest
from vsa_common.config.configuration import parameters
from vsa_tools.reference_tables import NODES

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
SECTIONS = {
    "every_node": "Every node",
    "driver": "Driver",
    "estimator": "Estimator",
    "joint": "Joint",
    "stiffness_controller": "Stiffness controller",
    "recorder": "Recorder",
    "rig_simulator": "Simulated rig",
}


def named_in(section):
    """Every name that stands in backticks in a section of docs/reference/parameters.md."""
    text = (ROOT / "docs" / "reference" / "parameters.md").read_text()
    body = text.split(f"\n## {section}\n")[1].split("\n## ")[0]
    return set(re.findall(r"`([^`]+)`", body))


@pytest.mark.parametrize("node", NODES)
def test_every_parameter_has_the_measurement_that_it_comes_from(node):
    module, _, name = NODES[node].rpartition(".")
    wanted = {parameter.name for parameter in parameters(getattr(importlib.import_module(module), name))}
    general = {re.sub(r"^transmission_[12]\.", "transmission_N.", name) for name in wanted}
    assert general - named_in(SECTIONS[node]) == set()


@pytest.mark.parametrize("node", NODES)
def test_no_parameter_is_explained_that_no_longer_exists(node):
    known = set()
    for config in NODES.values():
        module, _, name = config.rpartition(".")
        for parameter in parameters(getattr(importlib.import_module(module), name)):
            known |= {parameter.name, re.sub(r"^transmission_[12]\.", "transmission_N.", parameter.name)}
    text = (ROOT / "docs" / "reference" / "parameters.md").read_text()
    body = text.split(f"\n## {SECTIONS[node]}\n")[1].split("\n## ")[0]
    rows = [row.split("|")[1] for row in body.splitlines() if row.startswith("| `")]
    assert rows
    assert {name for row in rows for name in re.findall(r"`([^`]+)`", row)} <= known


def anchors(path):
    heads = re.findall(r"^#+ (.*)$", path.read_text(), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_link_leads_somewhere(document):
    for target in re.findall(r"\]\(([^)\s]+)\)", document.read_text()):
        if re.match(r"\w+://", target):
            continue
        file, _, anchor = target.partition("#")
        path = (document.parent / file).resolve() if file else document
        assert path.exists(), target
        if anchor:
            assert anchor in anchors(path), target


def test_the_index_names_every_benchmark():
    index = (ROOT / "docs" / "benchmarks" / "index.md").read_text()
    for document in sorted((ROOT / "docs" / "benchmarks").glob("[!i]*.md")):
        assert f"({document.name})" in index
