# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Log of a node: changes of its health, and the end of a node that cannot start."""

import time
from typing import Any

from rclpy.node import Node
from vsa_common.ros.diagnostics import ERROR, OK, WARN, Tasks

LOG_PERIOD = 2.0  # [s] at least between two lines of one task
READER_S = 1.0  # [s] for which a node that cannot start waits for a reader of its log
DELIVERY_S = 0.2  # [s] from the discovery of a reader of the log to the end of the process


class HealthLog:
    """Logs each change of a task's level, or of its value `status`: WARN, ERROR, and INFO on recovery.

    A task has at most one line in `LOG_PERIOD`; a change within that time is logged at its end unless it is over.
    """

    def __init__(self, logger: Any) -> None:
        """`logger` of rclpy."""
        self._logger = logger
        self._logged: dict[str, tuple[tuple[int, object], float]] = {}  # level and status by task, time [s]

    def restart(self) -> None:
        """Start again from level OK: the node has become active or inactive."""
        self._logged.clear()

    def update(self, tasks: Tasks, now: float) -> None:
        """Log what has changed; `now` [s] of a steady clock."""
        for task, (level, message, values) in tasks.items():
            state = level, values.get("status")
            logged, time = self._logged.get(task, ((OK, state[1] if level == OK else None), now - LOG_PERIOD))
            if state == logged or now - time < LOG_PERIOD:
                continue
            self._logged[task] = state, now
            status = f"{values['status']}: " if "status" in values else ""
            line = f"{task}: {status}{message}"
            # one call for each severity: rclpy requires that of a line of code
            if level == ERROR:
                self._logger.error(line)
            elif level == WARN:
                self._logger.warning(line)
            else:
                self._logger.info(line)


def await_log_reader(node: Node) -> None:
    """Return once a reader of /rosout had time to receive the log, or after READER_S without a reader."""
    end = time.monotonic() + READER_S
    while not node.count_subscribers("/rosout"):
        if time.monotonic() > end:
            return
        time.sleep(0.02)
    time.sleep(DELIVERY_S)
