"""docs/reference/interfaces.md has the tables that the code generates."""

from pathlib import Path

import pytest
from vsa_tools.reference_tables import document

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs" / "reference" / "interfaces.md"
MESSAGES = ROOT / "src" / "vsa_msgs" / "msg"


def test_generated_tables_equal_those_of_the_code():
    assert document(DOCUMENT.read_text(), MESSAGES) == DOCUMENT.read_text(), (
        "renew: python -m vsa_tools.reference_tables docs/reference/interfaces.md"
    )


@pytest.mark.parametrize("file", sorted(MESSAGES.glob("*.msg")), ids=lambda file: file.stem)
def test_every_message_is_documented_and_every_number_has_a_unit(file):
    assert f"### {file.stem}" in DOCUMENT.read_text()
    for line in file.read_text().splitlines():
        if line.startswith("float64"):
            is_variance_of_a_field_with_unit = "_variance" in line and "#" not in line
            assert "[" in line.split("#", 1)[-1] or is_variance_of_a_field_with_unit, line
