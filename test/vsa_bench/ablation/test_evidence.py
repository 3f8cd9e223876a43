# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Evidence of the tuned constants: what it names exists."""

import re
from pathlib import Path

from vsa_bench.ablation import trial
from vsa_bench.ablation.variation import declared

ROOT = Path(__file__).parents[3]
EVIDENCE = [one.evidence for members in declared(trial.PACKAGE).values() for one in members.values()]


def test_each_test_that_evidence_names_exists():
    sources = "\n".join(path.read_text() for path in (ROOT / "test").rglob("test_*.py"))
    named = {name for evidence in EVIDENCE for name in re.findall(r"\btest_\w+", evidence)}
    assert named
    assert not [name for name in sorted(named) if f"def {name}(" not in sources]


def test_each_document_that_evidence_names_exists():
    named = {name for evidence in EVIDENCE for name in re.findall(r"docs/[\w/-]+\.md", evidence)}
    assert named
    assert not [name for name in sorted(named) if not (ROOT / name).is_file()]
