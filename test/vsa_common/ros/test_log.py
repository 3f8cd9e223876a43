# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Log lines of a node's health: changes of level and status, at most one in LOG_PERIOD for each task."""

import pytest
from vsa_common.ros.diagnostics import ERROR, OK, WARN
from vsa_common.ros.log import LOG_PERIOD, HealthLog


class Logger:
    """Keeps the lines with their severity."""

    def __init__(self):
        self.lines = []

    def info(self, text):
        self.lines.append(("INFO", text))

    def warning(self, text):
        self.lines.append(("WARN", text))

    def error(self, text):
        self.lines.append(("ERROR", text))


@pytest.fixture
def logger():
    return Logger()


def feed(logger, *steps):
    """Lines for steps of (seconds, level, text, values) of one task."""
    log = HealthLog(logger)
    for now, level, text, values in steps:
        log.update({"bus": (level, text, values)}, now)
    return logger.lines


def test_a_healthy_start_logs_nothing(logger):
    assert feed(logger, (0.0, OK, "active", {}), (9.0, OK, "active", {})) == []


def test_each_change_of_level_is_one_line_and_recovery_is_info(logger):
    steps = [(float(s), ERROR if 10 <= s < 20 else OK, "down" if 10 <= s < 20 else "active", {}) for s in range(40)]
    assert feed(logger, *steps) == [("ERROR", "bus: down"), ("INFO", "bus: active")]


def test_a_change_of_status_within_a_level_is_logged_with_its_name(logger):
    stages = [("INITIALIZING", WARN), ("CONVERGING", WARN), ("VALID", OK), ("STALE", ERROR), ("VALID", OK)]
    steps = [(10.0 * i, level, "text", {"status": name}) for i, (name, level) in enumerate(stages)]
    assert feed(logger, *steps) == [
        ("WARN", "bus: INITIALIZING: text"),
        ("WARN", "bus: CONVERGING: text"),
        ("INFO", "bus: VALID: text"),
        ("ERROR", "bus: STALE: text"),
        ("INFO", "bus: VALID: text"),
    ]


def test_a_level_that_alternates_is_logged_at_most_once_in_the_period(logger):
    steps = [(0.2 * i, WARN if i % 2 else OK, "text", {}) for i in range(500)]
    lines = feed(logger, *steps)
    assert 2 <= len(lines) <= 100.0 / LOG_PERIOD + 1


def test_a_change_that_lasts_is_logged_at_the_end_of_the_period(logger):
    steps = [
        (0.0, WARN, "lost", {}),
        (0.2, OK, "active", {}),
        (0.4, ERROR, "down", {}),
        (LOG_PERIOD, ERROR, "down", {}),
    ]
    assert feed(logger, *steps) == [("WARN", "bus: lost"), ("ERROR", "bus: down")]


def test_tasks_are_logged_independently_and_a_restart_begins_at_ok(logger):
    log = HealthLog(logger)
    for _ in range(2):
        log.update({"bus": (OK, "active", {}), "motors": (WARN, "refused", {})}, 5.0)
        log.restart()
    assert logger.lines == 2 * [("WARN", "motors: refused")]
