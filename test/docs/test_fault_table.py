# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""docs/reference/faults.md is complete: every row lists tests, and every listed test exists."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROWS = [
    [cell.strip() for cell in line.strip("|\n ").split("|")]
    for line in (ROOT / "docs" / "reference" / "faults.md").read_text().partition("\n## ")[0].splitlines()
    if line.startswith("|") and not line.startswith(("|---", "| fault |"))
]
FILES = (file.read_text() for file in (ROOT / "test").rglob("test_*.py"))
TESTS = {name for text in FILES for name in re.findall(r"^def (test_\w+)", text, re.M)}
REQUIRED = (
    "one sensor stops", "driver killed", "NaN or infinity", "single spike", "encoder step", "encoder counter wraps",
    "stuck sensor", "slow drift", "saturation", "time jumps back", "late or reordered", "long gap", "duplicate stamp",
    "zero or future stamp", "wall clock stepped", "use_sim_time", "CAN bus-off", "malformed", "kill -9", "SIGINT",
    "QoS", "late joiner", "parameter abuse", "illegal lifecycle call", "disk full", "CPU starved", "long run",
    "command out of limits", "anything random",
)  # fmt: skip


def test_every_required_fault_has_a_row():
    faults = [fault for fault, _, _ in ROWS]
    assert [words for words in REQUIRED if not any(fault.startswith(words) for fault in faults)] == []


def test_every_row_describes_the_reaction_and_lists_existing_tests():
    for fault, reaction, tests in ROWS:
        assert len(reaction) > 20, fault
        named = re.findall(r"`(\w+)`", tests)
        assert named, fault
        assert [name for name in named if name not in TESTS] == [], fault
