"""What test/conftest.py makes of a live test that fails, by how long the cores stood still meanwhile."""

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
    ("still", "fine", "passed", "failed", "skipped"),
    [
        ("0.0", "(2,)", 1, 1, 0),  # a machine that ran: no second trial
        ("1e-4 * asked", "(2,)", 2, 0, 0),  # made anew, and good
        ("1e-9 * asked", "()", 1, 1, 0),  # hardly anything was taken away
        ("1e3 * asked", "()", 1, 0, 1),  # nothing but standstill
    ],
)
def test_a_failure_counts_where_the_cores_ran(pytester, still, fine, passed, failed, skipped):
    shared = pytester.mkdir("shared")
    (shared / "host.py").write_text(f"asked = 0\ndef stood():\n    global asked\n    asked += 1\n    return {still}\n")
    pytester.makeconftest(Path(__file__).with_name("conftest.py").read_text())
    pytester.makepyfile(LIVE.replace("{fine}", fine))
    pytester.makeini("[pytest]\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=passed, failed=failed, skipped=skipped)
    assert ("nothing shown" in result.stdout.str()) == bool(skipped)
    assert ("2 trials" in result.stdout.str()) == (fine == "(2,)" and still != "0.0")
