# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""docs/reference has the tables that the code generates."""

from pathlib import Path

import pytest
from vsa_common.types import ResetReason, Status
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance
from vsa_tools.reference_tables import document

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs" / "reference" / "interfaces.md"
MESSAGES = ROOT / "src" / "vsa_msgs" / "msg"


@pytest.mark.parametrize("file", [DOCUMENT, DOCUMENT.with_name("launch.md")], ids=lambda file: file.name)
def test_generated_tables_equal_those_of_the_code(file):
    assert document(file.read_text(), MESSAGES) == file.read_text(), (
        f"renew: python -m vsa_tools.reference_tables docs/reference/{file.name}"
    )
    assert "<!-- end -->" in file.read_text()


@pytest.mark.parametrize("file", sorted(MESSAGES.glob("*.msg")), ids=lambda file: file.stem)
def test_every_message_is_documented_and_every_number_has_a_unit(file):
    assert f"### {file.stem}" in DOCUMENT.read_text()
    for line in file.read_text().splitlines():
        if line.startswith("float64"):
            is_variance_of_a_field_with_unit = "_variance" in line and "#" not in line
            assert "[" in line.split("#", 1)[-1] or is_variance_of_a_field_with_unit, line


@pytest.mark.parametrize("message", [TransmissionImpedance, EstimatorState, JointImpedance])
@pytest.mark.parametrize(("enum", "prefix"), [(Status, "STATUS_"), (ResetReason, "RESET_")])
def test_every_message_with_a_status_has_its_constants(message, enum, prefix):
    constants = {name: getattr(message, name) for name in dir(message) if name.startswith(prefix)}
    assert constants == {f"{prefix}{one.name}": one.value for one in enum}
