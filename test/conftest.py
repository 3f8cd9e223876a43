"""Lets all tests import what they share, and judges live ones by trials in which they had their computer.

A live test (`pytest.mark.live`: real processes against the wall clock) that fails while the host of a virtual machine
takes cores away is tried again, everything it stood on made anew. Where the host never stops, nothing was shown: it
is skipped, and the summary says so. A failure on a machine that ran is a failure at once.
"""

import contextlib
import os
import sys
import time
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

sys.path.append(str(Path(__file__).parent / "shared"))

from host import stood

TRIALS = 4
ENOUGH_S = 240.0  # after which no further trial of a test begins
ENOUGH_IN_ALL_S = 1200.0  # for all further trials of a session
LIMIT_S = 600.0  # for all trials of a test
STANDSTILL = 0.02  # of the cores' time: no less in any trial, and nothing is said of the suite

_ANEW = pytest.StashKey[dict]()


def pytest_configure(config):
    config.addinivalue_line("markers", "live: real processes against the wall clock; see test/conftest.py")
    config.stash[_ANEW] = {"seconds": 0.0, "said": []}


def pytest_collection_modifyitems(items):
    for item in items:
        if item.get_closest_marker("live"):
            item.add_marker(pytest.mark.timeout(LIMIT_S))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    if not item.get_closest_marker("live"):
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in _judged(item, nextitem, item.config.stash[_ANEW]):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def pytest_terminal_summary(terminalreporter, config):
    if said := config.stash[_ANEW]["said"]:
        terminalreporter.section("the host took cores away")
        for line in said:
            terminalreporter.line(line)


def _judged(item, nextitem, anew):
    """Reports of the trial that counts."""
    begin, shares = time.monotonic(), []
    while True:
        start, before = time.monotonic(), stood()
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        shares.append((stood() - before) / (os.cpu_count() * (time.monotonic() - start)))
        anew["seconds"] += time.monotonic() - start if len(shares) > 1 else 0.0
        failed = [report for report in reports if report.failed]
        over = time.monotonic() - begin > ENOUGH_S or anew["seconds"] > ENOUGH_IN_ALL_S
        if not failed or not shares[-1] or len(shares) == TRIALS or over:
            break
        with contextlib.suppress(Exception):  # of a stack that failed already
            item.session._setupstate.teardown_exact(None)
    standstill = ", ".join(f"{share:.1%}" for share in shares)
    if failed and min(shares) > STANDSTILL:
        reason = f"nothing shown: cores stood still for {standstill} of each trial's time"
        for report in failed:
            last = str(report.longrepr).rstrip().rpartition("\n")[2]
            anew["said"].append(f"{item.nodeid}: {reason}; last: {last}")
            report.outcome, report.longrepr = "skipped", (str(item.path), item.location[1], f"Skipped: {reason}")
    elif len(shares) > 1:
        anew["said"].append(f"{item.nodeid}: {len(shares)} trials, cores stood still for {standstill} of their time")
    return reports
