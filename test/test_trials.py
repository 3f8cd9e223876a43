# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Repetition of live tests by test/conftest.py, by the time for which the host suspended the cores."""

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

LIVE = """
import pytest
pytestmark = pytest.mark.live
made = []

@pytest.fixture(scope="module")
def stack():
    made.append(1)
    return len(made)

def test_first(stack):
    assert stack in {fine}

def test_second(stack):
    assert stack >= 1
"""


@pytest.mark.parametrize(
    ("suspended", "fine", "passed", "failed", "skipped"),
    [
        ("0.0", "(2,)", 1, 1, 0),  # no suspension: no second trial
        ("1e-4 * calls", "(2,)", 2, 0, 0),  # second trial with new fixtures passes
        ("1e-9 * calls", "()", 1, 1, 0),  # suspension below the limit
        ("1e3 * calls", "()", 1, 0, 1),  # suspension in every trial
    ],
)
def test_a_failure_counts_unless_the_cores_were_suspended(pytester, suspended, fine, passed, failed, skipped):
    shared = pytester.mkdir("shared")
    (shared / "host.py").write_text(
        f"calls = 0\ndef suspended_time():\n    global calls\n    calls += 1\n    return {suspended}\n"
    )
    (shared / "prerequisites.py").write_text("def missing_line():\n    return ''\n")
    pytester.makeconftest(Path(__file__).with_name("conftest.py").read_text())
    pytester.makepyfile(LIVE.replace("{fine}", fine))
    pytester.makeini("[pytest]\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=passed, failed=failed, skipped=skipped)
    assert ("inconclusive" in result.stdout.str()) == bool(skipped)
    assert ("2 trials" in result.stdout.str()) == (fine == "(2,)" and suspended != "0.0")
