# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Makes test/shared importable, distributes files to workers, and repeats live tests while the host suspends the cores.

A live test (`pytest.mark.live`: real processes against the wall clock) that fails while the host of a virtual machine
suspends its cores is repeated with new fixtures. If every trial was disturbed, the result is inconclusive: the test is
skipped, and the summary names it. A failure without suspension is a failure at once.

Where a library is missing, or the workspace is not sourced, the session ends with one line: `colcon test` may run in
any workspace.
"""

import contextlib
import os
import sys
import time
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

sys.path.append(str(Path(__file__).parent / "shared"))

from prerequisites import missing_line

if line := missing_line():
    print(f"vsa: {line}", file=sys.stderr)
    raise SystemExit(pytest.ExitCode.USAGE_ERROR)

from host import suspended_time

ONE_WORKER = "test/workspace/"  # takes longest, begins first
ANY_WORKER = "test/vsa_tools/scenarios/test_injected_faults.py"  # 20 s each without a common fixture
MAX_TRIALS = 4
TEST_S = 240.0  # [s] of a test after which no further trial begins
SESSION_S = 1200.0  # [s] for all further trials of a session
TIMEOUT_S = 600.0  # [s] for all trials of a test
SUSPENDED_SHARE = 0.02  # of the cores' time; if exceeded in every trial, the result is inconclusive

_TRIALS = pytest.StashKey[dict]()


def pytest_configure(config):
    config.addinivalue_line("markers", "live: real processes against the wall clock; see test/conftest.py")
    config.stash[_TRIALS] = {"seconds": 0.0, "lines": []}


def pytest_collection_modifyitems(items):
    for item in items:
        if item.get_closest_marker("live"):
            item.add_marker(pytest.mark.timeout(TIMEOUT_S))
    items.sort(key=lambda item: not item.nodeid.startswith(ONE_WORKER))


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        """A file per worker, one worker for the files that share an emulated machine, and any for some tests."""

        def _split_scope(self, nodeid):
            if nodeid.startswith(ANY_WORKER):
                return nodeid
            return ONE_WORKER if nodeid.startswith(ONE_WORKER) else super()._split_scope(nodeid)

    return Scheduling(config, log)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    if not item.get_closest_marker("live"):
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in _reports(item, nextitem, item.config.stash[_TRIALS]):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def pytest_terminal_summary(terminalreporter, config):
    if lines := config.stash[_TRIALS]["lines"]:
        terminalreporter.section("the host suspended the cores")
        for line in lines:
            terminalreporter.line(line)


def _reports(item, nextitem, session):
    """Reports of the last trial; skipped if inconclusive."""
    begin, shares = time.monotonic(), []
    while True:
        start, before = time.monotonic(), suspended_time()
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        shares.append((suspended_time() - before) / (os.cpu_count() * (time.monotonic() - start)))
        session["seconds"] += time.monotonic() - start if len(shares) > 1 else 0.0
        failed = [report for report in reports if report.failed]
        over = time.monotonic() - begin > TEST_S or session["seconds"] > SESSION_S
        if not failed or not shares[-1] or len(shares) == MAX_TRIALS or over:
            break
        with contextlib.suppress(Exception):  # of fixtures that failed already
            item.session._setupstate.teardown_exact(None)
    suspended = ", ".join(f"{share:.1%}" for share in shares)
    if failed and min(shares) > SUSPENDED_SHARE:
        reason = f"inconclusive: cores suspended for {suspended} of each trial's time"
        for report in failed:
            last = str(report.longrepr).rstrip().rpartition("\n")[2]
            session["lines"].append(f"{item.nodeid}: {reason}; last: {last}")
            report.outcome, report.longrepr = "skipped", (str(item.path), item.location[1], f"Skipped: {reason}")
    elif len(shares) > 1:
        session["lines"].append(f"{item.nodeid}: {len(shares)} trials, cores suspended for {suspended} of their time")
    return reports
