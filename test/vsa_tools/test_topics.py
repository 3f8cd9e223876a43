# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The suite's topics are those of docs/reference/interfaces.md."""

import re
from pathlib import Path

from vsa_tools.topics import TRANSMISSIONS, suite_topics

DOCUMENT = Path(__file__).parents[2] / "docs" / "reference" / "interfaces.md"


def test_mode_and_reason_of_the_controller_are_recorded():
    assert suite_topics("/left")["/left/stiffness_controller/status"] == "diagnostic_msgs/msg/DiagnosticStatus"


def test_every_topic_is_documented_with_its_type():
    text = DOCUMENT.read_text()
    for topic, type_name in suite_topics("/").items():
        name = re.sub(f"/({'|'.join(TRANSMISSIONS)})/", "/transmission_N/", topic)
        kind = type_name.replace("/msg/", "/")
        lines = [line for line in text.splitlines() if f"`{name.lstrip('/')}`" in line or f"`{name}`" in line]
        assert any(kind in line or kind.rpartition("/")[2] in line for line in lines), (topic, kind)
